//! Images that are written to files without waiting for the GPU.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use antumbra::gpu::{Device, Readback, Tick};

use bench::options::FrameSize;
use bench::png_file::write_png;
use bench::run_error::RunError;
use bench::terminal::output::say_wrote;

/// An image that the GPU is drawing.
struct Pending {
    image: Rc<Readback>,
    tick: Tick,
    path: PathBuf,
}

/// Images that are not written yet.
#[derive(Default)]
pub struct Screenshots {
    pending: Vec<Pending>,
    lost: Option<Lost>,
}

/// Images that could not be written.
struct Lost {
    count: u32,
    /// The reason for the first one.
    reason: String,
}

impl Screenshots {
    /// Adds an image that can be read once `tick` has completed, for the file at `path`.
    pub fn push(&mut self, image: Rc<Readback>, tick: Tick, path: PathBuf) {
        self.pending.push(Pending { image, tick, path });
    }

    /// Gives up the images that a lost device was drawing;
    /// [`finish`](Self::finish) reports them.
    pub fn give_up(&mut self) {
        let count = self.pending.drain(..).count() as u32;
        if count > 0 {
            let reason = "the device was lost before it was drawn".to_owned();
            self.lost.get_or_insert(Lost { count: 0, reason }).count += count;
        }
    }

    /// Writes the images that can be read; returns the newest written file.
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
        let mut failed = None;
        let finished: Vec<Pending> = self.pending.extract_if(.., is_there).collect();
        for Pending { image, path, .. } in finished {
            match self.write(&image, &path) {
                Ok(path) => newest = Some(path),
                Err(error) => failed = Some(error),
            }
        }
        failed.map_or(Ok(newest), Err)
    }

    /// Writes an image that was read back, under a free name. Returns its path.
    ///
    /// # Errors
    /// A file that cannot be written; [`finish`](Self::finish) reports it, too.
    pub fn write(&mut self, image: &Readback, path: &Path) -> Result<PathBuf, RunError> {
        let [width, height] = image.size();
        let written = image.rgba8().map_err(RunError::from).and_then(|pixels| {
            write_png(path, FrameSize { width, height }, &pixels).map_err(RunError::machine)
        });
        match &written {
            Ok(path) => say_wrote(path),
            Err(error) => {
                let reason = error.to_string();
                self.lost.get_or_insert(Lost { count: 0, reason }).count += 1;
            }
        }
        written
    }

    /// Waits for the remaining images and writes them.
    ///
    /// # Errors
    /// A lost device; an image that could not be written, at this or an earlier time.
    pub fn finish(&mut self, device: &Device) -> Result<(), RunError> {
        let is_over = if self.pending.is_empty() { Ok(()) } else { device.wait_idle() };
        let written = is_over.map_err(RunError::from).and_then(|_| self.write_finished(device));
        match &self.lost {
            Some(Lost { count: 1, reason }) => Err(RunError::machine(reason)),
            Some(Lost { count, reason }) => {
                Err(RunError::machine(format!("{count} images are lost; the first: {reason}")))
            }
            None => written.map(|_| ()),
        }
    }
}
