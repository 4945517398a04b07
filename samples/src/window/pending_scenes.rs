//! Scenes that are loaded while the window is open: the first scene, and files dropped into the
//! window.

use antumbra::gpu::{CancellationToken, Device};

use super::actions::Action;
use super::loaded_scene::{LoadedScene, SceneLoader};
use super::loading::Loading;
use super::session::{LightingRequest, Session};
use super::show::ShowOptions;
use super::source::SceneSource;
use bench::run_error::{Blame, RunError};

const DROP_ONE: &str = "drop a file (.glb, .gltf, .stl or .obj) into this window";

/// The scene that is loading.
pub struct PendingScenes {
    loading: Option<Loading>,
    /// The action that waits for the current scene with lights, which is then loading.
    waiting_for_lights: Option<Action>,
    /// True until the first scene of the window is shown.
    is_first: bool,
    /// True if the message about an empty window was shown.
    is_invited: bool,
}

impl PendingScenes {
    /// Returns the pending scenes, and the scene to show first. A file is loaded in the background,
    /// and an empty sky is shown until then; other scenes are generated before this returns.
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

    /// Returns true if a scene is loading.
    pub fn is_awaited(&self) -> bool {
        self.loading.is_some()
    }

    /// Begins to load or generate another scene, and cancels a previous one.
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

    /// Begins again, on another device, to load what was being loaded on a lost one.
    pub fn restart(
        &mut self,
        device: &Device,
        options: &ShowOptions,
        size: [u32; 2],
    ) -> Result<(), RunError> {
        if let Some(loading) = &self.loading {
            let source = loading.source().clone();
            self.loading = Some(Loading::start(device, &source, options, size)?);
        }
        Ok(())
    }

    /// Begins to generate the current scene with lights, for an action that requires them. If this
    /// is already in progress, the action replaces the previous one.
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

    /// Checks for loaded scenes, and shows them in `session`. Returns true if there is progress to
    /// show.
    ///
    /// # Errors
    /// The first scene cannot be shown; a failed device. Another file that cannot be shown only
    /// causes a message.
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
        if let Err(error) = &shown
            && error.blame == Blame::LostDevice
        {
            // It is loaded again once there is another device.
            self.waiting_for_lights = action;
            return shown.map(|()| true);
        }
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
