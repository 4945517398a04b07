//! Scenes that are loaded while the window is open: the first one, and files dropped into it.

use antumbra::gpu::{CancellationToken, Device};

use super::actions::Action;
use super::loaded_scene::{LoadedScene, SceneLoader};
use super::loading::Loading;
use super::session::{LightingRequest, Session};
use super::show::ShowOptions;
use super::source::SceneSource;
use bench::run_error::RunError;

const DROP_ONE: &str = "drop a file (.glb, .gltf, .stl or .obj) into this window";

/// The scenes that are loading.
pub struct PendingScenes {
    loading: Option<Loading>,
    /// The action that waits for the same scene with lights, which is loading then.
    waiting_for_lights: Option<Action>,
    /// True until the scene for which the window was opened is shown.
    is_first: bool,
    /// True if the message about an empty window was shown.
    is_invited: bool,
}

impl PendingScenes {
    /// Returns the loading scenes, and the one to show at once.
    ///
    /// # Errors
    /// A scene that cannot be made; a device that fails.
    pub fn open(
        source: &SceneSource,
        device: &Device,
        options: &ShowOptions,
        size: [u32; 2],
        cancellation: CancellationToken,
    ) -> Result<(Self, LoadedScene), RunError> {
        let loader = SceneLoader { device, options, size, cancellation };
        let loaded = match source {
            SceneSource::File { .. } => loader.empty()?,
            source => loader.load(source, &mut |_| {})?,
        };
        let loading = match source {
            SceneSource::File { .. } => Some(Loading::start(device, source, options, size)?),
            SceneSource::Made { .. }
            | SceneSource::Courtyard { .. }
            | SceneSource::Nothing { .. } => None,
        };
        let is_first = loading.is_some();
        let is_invited = !matches!(source, SceneSource::Nothing { .. });
        Ok((Self { loading, waiting_for_lights: None, is_first, is_invited }, loaded))
    }

    /// Returns true if the window still waits for its first scene.
    pub fn is_first_awaited(&self) -> bool {
        self.is_first
    }

    /// Returns true if any scene is loading.
    pub fn is_awaited(&self) -> bool {
        self.loading.is_some()
    }

    /// Begins to load or make another scene, in place of any other that is loading.
    ///
    /// # Errors
    /// When the system has no thread for it.
    pub fn load(
        &mut self,
        device: &Device,
        source: &SceneSource,
        options: &ShowOptions,
        size: [u32; 2],
    ) -> Result<(), RunError> {
        self.loading = None;
        self.waiting_for_lights = None;
        self.loading = Some(Loading::start(device, source, options, size)?);
        self.is_first = false;
        Ok(())
    }

    /// Begins to make the scene that is shown with lights, for an action that needs them; where it
    /// is being made already, the action takes the place of the one before.
    ///
    /// # Errors
    /// When the system has no thread for it.
    pub fn load_lit(
        &mut self,
        device: &Device,
        request: &LightingRequest,
        options: &ShowOptions,
        size: [u32; 2],
    ) -> Result<(), RunError> {
        if self.waiting_for_lights.is_none() {
            self.load(device, &request.source, options, size)?;
        }
        self.waiting_for_lights = Some(request.action);
        Ok(())
    }

    /// Checks for loaded scenes, and makes `session` show them; returns true if there is any
    /// progress to show.
    ///
    /// # Errors
    /// The first scene cannot be shown; a failed device. Another file that cannot be shown leaves
    /// the scene as it is, with a message.
    pub fn look(&mut self, session: &mut Session) -> Result<bool, RunError> {
        if !std::mem::replace(&mut self.is_invited, true) {
            session.keep_telling(DROP_ONE.to_owned());
        }
        let Some(loading) = &mut self.loading else { return Ok(false) };
        session.await_scene(Some(loading.progress()));
        let Some(arrived) = loading.finished() else { return Ok(false) };
        let action = self.waiting_for_lights.take();
        let shown = arrived.and_then(|loaded| match action {
            Some(action) => session.light_up(loaded, action),
            None => session.enter(loaded),
        });
        session.await_scene(None);
        let is_first = std::mem::take(&mut self.is_first);
        match (shown, self.loading.take()) {
            (Err(error), Some(loading)) if !is_first => {
                session.refuse_source(loading.source(), &error)
            }
            (shown, _) => shown?,
        }
        Ok(true)
    }
}
