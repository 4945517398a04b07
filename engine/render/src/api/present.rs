//! The renderer's image in a window: the frame is the same as without one, and is shown
//! afterwards.

use gpu::{PresentResult, Swapchain};

use crate::error::Error;
use crate::renderer::Renderer;

impl Renderer {
    /// Shows the newest image in a window that is `window_size` pixels large as far as the caller
    /// knows. An image of another size is scaled and keeps its proportions, between black borders:
    /// [`Renderer::resize`] before the frame fills the window. To be called after
    /// [`Renderer::render`], any number of times. It waits for an image of the window, within the
    /// swapchain's bound.
    ///
    /// # Errors
    /// A window of another device; no image yet, or none since a frame failed; a failure without
    /// a name in [`gpu::PresentSkipped`].
    pub fn present(
        &self,
        window: &mut Swapchain,
        window_size: [u32; 2],
    ) -> Result<PresentResult, Error> {
        Ok(window.show(&self.passes.target, window_size)?)
    }
}
