//! The effects of actions on a session. Actions on the window do nothing here.

use antumbra::render;
use antumbra::render::DebugOverlay;

use crate::hud::HudLevel;
use crate::window::actions::Action;
use crate::window::menu;
use crate::window::scene_view::SceneView;
use crate::window::session::Session;
use bench::options::MAX_FRAMES_IN_FLIGHT;
use bench::recorded_path::RecordedPath;
use bench::run_error::RunError;
use bench::strategy::{Strategy, strategies};
use bench::terminal::{output::say_wrote, shown};

const GPU_KNOWS: &str =
    "only the GPU knows what pyramid draws: choose another strategy to see its decisions";

/// A panel over the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Panel {
    /// A list or field.
    Menu,
    /// All keys.
    Help,
    /// The description of the selected object.
    Object,
}

impl Session {
    /// Carries out the action, or shows in the image why that is impossible.
    ///
    /// # Errors
    /// When the device fails.
    pub fn act(&mut self, action: Action) -> Result<(), RunError> {
        match action {
            Action::NextStrategy => self.choose_next_strategy(),
            Action::Strategy(strategy) => self.choose(strategy),
            Action::NextFramesInFlight => {
                let next = self.renderer.frames_in_flight() as u32 % MAX_FRAMES_IN_FLIGHT + 1;
                self.set_frames_in_flight(next)?;
            }
            Action::FramesInFlight(count) => self.set_frames_in_flight(count)?,
            Action::Freeze => self.freeze()?,
            Action::Identify(pixel) => self.identify(pixel),
            Action::Compare => self.toggle_comparison()?,
            action if self.needs_lights(action) => self.waiting_for_lights = Some(action),
            Action::NextHour => self.set_hour(None)?,
            Action::Hour(hour) => self.set_hour(Some(hour))?,
            Action::NextShadows => self.choose_next_shadows(),
            Action::Shadows(way) => self.choose_shadows(way),
            Action::NextFilter => self.choose_next_filter(),
            Action::Filter(filter) => self.choose_filter(filter),
            Action::Flares => self.toggle_flares(),
            Action::Pictures => self.toggle_pictures()?,
            Action::DetailBySamples => self.toggle_detail_by_samples()?,
            Action::TopDown => {
                self.has_top_down = !self.has_top_down;
                self.update_debug_overlay()?;
                self.tell_if_overlay_is_empty();
            }
            Action::Boxes => {
                self.debug_overlay.has_boxes = !self.debug_overlay.has_boxes;
                self.update_debug_overlay()?;
                self.tell_if_overlay_is_empty();
            }
            Action::Wireframe => self.explain(DebugOverlay {
                has_wireframe: !self.debug_overlay.has_wireframe,
                ..self.debug_overlay
            }),
            Action::DepthComplexity => {
                self.explain(DebugOverlay {
                    has_depth_complexity: !self.debug_overlay.has_depth_complexity,
                    ..self.debug_overlay
                });
                self.tell_if_overlay_is_empty();
            }
            Action::TimePasses => self.toggle_times(),
            Action::Screenshot => self.wants_screenshot = true,
            Action::Record => self.toggle_recording(),
            Action::Hud => self.hud_level = self.hud_level.next(),
            Action::Pause => self.answer(SceneView::toggle_pause),
            Action::Step => self.answer(SceneView::step),
            Action::NextClip => self.answer(SceneView::next_clip),
            Action::AllClips => self.answer(SceneView::all_clips),
            Action::Camera(number) => self.answer(|scene_view| scene_view.look_through(number)),
            Action::ListStrategies => {
                let can = |strategy| self.renderer.supports(strategy).is_ok();
                self.menu = Some(menu::strategies(can, self.strategy));
            }
            Action::Help => self.has_help = !self.has_help,
            Action::Escape => self.close_panel()?,
            Action::NextPresentMode
            | Action::PresentMode(_)
            | Action::ListScenes
            | Action::OpenPath
            | Action::FullScreen
            | Action::CaptureMouse
            | Action::AnotherDevice
            | Action::Quit => {}
        }
        Ok(())
    }

    /// Returns the panel over the image that Esc would close.
    pub fn topmost_panel(&self) -> Option<Panel> {
        let panels = [
            (self.menu.is_some(), Panel::Menu),
            (self.has_help, Panel::Help),
            (self.selection.object.is_some(), Panel::Object),
        ];
        panels.into_iter().find_map(|(is_open, panel)| is_open.then_some(panel))
    }

    /// Closes the topmost panel over the image.
    ///
    /// # Errors
    /// When the device fails.
    pub fn close_panel(&mut self) -> Result<(), RunError> {
        match self.topmost_panel() {
            Some(Panel::Menu) => self.menu = None,
            Some(Panel::Help) => self.has_help = false,
            Some(Panel::Object) => self.deselect()?,
            None => {}
        }
        Ok(())
    }

    /// Carries out a request to the view of the scene, and shows its result.
    fn answer(&mut self, ask: impl FnOnce(&mut SceneView) -> Result<String, String>) {
        match ask(&mut self.scene_view) {
            Ok(told) => self.tell(told),
            Err(reason) => self.refuse(reason),
        }
    }

    /// Shows a message in the image.
    pub fn tell(&mut self, text: String) {
        self.toast.tell(self.clock.now(), text);
    }

    /// Shows an error in the image, even without the HUD.
    pub fn refuse(&mut self, text: String) {
        self.toast.refuse(self.clock.now(), text);
    }

    /// Returns the number of frames in flight.
    pub fn frames_in_flight(&self) -> usize {
        self.renderer.frames_in_flight()
    }

    fn choose_next_strategy(&mut self) {
        let all = strategies();
        let at = all.iter().position(|strategy| *strategy == self.strategy).unwrap_or(0);
        let others = (1..=all.len()).map(|step| all[(at + step) % all.len()]);
        let can = |strategy: &Strategy| {
            !strategy.needs_still_scene() && self.renderer.supports(*strategy).is_ok()
        };
        if let Some(next) = others.into_iter().find(can) {
            self.choose(next);
        }
    }

    fn choose(&mut self, strategy: Strategy) {
        if strategy.needs_still_scene() {
            let reason = "draws visible sets found in advance, and here there are none";
            return self.refuse(format!("{strategy} {reason}"));
        }
        match self.renderer.supports(strategy) {
            Ok(()) => {
                self.strategy = strategy;
                self.tell(format!("strategy {strategy}"));
                self.tell_if_overlay_is_empty();
            }
            Err(error) => self.refuse(error.to_string()),
        }
    }

    /// Explains why an active debug overlay shows nothing.
    fn tell_if_overlay_is_empty(&mut self) {
        let DebugOverlay { has_boxes, has_depth_complexity, .. } = self.debug_overlay;
        let is_on = self.has_top_down || has_boxes || has_depth_complexity;
        if is_on && self.strategy.is_gpu_driven() {
            self.refuse(GPU_KNOWS.to_owned());
        }
    }

    fn set_frames_in_flight(&mut self, count: u32) -> Result<(), RunError> {
        self.renderer.set_frames_in_flight(count as usize)?;
        if let Some(trace) = &mut self.trace {
            trace.forget_submitted();
        }
        self.tell(format!("{count} frames in flight"));
        Ok(())
    }

    fn freeze(&mut self) -> Result<(), RunError> {
        if self.frozen.take().is_some() {
            self.search_again()?;
            self.tell("the culling goes on".to_owned());
            return Ok(());
        }
        if self.frame == 0 {
            self.refuse("there is nothing to freeze yet".to_owned());
            return Ok(());
        }
        if self.strategy.is_gpu_driven() {
            self.refuse(GPU_KNOWS.to_owned());
            return Ok(());
        }
        self.finish_comparison()?;
        let view = self.renderer.view_of(&self.seen_from);
        self.search_again()?;
        match self.renderer.snapshot(&mut self.history, view) {
            Ok(snapshot) => self.frozen = Some(snapshot),
            Err(render::Error::ViewOfLostDevice) => {
                self.refuse("there is nothing to freeze yet on this device".to_owned());
                return Ok(());
            }
            Err(error) => return Err(error.into()),
        }
        let boxes = if self.debug_overlay.has_boxes {
            "; the boxes are those that stayed hidden"
        } else {
            ""
        };
        self.tell(format!("the culling is frozen; fly on and look at it{boxes}"));
        Ok(())
    }

    /// Shows another debug overlay, or the reason why the device cannot.
    fn explain(&mut self, debug_overlay: DebugOverlay) {
        let before = std::mem::replace(&mut self.debug_overlay, debug_overlay);
        if let Err(error) = self.update_debug_overlay() {
            self.debug_overlay = before;
            self.refuse(error.to_string());
        }
    }

    fn toggle_times(&mut self) {
        if self.is_timing_passes {
            self.is_timing_passes = false;
            return;
        }
        match self.renderer.time_passes() {
            Ok(()) => {
                self.is_timing_passes = true;
                // The details list them.
                if self.hud_level == HudLevel::Compact {
                    self.hud_level = HudLevel::Detailed;
                }
            }
            Err(error) => self.refuse(error.to_string()),
        }
    }

    fn toggle_recording(&mut self) {
        if self.recording.is_none() {
            self.recording = Some(RecordedPath::default());
            self.seconds = 0.0;
            self.tell("recording the path; the same key ends it".to_owned());
        } else if let Err(error) = self.stop_recording() {
            let text = format!("{error} It is recorded on; the same key tries again");
            self.toast.keep_telling(text);
        }
    }

    /// Writes the path that is being recorded. If that fails, the recording continues.
    pub(crate) fn stop_recording(&mut self) -> Result<(), RunError> {
        let Some(recorded) = self.recording.take() else { return Ok(()) };
        if recorded.frames().is_empty() {
            self.tell("no frame was recorded".to_owned());
            return Ok(());
        }
        let path = self.folder.join(format!("path_{:05}.txt", self.frame));
        match recorded.write(&path) {
            Ok(path) => {
                say_wrote(&path);
                self.tell(format!("{} frames in {}", recorded.frames().len(), shown(&path)));
                Ok(())
            }
            Err(error) => {
                self.recording = Some(recorded);
                Err(RunError::machine(error))
            }
        }
    }
}
