//! The views of a scene.

use cull::{CullConfig, Culler, DrawPhases};
use gpu::Target;

use super::super::CulledScene;
use crate::error::Error;
use crate::occlusion_state::OcclusionState;

impl CulledScene {
    /// Creates a view that knows nothing yet, drawn to `target` in these phases. It weighs tests by
    /// the costs of the scene, if there are any, and by the present triangles per draw. Frames of a
    /// host are not timed, so that nothing corrects the costs.
    ///
    /// # Errors
    /// A failed call.
    pub fn new_view(
        &self,
        target: &Target,
        config: CullConfig,
        draw_phases: DrawPhases,
    ) -> Result<OcclusionState, Error> {
        self.view_of(Culler::with_testers(config, self.testers(target, draw_phases)))
    }

    /// Creates a view with a culler that knows nothing yet, which weighs tests by the costs of the
    /// scene.
    ///
    /// # Errors
    /// A failed call.
    pub fn view_of(&self, mut culler: Culler) -> Result<OcclusionState, Error> {
        self.culling_setup().steer(&mut culler, self.leaves.scene_costs(&self.hierarchy));
        OcclusionState::new(self, culler)
    }
}
