//! Pictures on their way to files: nobody waits for the GPU to have drawn them.

use std::path::PathBuf;
use std::rc::Rc;

use gpu::{Device, Readback, Tick};

use crate::options::FrameSize;
use crate::picture::write_png;
use crate::run::RunError;

/// A picture that the GPU draws.
struct Pending {
    picture: Rc<Readback>,
    tick: Tick,
    path: PathBuf,
}

/// Pictures that are not written yet.
#[derive(Default)]
pub struct Screenshots {
    pending: Vec<Pending>,
}

impl Screenshots {
    /// A picture that is there when `tick` is over, for the file at `path`.
    pub fn push(&mut self, picture: Rc<Readback>, tick: Tick, path: PathBuf) {
        self.pending.push(Pending { picture, tick, path });
    }

    /// Writes what is there by now; answers the newest file that was written.
    ///
    /// # Errors
    /// A lost device; a file that cannot be written.
    pub fn write_finished(&mut self, device: &Device) -> Result<Option<PathBuf>, RunError> {
        let mut newest = None;
        if self.pending.is_empty() {
            return Ok(newest);
        }
        let completed = device.completed()?;
        let is_there = |pending: &mut Pending| pending.tick <= completed;
        for Pending { picture, path, .. } in self.pending.extract_if(.., is_there) {
            let [width, height] = picture.size();
            write_png(&path, FrameSize { width, height }, picture.rgba8())
                .map_err(RunError::machine)?;
            newest = Some(path);
        }
        Ok(newest)
    }

    /// Waits for the rest and writes it.
    ///
    /// # Errors
    /// As [`Screenshots::write_finished`].
    pub fn finish(&mut self, device: &Device) -> Result<(), RunError> {
        if !self.pending.is_empty() {
            device.drain()?;
        }
        self.write_finished(device).map(|_| ())
    }
}
