//! Loads a scene on a separate thread while the frame loop continues.

use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use antumbra::gpu::{CancellationToken, Device};

use super::loaded_scene::{LoadedScene, SceneLoader};
use super::show::ShowOptions;
use super::source::SceneSource;
use bench::run_error::RunError;
use bench::scene_file::LoadProgress;

/// The progress of loading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadingStatus {
    /// The current step.
    pub what: String,
    /// The finished fraction of the step, 0 to 1, if it is known.
    pub fraction: Option<f32>,
}

/// A scene that is being loaded or generated. Dropping it cancels loading and waits for the end, so
/// the device outlives it.
pub struct Loading {
    source: SceneSource,
    progress: Arc<Mutex<LoadingStatus>>,
    cancellation: CancellationToken,
    thread: Option<JoinHandle<Result<LoadedScene, RunError>>>,
}

impl Loading {
    /// Begins to load or generate the scene of `source` for frames of `size`.
    ///
    /// # Errors
    /// When the system cannot start a thread.
    pub fn start(
        device: &Device,
        source: &SceneSource,
        options: &ShowOptions,
        size: [u32; 2],
    ) -> Result<Self, RunError> {
        let progress = Arc::<Mutex<LoadingStatus>>::default();
        let cancellation = CancellationToken::new();
        let device = device.clone();
        let options = options.clone();
        let own = source.clone();
        let shown = Arc::clone(&progress);
        let theirs = cancellation.clone();
        let load = move || {
            let loader =
                SceneLoader { device: &device, options: &options, size, cancellation: theirs };
            loader.load(&own, &mut |told: LoadProgress<'_>| {
                let status = LoadingStatus { what: told.what.to_owned(), fraction: told.fraction };
                *shown.lock().unwrap_or_else(PoisonError::into_inner) = status;
            })
        };
        let thread = thread::Builder::new().name("loading".to_owned()).spawn(load);
        let thread =
            thread.map_err(|error| RunError::machine(format!("cannot start a thread: {error}")))?;
        Ok(Self { source: source.clone(), progress, cancellation, thread: Some(thread) })
    }

    /// Returns the source that is loaded.
    pub fn source(&self) -> &SceneSource {
        &self.source
    }

    /// Returns the progress.
    pub fn progress(&self) -> LoadingStatus {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Returns the result, once it is available.
    pub fn finished(&mut self) -> Option<Result<LoadedScene, RunError>> {
        let thread = self.thread.take_if(|thread| thread.is_finished())?;
        let crashed = |_| RunError::machine(format!("loading {} failed", self.source.name()));
        Some(thread.join().unwrap_or_else(|panic| Err(crashed(panic))))
    }
}

impl Drop for Loading {
    fn drop(&mut self) {
        self.cancellation.cancel();
        if let Some(thread) = self.thread.take() {
            let _whatever_became_of_it = thread.join();
        }
    }
}
