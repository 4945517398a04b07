//! The renderer's image for use by a host.

use gpu::FinishedImage;

use crate::error::Error;
use crate::renderer::Renderer;

impl Renderer {
    /// Returns the image of the newest frame, for a host that samples or copies it by its own
    /// commands. The result contains the state of the image and the tick at which it is ready. The
    /// host returns the image before the next frame, as [`FinishedImage`] describes, and does not
    /// use it after the renderer is resized or dropped.
    ///
    /// # Errors
    /// [`gpu::Error::NoImage`] before the first frame and after a frame that failed.
    pub fn finished_image(&self) -> Result<FinishedImage, Error> {
        Ok(self.passes.target.finished()?)
    }
}
