//! A capture of one frame with RenderDoc, if its library is loaded.

use std::ptr::null;

use renderdoc::{RenderDoc, V100};

use bench::run_error::RunError;

/// The capture of a frame.
pub struct Capture {
    renderdoc: RenderDoc<V100>,
    frame: u32,
    is_running: bool,
}

impl Capture {
    /// Prepares to capture this frame. Must be called before the device is created.
    ///
    /// # Errors
    /// RenderDoc's library is not loaded into this program.
    pub fn new(frame: u32) -> Result<Self, RunError> {
        let renderdoc = RenderDoc::new().map_err(|error| {
            RunError::machine(format!(
                "--capture needs the library of RenderDoc in this program ({error}): start it from RenderDoc, or with `renderdoccmd capture`"
            ))
        })?;
        Ok(Self { renderdoc, frame, is_running: false })
    }

    /// Begins the capture if `frame` is the requested one.
    pub fn begin(&mut self, frame: u32) {
        if frame == self.frame && !self.is_running {
            self.renderdoc.start_frame_capture(null(), null());
            self.is_running = true;
        }
    }

    /// Ends the capture, after the frame was submitted, and presented if there is a window. Returns
    /// true if the frame was captured.
    pub fn end(&mut self) -> bool {
        if std::mem::take(&mut self.is_running) {
            self.renderdoc.end_frame_capture(null(), null());
            return true;
        }
        false
    }
}
