//! The frames of a scene.

use gpu::Frame;

use super::super::CulledScene;
use crate::error::Error;
use crate::frame_scope::FrameScope;

impl CulledScene {
    /// Begins to record the scene into a frame. Records the upload of all changes since the last
    /// frame, before anything of `frame` reads them. The scope borrows the scene, which therefore
    /// cannot change before the [end](FrameScope::end).
    ///
    /// # Errors
    /// [`gpu::Error::TooLarge`] for more draws than the device takes; no memory, a failed call.
    /// Nothing is lost: the next frame uploads the same changes.
    pub fn begin<'ring>(
        &mut self,
        mut frame: Frame<'ring>,
    ) -> Result<FrameScope<'_, 'ring>, Error> {
        self.upload(&mut frame)?;
        Ok(FrameScope::new(self, frame))
    }
}
