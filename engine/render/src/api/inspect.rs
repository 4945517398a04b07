//! Calls that inspect a renderer.

use crate::debug::sample_counts::{COUNTING, check_counts};
use crate::error::Error;
use crate::renderer::Renderer;
use crate::shading::scene_degradations::SceneDegradations;

impl Renderer {
    /// Returns the parts of the scene that are shown in a degraded form; for still parts it is
    /// known from the beginning.
    pub fn degradations(&self) -> SceneDegradations {
        let surfaces = self.passes.geometry.surfaces.as_ref();
        surfaces.map(|surfaces| surfaces.degradations()).unwrap_or_default()
    }
}

impl Renderer {
    /// Checks that the device counts samples, for
    /// [`ViewState::watch`](crate::ViewState::watch).
    ///
    /// # Errors
    /// [`gpu::Error::Unsupported`], with the name of what is missing.
    pub fn supports_counts(&self) -> Result<(), Error> {
        check_counts(&self.device, COUNTING)
    }
}
