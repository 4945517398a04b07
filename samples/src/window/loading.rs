//! A file on its way from the disk to the device, on a thread of its own: the frame loop goes on.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use gpu::Device;

use super::show::ShowOptions;
use super::source::FileSource;
use super::stage::Stage;
use crate::run::RunError;

/// How far it has come.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub what: String,
    /// How much of that is done, 0 to 1, where it is known.
    pub fraction: Option<f32>,
}

/// What both threads look at.
#[derive(Default)]
struct Shared {
    progress: Mutex<Progress>,
    is_given_up: AtomicBool,
}

/// A file that is being loaded. Dropped, it is given up, which is waited for: the device outlives it.
pub struct Loading {
    file: PathBuf,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Result<Stage, RunError>>>,
}

impl Loading {
    /// Begins to load `file` for frames of `size`.
    ///
    /// # Errors
    /// When the system has no thread for it.
    pub fn start(
        device: &Device,
        file: &Path,
        settings: FileSource,
        options: &ShowOptions,
        size: [u32; 2],
    ) -> Result<Self, RunError> {
        let shared = Arc::new(Shared::default());
        let (device, options, own) = (device.clone(), options.clone(), file.to_owned());
        let theirs = Arc::clone(&shared);
        let load = move || {
            Stage::of_file(&device, (&own, &settings), &options, size, &mut |told| {
                let progress = Progress { what: told.what.to_owned(), fraction: told.fraction };
                *theirs.progress.lock().unwrap_or_else(PoisonError::into_inner) = progress;
                match theirs.is_given_up.load(Ordering::Relaxed) {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                }
            })
        };
        let thread = thread::Builder::new().name("loading".to_owned()).spawn(load);
        let thread =
            thread.map_err(|error| RunError::machine(format!("cannot start a thread: {error}")))?;
        Ok(Self { file: file.to_owned(), shared, thread: Some(thread) })
    }

    /// What is loaded.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// How far it has come.
    pub fn progress(&self) -> Progress {
        self.shared.progress.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// What became of it, once that is known.
    pub fn finished(&mut self) -> Option<Result<Stage, RunError>> {
        let thread = self.thread.take_if(|thread| thread.is_finished())?;
        let crashed = |_| RunError::machine(format!("loading {} failed", self.file.display()));
        Some(thread.join().unwrap_or_else(|panic| Err(crashed(panic))))
    }
}

impl Drop for Loading {
    fn drop(&mut self) {
        self.shared.is_given_up.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _whatever_became_of_it = thread.join();
        }
    }
}
