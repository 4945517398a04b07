//! The renderer's image in the hands of a host.

use gpu::FinishedImage;

use crate::error::Error;
use crate::renderer::Renderer;

impl Renderer {
    /// Returns the image of the newest frame for a host that samples or copies it by commands of
    /// its own, with the state that it is in and the tick at which it is ready. The host gives it
    /// back before the next frame, as [`FinishedImage`] says, and uses it no longer when the
    /// renderer is resized or dropped.
    ///
    /// # Errors
    /// [`gpu::Error::NoImage`] before the first frame, and after one that failed.
    pub fn finished_image(&self) -> Result<FinishedImage, Error> {
        Ok(self.passes.target.finished()?)
    }
}
