//! What lies flat over every picture.

use crate::error::Error;
use crate::flat_overlay::FlatOverlay;
use crate::renderer::Renderer;

impl Renderer {
    /// Returns what is drawn flat over every picture from now on, made when it is first wanted. It
    /// costs nothing until then, nor after [`Renderer::drop_flat_overlay`].
    ///
    /// # Errors
    /// A shader that does not compile, a failed call.
    pub fn flat_overlay(&mut self) -> Result<&mut FlatOverlay, Error> {
        let overlay = match self.flat_overlay.take() {
            Some(overlay) => overlay,
            None => FlatOverlay::new(&self.device, &self.shaders)?,
        };
        Ok(self.flat_overlay.insert(overlay))
    }

    /// Draws nothing flat any more, and frees what it took.
    pub fn drop_flat_overlay(&mut self) {
        self.flat_overlay = None;
    }
}
