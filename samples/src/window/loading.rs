//! A scene that is loading on a thread of its own, while the frame loop goes on.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use antumbra::gpu::Device;

use super::loaded_scene::LoadedScene;
use super::show::ShowOptions;
use super::source::SceneSource;
use bench::run_error::RunError;
use bench::scene_file::{self, LoadProgress};

/// The progress of loading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadingStatus {
    /// The current step.
    pub what: String,
    /// The finished fraction of it, 0 to 1, if it is known.
    pub fraction: Option<f32>,
}

/// The state that both threads share.
#[derive(Default)]
struct Shared {
    progress: Mutex<LoadingStatus>,
    is_given_up: AtomicBool,
}

/// A scene that is being loaded or made. Dropping it gives it up and waits for that: the device
/// outlives it.
pub struct Loading {
    source: SceneSource,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Result<LoadedScene, RunError>>>,
}

impl Loading {
    /// Begins to load or make the scene of `source` for frames of `size`.
    ///
    /// # Errors
    /// When the system has no thread for it.
    pub fn start(
        device: &Device,
        source: &SceneSource,
        options: &ShowOptions,
        size: [u32; 2],
    ) -> Result<Self, RunError> {
        let shared = Arc::new(Shared::default());
        let (device, options, own) = (device.clone(), options.clone(), source.clone());
        let theirs = Arc::clone(&shared);
        let load = move || {
            let mut progress_fn = |progress: LoadProgress<'_>| {
                let progress =
                    LoadingStatus { what: progress.what.to_owned(), fraction: progress.fraction };
                *theirs.progress.lock().unwrap_or_else(PoisonError::into_inner) = progress;
                match theirs.is_given_up.load(Ordering::Relaxed) {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                }
            };
            match &own {
                SceneSource::Made { made, path, hour } => {
                    scene_file::report_progress(&mut progress_fn, "making the scene", None)?;
                    LoadedScene::made(&device, (made, path.as_ref(), *hour), &options, size)
                }
                SceneSource::Courtyard { hour } => {
                    LoadedScene::courtyard(&device, *hour, &options, size)
                }
                SceneSource::File { file, settings } => LoadedScene::of_file(
                    &device,
                    (file, settings),
                    &options,
                    size,
                    &mut progress_fn,
                ),
                SceneSource::Nothing { .. } => LoadedScene::empty(&device, &options, size),
            }
        };
        let thread = thread::Builder::new().name("loading".to_owned()).spawn(load);
        let thread =
            thread.map_err(|error| RunError::machine(format!("cannot start a thread: {error}")))?;
        Ok(Self { source: source.clone(), shared, thread: Some(thread) })
    }

    /// Returns the source that is loaded.
    pub fn source(&self) -> &SceneSource {
        &self.source
    }

    /// Returns the progress.
    pub fn progress(&self) -> LoadingStatus {
        self.shared.progress.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Returns the result, once it is known.
    pub fn finished(&mut self) -> Option<Result<LoadedScene, RunError>> {
        let thread = self.thread.take_if(|thread| thread.is_finished())?;
        let crashed = |_| RunError::machine(format!("loading {} failed", self.source.name()));
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
