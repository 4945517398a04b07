//! The change to another scene; all settings of the user are kept.

use std::path::Path;

use antumbra::render::FrameReport;

use crate::window::actions::Action;
use crate::window::fly_camera::FlyCamera;
use crate::window::loaded_scene::LoadedScene;
use crate::window::loading::LoadingStatus;
use crate::window::selection::Selection;
use crate::window::session::Session;
use crate::window::source::SceneSource;
use bench::run_error::RunError;
use bench::strategy::Strategy;
use bench::terminal::shown;

impl Session {
    /// Shows `loaded` from its first frame on. The previous scene is freed when the GPU has
    /// finished with it.
    ///
    /// # Errors
    /// A device that fails; then the previous scene stays.
    pub fn enter(&mut self, loaded: LoadedScene) -> Result<(), RunError> {
        self.replace(loaded)?;
        self.fly = FlyCamera::new(self.scene_view.start, self.scene_view.speed_m);
        self.seen_from = self.scene_view.start;
        self.frame = 0;
        Ok(())
    }

    /// Shows `loaded`, the same scene with lights, from the current camera, and carries out the
    /// action that requires lights.
    ///
    /// # Errors
    /// A device that fails; then the previous scene stays.
    pub fn light_up(&mut self, loaded: LoadedScene, action: Action) -> Result<(), RunError> {
        let is_followed = self.scene_view.camera(self.frame, self.renderer.size()).is_some();
        self.replace(loaded)?;
        if !is_followed {
            self.scene_view.take_over();
        }
        match action {
            // The scene already has an hour.
            Action::NextHour => self.tell_hour(),
            action => self.act(action)?,
        }
        Ok(())
    }

    /// Replaces the scene.
    fn replace(&mut self, loaded: LoadedScene) -> Result<(), RunError> {
        let LoadedScene { mut renderer, mut scene_view, daylight, lit } = loaded;
        if renderer.size() != self.renderer.size() {
            renderer.resize(self.renderer.size())?;
        }
        renderer.set_frames_in_flight(self.renderer.frames_in_flight())?;
        if self.is_timing_passes {
            renderer.time_passes()?;
        }
        let mut history = renderer.new_view()?;
        if let Some(detail) = &scene_view.detail {
            detail.watch(&mut history)?;
        }
        // A scene may have lower limits: settings that cannot draw it are replaced.
        let strategy = match renderer.supports(self.strategy) {
            Ok(()) => self.strategy,
            Err(error) => {
                self.refuse(error.to_string());
                Strategy::ANTUMBRA
            }
        };
        let notes = std::mem::take(&mut scene_view.notes);
        self.stop_recording()?;
        self.finish_comparison()?;
        (self.renderer, self.history, self.strategy) = (renderer, history, strategy);
        self.scene_view = scene_view;
        self.daylight = daylight;
        self.lit = lit;
        self.waiting_for_lights = None;
        self.selection = Selection::default();
        self.frozen = None;
        self.search_view = None;
        self.outcome = None;
        self.report = FrameReport::default();
        self.scene += 1;
        self.viewed.clear();
        if let Some(trace) = &mut self.trace {
            trace.forget_submitted();
        }
        for note in &notes {
            tracing::warn!("{}: {note}", shown(Path::new(&self.scene_view.name)));
        }
        self.tell_notes(notes);
        self.update_debug_overlay()
    }

    /// Shows once which parts of a file are left out, and the keys to try next.
    fn tell_notes(&mut self, notes: Vec<String>) {
        let others = notes.len().saturating_sub(1);
        let more = (others > 0).then(|| format!("... and {others} more, see the log"));
        let lines = notes.into_iter().take(1).chain(more).chain(self.scene_view.hint.take());
        let text = lines.collect::<Vec<_>>().join("\n");
        if !text.is_empty() {
            self.tell(text);
        }
    }

    /// Shows the progress of a loading scene; `None` removes it.
    pub fn await_scene(&mut self, progress: Option<LoadingStatus>) {
        self.awaited = progress;
    }

    /// Shows a message until another one replaces it.
    pub fn keep_telling(&mut self, text: String) {
        self.toast.keep_telling(text);
    }

    /// Shows the error of a source until another message replaces it.
    pub fn refuse_source(&mut self, source: &SceneSource, error: &RunError) {
        self.toast.keep_telling(format!("{} cannot be shown: {error}", source.name()));
    }
}
