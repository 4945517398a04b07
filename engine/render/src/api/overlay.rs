//! The flat overlay over every image.

use crate::debug::flat_overlay::FlatOverlay;
use crate::error::Error;
use crate::renderer::Renderer;

impl Renderer {
    /// Returns the overlay that is drawn flat over every image from now on, created by the first
    /// call. It costs nothing until then, nor after [`Renderer::drop_flat_overlay`].
    ///
    /// # Errors
    /// A shader that does not compile, a failed call.
    pub fn flat_overlay(&mut self) -> Result<&mut FlatOverlay, Error> {
        self.passes.pipelines.flat.prepare(&self.device, &self.shaders)?;
        Ok(self.flat_overlay.get_or_insert_with(|| FlatOverlay::new(&self.device)))
    }

    /// Removes the flat overlay and frees its memory.
    pub fn drop_flat_overlay(&mut self) {
        self.flat_overlay = None;
    }
}
