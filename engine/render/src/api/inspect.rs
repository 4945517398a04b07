//! Calls that inspect a renderer.

use ::shadows::ShadowMethod;

use crate::debug::sample_counts::{COUNTING, check_counts};
use crate::error::Error;
use crate::renderer::Renderer;
use crate::shading::scene_degradations::SceneDegradations;

impl Renderer {
    /// Returns the parts of the scene that are shown in a degraded form, with the present shadows.
    /// For parts that do not move it is known from the beginning.
    pub fn degradations(&self) -> SceneDegradations {
        let geometry = &self.passes.gpu_scene.geometry;
        let Some(surfaces) = &geometry.surfaces else { return SceneDegradations::default() };
        let planes = self.section().planes().len();
        let (unshadowed_objects, planes_without_shadows) = match self.shadows().method {
            ShadowMethod::Volumes => (geometry.masked_objects(), planes),
            ShadowMethod::Off | ShadowMethod::Maps => (0, 0),
        };
        let of_surfaces = surfaces.degradations();
        SceneDegradations { unshadowed_objects, planes_without_shadows, ..of_surfaces }
    }
}

impl Renderer {
    /// Checks that the device counts samples, for
    /// [`RenderView::watch`](crate::RenderView::watch).
    ///
    /// # Errors
    /// [`gpu::Error::Unsupported`], with the name of what is missing.
    pub fn supports_counts(&self) -> Result<(), Error> {
        check_counts(&self.device, COUNTING)
    }
}
