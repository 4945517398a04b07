//! An open window, and one iteration of its loop.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use antumbra::gpu::{
    CancellationToken, DisplayLink, Fallback, Instance, PresentMode, PresentResult, PresentSkipped,
    Surface,
};
use antumbra::pacing::{PacedFrameId, Step, Time};
use egui::ViewportId;
use winit::event::WindowEvent;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::actions::Action;
use super::failures::{check_log, first_error};
use super::gamepad::Gamepads;
use super::input::Input;
use super::leaving::Leaving;
use super::loaded_scene::check_options;
use super::menu::Menu;
use super::pending_scenes::PendingScenes;
use super::pointer::Pointer;
use super::recovery::WindowRecovery;
use super::screen::Screen;
use super::session::{Files, Session};
use super::show::ShowOptions;
use super::source::SceneSource;
use super::title::Title;
use super::window_device::{WindowDevice, WindowOptions};
use bench::run_error::RunError;

/// The interval at which the text over the image changes.
const HUD_INTERVAL: Duration = Duration::from_millis(250);
/// The interval of frames in a hidden window, and of checks of a window without pixels.
const HIDDEN_INTERVAL: Duration = Duration::from_millis(250);
/// The interval of frames while no scene is shown yet, and of text changes during loading.
const WAITING_INTERVAL: Duration = Duration::from_millis(50);

/// The window and the objects that draw in it. Later fields are dropped first.
pub(super) struct Opened {
    pub(super) arrivals: PendingScenes,
    pub(super) session: Session,
    pub(super) screen: Screen,
    pub(super) surface: Surface,
    /// The refresh period of the window's monitor, if it is known.
    pub(super) refresh: Option<Duration>,
    pub(super) recovery: WindowRecovery,
    pub(super) window: Arc<Window>,
    pub(super) instance: Instance,
    pub(super) pointer: Pointer,
    /// The state that translates the window's events for egui.
    egui: egui_winit::State,
    /// The position of the cursor, in pixels from the upper left.
    pub(super) cursor: [f64; 2],
    pub(super) gamepads: Option<Gamepads>,
    /// The opened files, the newest last.
    pub(super) files: Vec<PathBuf>,
    pub(super) leaving: Leaving,
    pub(super) title: Title,
    pub(super) size: [u32; 2],
    pub(super) is_occluded: bool,
    pub(super) is_gone: bool,
    display: DisplayLink,
    /// The fallback of the present mode that was reported last.
    pub(super) fallback: Option<Fallback>,
    pub(super) last_frame: Option<Time>,
    pub(super) next_layout: Time,
    pub(super) not_before: Time,
}

/// The next step of the loop.
pub(super) enum Next {
    At(Time),
    Now,
    End,
}

impl Opened {
    pub(super) fn open(
        event_loop: &ActiveEventLoop,
        source: &SceneSource,
        options: &ShowOptions,
        files: Files,
        cancellation: CancellationToken,
    ) -> Result<Self, RunError> {
        let wanted = WindowOptions {
            title: "Antumbra",
            size: options.size,
            validation: options.validation,
            device: &options.device,
        };
        let opened = WindowDevice::open(event_loop, &wanted)?;
        let WindowDevice { window, display, instance, surface, device, refresh } = opened;
        let size: [u32; 2] = window.inner_size().into();
        let screen = Screen::new(&device, &surface, options.screen(), refresh)?;
        let drawn = size.map(|side| side.max(1));
        check_options(&device, options, drawn)?;
        let (arrivals, loaded) =
            PendingScenes::open(source, &device, options, drawn, cancellation)?;
        let session = Session::new(&device, options, files, loaded)?;
        let context = session.hud.context().clone();
        let egui = egui_winit::State::new(context, ViewportId::ROOT, &window, None, None, None);
        Ok(Self {
            arrivals,
            session,
            screen,
            surface,
            refresh,
            recovery: WindowRecovery::default(),
            window,
            instance,
            pointer: Pointer::default(),
            egui,
            cursor: [0.0; 2],
            gamepads: Gamepads::open(),
            files: source.file().into_iter().cloned().collect(),
            leaving: Leaving::default(),
            title: Title::default(),
            size,
            is_occluded: false,
            is_gone: false,
            display,
            fallback: None,
            last_frame: None,
            next_layout: Time::ZERO,
            not_before: Time::ZERO,
        })
    }

    /// Passes an event of the window to an open list. Returns true if the list consumes it.
    pub(super) fn give_to_list(&mut self, event: &WindowEvent) -> bool {
        // egui must always know the position of the pointer.
        let _repaints = self.egui.on_window_event(&self.window, event);
        let events = std::mem::take(&mut self.egui.egui_input_mut().events);
        if self.session.menu.is_none() {
            return false;
        }
        self.session.hud.take(events);
        self.next_layout = Time::ZERO;
        matches!(event, WindowEvent::MouseInput { .. }) && self.session.hud.is_on_list(self.cursor)
    }

    /// Runs one iteration of the loop, and returns the next step. After the loss of the device it
    /// continues on another one.
    pub(super) fn turn(
        &mut self,
        input: &Input,
        options: &ShowOptions,
        now: Time,
    ) -> Result<Next, RunError> {
        if self.is_gone || self.display.is_lost() {
            return Ok(Next::End);
        }
        let turned = match self.recovery.due() {
            Some(at) if now < at => return Ok(Next::At(at)),
            Some(_) => self.recover(options).map(|()| Next::Now),
            None => self.draw_next(input, options, now),
        };
        turned.or_else(|error| self.plan_recovery(error))
    }

    /// Carries out what waits, and draws a frame if its time has come.
    fn draw_next(
        &mut self,
        input: &Input,
        options: &ShowOptions,
        now: Time,
    ) -> Result<Next, RunError> {
        if self.arrivals.look(&mut self.session)? {
            self.next_layout = now;
        }
        // Frames are counted from the first frame of the first scene on.
        if !self.arrivals.is_first_awaited() {
            if options.frames.is_some_and(|frames| self.session.frame() >= frames) {
                return Ok(Next::End);
            }
            while let Some(action) = self.session.next_scripted() {
                if self.act(action, options)? {
                    return Ok(Next::End);
                }
            }
        }
        while let Some(action) = self.gamepads.as_mut().and_then(Gamepads::next_action) {
            if self.act(action, options)? {
                return Ok(Next::End);
            }
        }
        if self.size.contains(&0) {
            return Ok(Next::At(now.after(HIDDEN_INTERVAL)));
        }
        if now < self.not_before {
            return Ok(Next::At(self.not_before));
        }
        match self.screen.next_step()? {
            Step::Wait(wait) => Ok(Next::At(wait.until)),
            Step::Start(plan) => self.frame(input, plan.frame),
        }
    }

    /// Draws a frame and shows it.
    fn frame(&mut self, input: &Input, frame: PacedFrameId) -> Result<Next, RunError> {
        if !self.screen.is_ready()? {
            self.screen.drop_frame(frame);
            return Ok(Next::Now);
        }
        let now = self.clock_now();
        if self.session.renderer().size() != self.size {
            self.session.resize(self.size)?;
            self.next_layout = now;
        }
        // Set first, so that no measurement under other conditions is attributed to this scene.
        self.session.present_mode = Some(self.screen.swapchain().mode());
        self.screen.follow(self.session.conditions(), frame);
        if self.session.take_stale_page() || now >= self.next_layout {
            let facts = self.screen.facts();
            self.session.lay_out(Some(&facts), self.window.scale_factor() as f32)?;
            let interval = if self.arrivals.is_awaited() { WAITING_INTERVAL } else { HUD_INTERVAL };
            self.next_layout = now.after(interval);
        }
        let seconds =
            self.last_frame.replace(now).map_or(0.0, |last| now.since(last).as_secs_f32());
        if let Some(title) = self.title.count(now, &self.session.title_words()) {
            self.window.set_title(&title);
        }
        let mut steering = input.steering();
        if let Some(gamepads) = &self.gamepads {
            let pad = gamepads.state();
            steering = steering.plus(&pad.steering());
            let [right, down] = pad.turn(seconds);
            if [right, down] != [0.0, 0.0] {
                self.session.turn(right, down);
            }
        }
        self.session.draw(&steering, seconds, None)?;
        let scope = self.session.begin_scope("present");
        let shown = self.screen.show(self.session.renderer(), frame, self.size)?;
        self.session.end_scope(scope);
        self.tell_fallback();
        self.session.after_frame()?;
        if self.is_occluded {
            self.not_before = now.after(HIDDEN_INTERVAL);
        } else if self.arrivals.is_first_awaited() {
            // Loading needs the processor more than an empty sky does.
            self.not_before = now.after(WAITING_INTERVAL);
        }
        match shown {
            PresentResult::Not(PresentSkipped::WindowGone) => Ok(Next::End),
            PresentResult::Not(reason @ PresentSkipped::DeviceLost) => {
                Err(RunError::lost_device(reason))
            }
            PresentResult::Not(PresentSkipped::NoArea) => {
                self.not_before = now.after(HIDDEN_INTERVAL);
                Ok(Next::Now)
            }
            PresentResult::Not(
                PresentSkipped::Hidden | PresentSkipped::OutOfDate | PresentSkipped::SurfaceLost,
            )
            | PresentResult::Presented(_) => Ok(Next::Now),
        }
    }

    /// Carries out an action; returns true if the program should end.
    pub(super) fn act(&mut self, action: Action, options: &ShowOptions) -> Result<bool, RunError> {
        match action {
            Action::Quit => return Ok(true),
            // The present device takes no more actions.
            _ if self.recovery.due().is_some() => return Ok(false),
            Action::Escape => return self.escape(),
            Action::ListScenes => {
                self.session.menu = Some(self.scenes());
            }
            Action::OpenPath => self.session.menu = Some(Menu::path()),
            Action::FullScreen => self.toggle_full_screen(),
            Action::CaptureMouse => {
                let action = self.pointer.toggle_capture();
                self.point(Some(action));
            }
            Action::AnotherDevice => self.change_device(options)?,
            Action::PresentMode(mode) => self.set_mode(mode),
            Action::NextPresentMode => {
                let at = PresentMode::ALL.iter().position(|m| *m == self.screen.wanted_mode());
                let next = at.map_or(0, |at| (at + 1) % PresentMode::ALL.len());
                self.set_mode(PresentMode::ALL[next]);
            }
            _ => {
                self.session.act(action)?;
                self.load_lit(options);
                self.screen.set_frames_in_flight(self.session.frames_in_flight())?;
            }
        }
        self.next_layout = Time::ZERO;
        Ok(false)
    }

    fn set_mode(&mut self, mode: PresentMode) {
        self.screen.set_mode(mode);
        self.fallback = None;
        self.session.tell(format!("present mode {mode}"));
    }

    /// Reports the present mode if it differs from the requested one, which is known once the
    /// window has images.
    fn tell_fallback(&mut self) {
        let fallback = self.screen.swapchain().fallback();
        if let Some(Fallback { wanted, taken }) = fallback
            && self.fallback != fallback
        {
            self.session.refuse(format!("this window has no {wanted}; it is {taken} instead"));
        }
        self.fallback = fallback;
    }

    pub(super) fn clock_now(&self) -> Time {
        self.session.clock.now()
    }

    /// Writes the remaining files, and destroys the window and its objects.
    pub(super) fn close(self, options: &ShowOptions) -> Result<(), RunError> {
        let Self { arrivals, session, mut screen, surface, window, instance, .. } = self;
        // Pending loads are cancelled before the device is destroyed.
        drop(arrivals);
        tracing::info!("{}", super::page_text::in_short(&screen.facts()));
        let finished = session.finish(options);
        drop((screen, surface, window));
        let log = instance.validation_log().clone();
        drop(instance);
        first_error([finished, check_log(&log)])
    }
}
