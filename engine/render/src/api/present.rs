//! Presentation of the renderer's image in a window, after the frame.

use gpu::{PresentResult, Swapchain};

use crate::error::Error;
use crate::renderer::Renderer;

impl Renderer {
    /// Shows the newest image in a window. `window_size` is the window's size in pixels as the
    /// caller knows it. An image of another size is scaled with its proportions, between black
    /// borders; call [`Renderer::resize`] before the frame to fill the window. Call this method
    /// after [`Renderer::render`], any number of times. It waits for an image of the window, at
    /// most for the swapchain's time limit.
    ///
    /// # Errors
    /// A window of another device; no image yet, or a frame that failed since; a failure that
    /// [`gpu::PresentSkipped`] does not name.
    pub fn present(
        &self,
        window: &mut Swapchain,
        window_size: [u32; 2],
    ) -> Result<PresentResult, Error> {
        Ok(window.show(&self.passes.target, window_size)?)
    }
}
