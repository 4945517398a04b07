//! The views of a scene.

use cull::Culler;
use gpu::Target;

use super::super::CulledScene;
use crate::error::Error;
use crate::occlusion_state::OcclusionState;

impl CulledScene {
    /// Creates a view without history, drawn to `target`. It weighs tests by the costs of the
    /// scene, if there are any, and by the present number of triangles per draw. Frames of a host
    /// are not timed, so nothing corrects these costs.
    ///
    /// # Errors
    /// A failed call.
    pub fn new_view(&self, target: &Target) -> Result<OcclusionState, Error> {
        let testers = self.testers(target, self.draw_phases);
        self.view_of(Culler::with_testers(self.cull_config, testers))
    }

    /// Creates a view around a culler without history. The culler weighs tests by the costs of the
    /// scene.
    ///
    /// # Errors
    /// A failed call.
    pub fn view_of(&self, mut culler: Culler) -> Result<OcclusionState, Error> {
        self.culling_setup().steer(&mut culler, self.leaves.scene_costs(&self.hierarchy));
        OcclusionState::new(self, culler)
    }
}
