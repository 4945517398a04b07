//! The program without its window: a scene, a camera, and one frame at a time on request.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::rc::Rc;

use antumbra::cull::{Camera, FrameId};
use antumbra::gpu::{Device, PresentMode, Readback, Tick};
use antumbra::pacing::Time;
use antumbra::render;
use antumbra::render::{
    DebugOverlay, FrameReport, FrameStats, Rect, RenderView, Renderer, ShaderSet,
    VisibilitySnapshot,
};

use super::actions::Action;
use super::capture::Capture;
use super::clock::Clock;
use super::comparison::Comparison;
use super::failures::first_error;
use super::fly_camera::{FlyCamera, Steering};
use super::frame_times::FrameTimeSeries;
use super::loaded_scene::LoadedScene;
use super::loading::LoadingStatus;
use super::menu::Menu;
use super::profiler::{Profiler, Scope};
use super::scene_view::SceneView;
use super::screenshots::Screenshots;
use super::script::Script;
use super::selection::Selection;
use super::shader_watch::ShaderWatch;
use super::show::{FlareChoice, ShowOptions};
use super::source::SceneSource;
use super::title::TitleWords;
use super::toast::Toast;
use super::trace::Trace;
use crate::hud::{Hud, HudLevel, HudOverlay};
use bench::recorded_path::RecordedPath;
use bench::run_error::RunError;
use bench::strategy::Strategy;
use bench::terminal::{output::say_wrote, shown};
use scenes::Daylight;

/// A session: one run of a program.
pub struct Session {
    pub(super) clock: Clock,
    pub(super) renderer: Renderer,
    pub(super) history: RenderView,
    pub(super) strategy: Strategy,
    /// The number of the next frame.
    pub(super) frame: u32,
    /// The number of the frame whose time has begun.
    pub(super) begun: Option<u32>,
    pub(super) fly: FlyCamera,
    pub(super) scene_view: SceneView,
    /// The lights of the scene that change with the hour.
    pub(super) daylight: Option<Daylight>,
    /// The source of the same scene with lights that change with the hour, if such lights are
    /// possible but not loaded.
    pub(super) lit: Option<SceneSource>,
    /// The action that waits for these lights.
    pub(super) waiting_for_lights: Option<Action>,
    /// The lens flares of scenes with such lights.
    pub(super) flares: FlareChoice,
    /// The progress of another scene that is loading.
    pub(super) awaited: Option<LoadingStatus>,
    pub(super) frozen: Option<VisibilitySnapshot>,
    /// The view that finds objects while the culling is frozen.
    pub(super) search_view: Option<RenderView>,
    /// The camera of the newest frame.
    pub(super) seen_from: Camera,
    pub(super) debug_overlay: DebugOverlay,
    /// The running comparison of frames with and without culling.
    pub(super) comparison: Option<Comparison>,
    pub(super) selection: Selection,
    /// The open list or field.
    pub(super) menu: Option<Menu>,
    /// The clicked row of the list.
    pub(super) clicked_row: Option<usize>,
    pub(super) has_top_down: bool,
    pub(super) hud_level: HudLevel,
    /// True if the page of all keys is open.
    pub(super) has_help: bool,
    /// True if the text over the image is outdated.
    pub(super) is_page_stale: bool,
    pub(super) hud: Hud,
    /// The triangles of the HUD over images.
    pub(super) overlay: HudOverlay,
    pub(super) toast: Toast,
    pub(super) times: FrameTimeSeries,
    /// The present mode of the window.
    pub(super) present_mode: Option<PresentMode>,
    /// The number of the scene.
    pub(super) scene: u32,
    /// The cameras of the newest frames, oldest first.
    pub(super) viewed: VecDeque<(FrameId, Camera)>,
    /// The time of the newest screenshot.
    pub(super) photographed: Option<Time>,
    pub(super) report: FrameReport,
    pub(super) outcome: Option<FrameStats>,
    pub(super) is_timing_passes: bool,
    pub(super) wants_screenshot: bool,
    pub(super) screenshots: Screenshots,
    pub(super) recording: Option<RecordedPath>,
    pub(super) seconds: f64,
    pub(super) folder: PathBuf,
    pub(super) watch: Option<ShaderWatch>,
    pub(super) trace: Option<Trace>,
    profiler: Profiler,
    pub(super) capture: Option<Capture>,
    script: Script,
}

impl Session {
    /// Creates a session that shows `loaded`.
    ///
    /// # Errors
    /// A device that fails.
    pub fn new(
        device: &Device,
        options: &ShowOptions,
        files: Files,
        loaded: LoadedScene,
    ) -> Result<Self, RunError> {
        let LoadedScene { mut renderer, scene_view, daylight, lit } = loaded;
        renderer.supports(options.strategy)?;
        if options.times_passes {
            renderer.time_passes()?;
        }
        let start = scene_view.start;
        let clock = Clock;
        let mut history = renderer.new_view()?;
        if let Some(detail) = &scene_view.detail {
            detail.watch(&mut history)?;
        }
        Ok(Self {
            clock,
            history,
            strategy: options.strategy,
            frame: 0,
            begun: None,
            fly: FlyCamera::new(start, scene_view.speed_m),
            scene_view,
            daylight,
            lit,
            waiting_for_lights: None,
            flares: options.flares,
            awaited: None,
            frozen: None,
            search_view: None,
            seen_from: start,
            debug_overlay: DebugOverlay::default(),
            comparison: None,
            selection: Selection::default(),
            menu: None,
            clicked_row: None,
            has_top_down: false,
            hud_level: options.hud,
            has_help: false,
            is_page_stale: false,
            hud: Hud::default(),
            overlay: HudOverlay::new(device),
            toast: Toast::default(),
            times: FrameTimeSeries::default(),
            present_mode: None,
            scene: 0,
            viewed: VecDeque::new(),
            photographed: None,
            report: FrameReport::default(),
            outcome: None,
            is_timing_passes: options.times_passes,
            wants_screenshot: false,
            screenshots: Screenshots::default(),
            recording: None,
            seconds: 0.0,
            folder: options.out.clone().unwrap_or_else(|| PathBuf::from(".")),
            watch: options.shaders.clone().map(ShaderWatch::new),
            trace: options.trace.as_ref().map(|_| Trace::new(device)).transpose()?,
            profiler: Profiler::start(),
            capture: files.capture,
            script: files.script,
            renderer,
        })
    }

    /// Returns the number of the next frame.
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// Returns the names of the scene, the strategy, and the unit of the frame rate.
    pub fn title_words(&self) -> TitleWords<'_> {
        let unit = self.comparison.as_ref().map_or("frames/s", |_| "pairs/s");
        TitleWords { scene: &self.scene_view.name, strategy: self.strategy.name(), unit }
    }

    /// Returns the renderer.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Returns the next action of the script for the next frame.
    pub fn next_scripted(&mut self) -> Option<Action> {
        self.script.next_before(self.frame)
    }

    /// Returns true once if the text over the image is outdated.
    pub fn take_stale_page(&mut self) -> bool {
        std::mem::take(&mut self.is_page_stale)
    }

    /// Turns the view by a movement of the mouse, and ends the camera's path.
    pub fn turn(&mut self, right: f64, down: f64) {
        self.take_over();
        self.fly.turn(right, down);
    }

    /// Changes the camera's speed by this number of notches of a wheel.
    pub fn hasten(&mut self, notches: f32) {
        self.fly.hasten(notches);
        self.tell(format!("speed {:.2} m/s", self.fly.speed_m()));
    }

    /// Lets the user steer from now on.
    fn take_over(&mut self) {
        if self.scene_view.take_over() {
            self.fly.go_to(self.seen_from);
        }
    }

    /// Changes the size of images.
    ///
    /// # Errors
    /// A size that the device does not support; not enough memory.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<(), RunError> {
        self.renderer.resize(size)?;
        self.update_debug_overlay()
    }

    /// Returns the camera of the next frame, `seconds` after the last one.
    fn camera(&mut self, steering: &Steering, seconds: f32) -> Camera {
        if *steering != (Steering { hurries: steering.hurries, ..Steering::default() }) {
            self.take_over();
        }
        if let Some(camera) = self.scene_view.camera(self.frame, self.renderer.size()) {
            return camera;
        }
        self.fly.fly(steering, seconds);
        self.fly.camera()
    }

    /// Draws the newest frame again with the next call, because its image was lost.
    pub fn repeat_frame(&mut self) {
        self.frame = self.begun.unwrap_or(self.frame);
    }

    /// Draws the next frame, `seconds` after the last one, and copies it to `image`, if there is
    /// one. Each frame is copied to a single buffer, from which a screenshot is written, too. So
    /// before reusing a buffer, a caller must wait for its frame and call [`Session::after_frame`].
    ///
    /// # Errors
    /// When the device fails, or a file cannot be written.
    pub fn draw(
        &mut self,
        steering: &Steering,
        seconds: f32,
        image: Option<&Rc<Readback>>,
    ) -> Result<Tick, RunError> {
        let scope = self.begin_scope("render");
        let began = scope.began;
        // A frame that a lost device did not finish shows the same moment again.
        let is_repeated = self.begun.replace(self.frame) == Some(self.frame);
        let seconds = if is_repeated { 0.0 } else { seconds };
        self.follow_selection()?;
        // Decisions do not change while the culling is frozen, so the scene must not change either.
        if self.frozen.is_none() {
            self.scene_view.advance(seconds);
        }
        let camera = self.camera(steering, seconds);
        if self.frozen.is_none() {
            // The debug overlay may show the scene from above, which needs all poses.
            let is_only = self.debug_overlay == DebugOverlay::default();
            self.scene_view.show(&mut self.renderer, is_only.then_some(&camera))?;
            if let Some(detail) = &self.scene_view.detail {
                detail.choose(&mut self.renderer, camera, &self.history)?;
            }
            self.follow_flares(camera.eye)?;
        }
        self.seconds += f64::from(seconds);
        if let Some(recording) = &mut self.recording {
            recording.push(self.seconds, camera);
        }
        if let Some(capture) = &mut self.capture {
            capture.begin(self.frame);
        }
        let screenshot = self.screenshot(image)?;
        let own = screenshot.as_ref().map(|(image, _)| image);
        let wanted = image.or(own).map(Rc::as_ref);
        self.times.follow(self.conditions());
        self.times.push(began);
        let tick = match &self.frozen {
            Some(snapshot) => {
                let tick = self.renderer.render_snapshot(
                    snapshot,
                    camera,
                    wanted,
                    self.overlay.shown(),
                )?;
                self.trace_submit(scope, false)?;
                tick
            }
            None => {
                let tick = self.render(camera, seconds, wanted)?;
                self.measure(camera);
                self.trace_submit(scope, true)?;
                tick
            }
        };
        if let Some((image, path)) = screenshot {
            self.screenshots.push(image, tick, path);
        }
        self.seen_from = camera;
        self.frame += 1;
        Ok(tick)
    }

    /// Returns the buffer for the requested screenshot (`image` if there is one) and its file.
    fn screenshot(
        &mut self,
        image: Option<&Rc<Readback>>,
    ) -> Result<Option<(Rc<Readback>, PathBuf)>, RunError> {
        if !std::mem::take(&mut self.wants_screenshot) {
            return Ok(None);
        }
        let image = match image {
            Some(image) => Rc::clone(image),
            None => Rc::new(Readback::new(self.renderer.device(), self.renderer.size())?),
        };
        self.photographed = Some(self.clock.now());
        let name = format!("{}_{:05}.png", self.scene_view.name, self.frame);
        Ok(Some((image, self.folder.join(name))))
    }

    /// Begins a scope with this name for traces and profilers; [`Session::end_scope`] ends it.
    pub fn begin_scope(&self, name: &'static str) -> Scope {
        Scope::begin(name, self.clock.now())
    }

    /// Ends a scope.
    pub fn end_scope(&mut self, scope: Scope) {
        if let Some(trace) = &mut self.trace {
            trace.cpu(scope.name, scope.began, self.clock.now());
        }
    }

    fn trace_submit(&mut self, scope: Scope, has_times: bool) -> Result<(), RunError> {
        let began = scope.began;
        let known = self.clock.now();
        self.end_scope(scope);
        let passes = if has_times { self.renderer.pass_times() } else { &[] };
        self.profiler.frame(passes);
        if let Some(trace) = &mut self.trace {
            trace.submitted(began, known, self.renderer.frames_in_flight(), passes)?;
        }
        Ok(())
    }

    /// Finishes a frame that was submitted, and presented if there is a window: writes images that
    /// can be read, and checks the shaders for changes.
    ///
    /// # Errors
    /// When the device fails.
    pub fn after_frame(&mut self) -> Result<(), RunError> {
        let now = self.clock.now();
        if self.capture.as_mut().is_some_and(Capture::end) {
            self.toast.tell(now, "RenderDoc captured the frame".to_owned());
        }
        match self.screenshots.write_finished(self.renderer.device()) {
            Ok(None) => {}
            Ok(Some(path)) => self.toast.tell(now, format!("wrote {}", shown(&path))),
            Err(error) => self.toast.keep_telling(error.to_string()),
        }
        if let Some(watch) = &mut self.watch
            && watch.has_changed(now)
        {
            let loaded = ShaderSet::compiled_from(watch.folder());
            match loaded
                .map_err(render::Error::from)
                .and_then(|shaders| self.renderer.reload(shaders))
            {
                Ok(()) => {
                    self.toast.shaders_work();
                    self.toast.tell(now, "new shaders".to_owned());
                }
                Err(error) => self.toast.shaders_are_broken(error.to_string()),
            }
        }
        Ok(())
    }

    /// Shows the active debug overlay, with the view from above in the lower right.
    pub(super) fn update_debug_overlay(&mut self) -> Result<(), RunError> {
        let corner = corner(self.renderer.size()).filter(|_| self.has_top_down);
        self.debug_overlay.top_down = corner;
        if self.renderer.debug_overlay() != self.debug_overlay {
            self.renderer.set_debug_overlay(self.debug_overlay)?;
        }
        Ok(())
    }

    /// Writes the remaining files: the recorded path, pending images, the trace. A failure does not
    /// prevent the others from being written.
    ///
    /// # Errors
    /// A file or an earlier screenshot that cannot be written.
    pub fn finish(mut self, options: &ShowOptions) -> Result<(), RunError> {
        let compared = self.finish_comparison();
        let recording = self.stop_recording();
        let screenshots = self.screenshots.finish(self.renderer.device());
        let trace = match (&self.trace, &options.trace) {
            (Some(trace), Some(path)) => {
                trace.write(path).map(|()| say_wrote(path)).map_err(RunError::machine)
            }
            _ => Ok(()),
        };
        first_error([compared, recording, screenshots, trace])
    }
}

/// The request to load the current scene with lights that change with the hour.
#[derive(Clone, Debug)]
pub struct LightingRequest {
    /// The source of the scene with lights.
    pub source: SceneSource,
    /// The action that waits for the scene.
    pub action: Action,
}

/// The files that a session needs, opened before the device is created.
pub struct Files {
    /// The script of actions.
    pub script: Script,
    /// The capture of a frame.
    pub capture: Option<Capture>,
}

impl Files {
    /// Reads the files that the options name.
    ///
    /// # Errors
    /// A file that cannot be read, or has invalid contents.
    pub fn open(source: &SceneSource, options: &ShowOptions) -> Result<Self, RunError> {
        if let Some(file) = source.recorded_path() {
            RecordedPath::read(file)?;
        }
        let script = options.script.as_deref().map(Script::read).transpose()?;
        let capture = options.capture.map(Capture::new).transpose()?;
        Ok(Self { script: script.unwrap_or_default(), capture })
    }
}

/// Returns the lower right corner of an image.
fn corner(size: [u32; 2]) -> Option<Rect> {
    let [width, height] = size.map(|side| side * 2 / 5);
    let area = Rect { origin: [size[0] - width, size[1] - height], size: [width, height] };
    area.fits(size).then_some(area)
}
