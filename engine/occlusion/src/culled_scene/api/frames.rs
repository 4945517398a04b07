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
    /// A frame of another device; [`Error::FramesInFlight`], [`Error::OtherRing`];
    /// [`gpu::Error::TooLarge`] for more draws than the device takes; no memory, a failed call. The
    /// frame is given up then, so that its command buffer must not be submitted. No change is lost:
    /// the next frame uploads it.
    pub fn begin<'ring>(
        &mut self,
        mut frame: Frame<'ring>,
    ) -> Result<FrameScope<'_, 'ring>, Error> {
        self.device.check(&frame, "a scene (`CulledScene`)")?;
        let ring = frame.frames_in_flight();
        let scene = self.frames_in_flight();
        if ring > scene {
            return Err(Error::FramesInFlight { ring, scene });
        }
        if *self.ring.get_or_insert(frame.ring()) != frame.ring() {
            return Err(Error::OtherRing);
        }
        self.upload(&mut frame)?;
        Ok(FrameScope::new(self, frame))
    }
}
