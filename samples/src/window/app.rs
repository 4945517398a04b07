//! The program in its window: winit's events in, frames out when the pacer says so.

use std::sync::Arc;
use std::time::{Duration, Instant};

use gpu::{
    Device, DeviceOptions, Fallback, Instance, NotShown, PresentMode, Shown, Surface, WindowSystem,
};
use pacing::{FrameId, Step, Time};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{DeviceEvent, DeviceId, ElementState, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{CursorGrabMode, Window, WindowId};

use super::arrivals::Arrivals;
use super::clock::Clock;
use super::deeds::Deed;
use super::input::Input;
use super::screen::Screen;
use super::session::{Files, Session};
use super::show::ShowOptions;
use super::signals::Signals;
use super::source::Source;
use crate::run::{self, RunError};

/// Text over the picture changes so often.
const HUD_INTERVAL: Duration = Duration::from_millis(250);
/// So far a wheel without notches turns for one.
const PIXELS_A_NOTCH: f32 = 40.0;
/// Frames of a window that nobody sees, and looks at one without a pixel, come so often.
const HIDDEN_INTERVAL: Duration = Duration::from_millis(250);
/// Frames come so often while there is nothing to show yet, and text while something is on its way.
const WAITING_INTERVAL: Duration = Duration::from_millis(50);
/// Nothing wakes the loop for a signal: it sleeps at most that long.
const LONGEST_SLEEP: Duration = Duration::from_millis(250);

/// Runs in a window until that is closed, or a signal comes.
///
/// # Errors
/// No display, or one that fails; a device or a file that is not what it should be; messages of the validation layer.
pub fn run(
    source: &Source,
    options: &ShowOptions,
    files: Files,
    signals: &Signals,
) -> Result<(), RunError> {
    let event_loop = EventLoop::new().map_err(no_display)?;
    let mut app = App {
        source,
        options,
        signals,
        files: Some(files),
        opened: None,
        input: Input::default(),
        clock: Clock,
        outcome: Ok(()),
    };
    let failed = |error| RunError::machine(format!("the window system failed: {error}"));
    let ran = event_loop.run_app(&mut app).map_err(failed);
    let App { opened, outcome, .. } = app;
    let closed = opened.map_or(Ok(()), |opened| opened.close(options));
    super::first_error([outcome, ran, closed])
}

fn no_display(error: impl std::fmt::Display) -> RunError {
    // winit says first where in its own text that was found out.
    let text = error.to_string();
    let reason = text.rsplit_once(".rs:").map_or(text.as_str(), |(_, found)| {
        found.trim_start_matches(|c: char| c.is_ascii_digit() || c == ':' || c == ' ')
    });
    let reason = reason.trim_end_matches('.');
    RunError::machine(format!(
        "there is no display to open a window on ({reason}); --headless does without"
    ))
}

/// What winit calls.
struct App<'a> {
    source: &'a Source,
    options: &'a ShowOptions,
    signals: &'a Signals,
    files: Option<Files>,
    opened: Option<Opened>,
    input: Input,
    clock: Clock,
    outcome: Result<(), RunError>,
}

/// The window and what draws in it. What is made later goes first.
struct Opened {
    arrivals: Arrivals,
    session: Session,
    screen: Screen,
    window: Arc<Window>,
    instance: Instance,
    size: [u32; 2],
    is_occluded: bool,
    is_gone: bool,
    /// The one that was told.
    fallback: Option<Fallback>,
    last_frame: Option<Time>,
    next_layout: Time,
    not_before: Time,
}

/// What the loop does next.
enum Next {
    At(Time),
    Now,
    End,
}

impl Opened {
    fn open(
        event_loop: &ActiveEventLoop,
        source: &Source,
        options: &ShowOptions,
        files: Files,
    ) -> Result<Self, RunError> {
        let size = PhysicalSize::new(options.size.width, options.size.height);
        let attributes = Window::default_attributes().with_title("Antumbra").with_inner_size(size);
        let window = Arc::new(event_loop.create_window(attributes).map_err(no_display)?);
        let system = WindowSystem::of(&window)?;
        let instance = run::open_instance(options.validation, Some(system))?;
        let surface = Surface::new(&instance, Arc::clone(&window) as Arc<dyn gpu::Window>)?;
        let wanted = run::wanted(&options.device);
        let adapter = instance.pick_adapter_for(&surface, wanted.as_deref())?;
        let device_options =
            DeviceOptions { pipeline_cache: run::pipeline_cache_file(), ..Default::default() };
        let device = Device::new(&instance, &adapter, &device_options)?;
        let size: [u32; 2] = window.inner_size().into();
        let monitor = window.current_monitor();
        let rate = monitor.and_then(|monitor| monitor.refresh_rate_millihertz());
        let refresh = rate
            .filter(|rate| *rate > 0)
            .map(|rate| Duration::from_secs_f64(1e3 / f64::from(rate)));
        let screen = Screen::new(&device, &surface, options, refresh)?;
        let drawn = size.map(|side| side.max(1));
        let (arrivals, stage) = Arrivals::open(source, &device, options, drawn)?;
        let session = Session::new(&device, options, files, stage)?;
        Ok(Self {
            arrivals,
            session,
            screen,
            window,
            instance,
            size,
            is_occluded: false,
            is_gone: false,
            fallback: None,
            last_frame: None,
            next_layout: Time::ZERO,
            not_before: Time::ZERO,
        })
    }

    /// One turn of the loop.
    fn turn(&mut self, input: &Input, options: &ShowOptions, now: Time) -> Result<Next, RunError> {
        if self.is_gone {
            return Ok(Next::End);
        }
        if self.arrivals.look(&mut self.session)? {
            self.next_layout = now;
        }
        // Frames count from the first one of what is to be shown.
        if !self.arrivals.is_first_awaited() {
            if options.frames.is_some_and(|frames| self.session.frame() >= frames) {
                return Ok(Next::End);
            }
            while let Some(deed) = self.session.next_scripted() {
                if self.act(deed)? {
                    return Ok(Next::End);
                }
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
    fn frame(&mut self, input: &Input, frame: FrameId) -> Result<Next, RunError> {
        if !self.screen.is_ready()? {
            self.screen.drop_frame(frame);
            return Ok(Next::Now);
        }
        let now = self.clock_now();
        if self.session.renderer().size() != self.size {
            self.session.resize(self.size)?;
            self.next_layout = now;
        }
        if now >= self.next_layout {
            let facts = self.screen.facts();
            self.session.lay_out(Some(&facts), self.window.scale_factor() as f32)?;
            let interval = if self.arrivals.is_awaited() { WAITING_INTERVAL } else { HUD_INTERVAL };
            self.next_layout = now.after(interval);
        }
        let seconds =
            self.last_frame.replace(now).map_or(0.0, |last| now.since(last).as_secs_f32());
        self.session.draw(&input.steering(), seconds, None)?;
        let scope = self.session.begin_scope("present");
        let shown = self.screen.show(self.session.renderer(), frame, self.size)?;
        self.session.end_scope(scope);
        self.tell_fallback();
        self.session.after_frame()?;
        if self.is_occluded {
            self.not_before = now.after(HIDDEN_INTERVAL);
        } else if self.arrivals.is_first_awaited() {
            // What is on its way needs the machine more than an empty sky.
            self.not_before = now.after(WAITING_INTERVAL);
        }
        match shown {
            Shown::Not(NotShown::WindowGone) => Ok(Next::End),
            Shown::Not(reason @ NotShown::DeviceLost) => Err(RunError::machine(reason)),
            Shown::Not(NotShown::NoArea) => {
                self.not_before = now.after(HIDDEN_INTERVAL);
                Ok(Next::Now)
            }
            Shown::Not(NotShown::Hidden | NotShown::OutOfDate | NotShown::SurfaceLost)
            | Shown::Presented(_) => Ok(Next::Now),
        }
    }

    /// Does a deed; answers whether it was the end.
    fn act(&mut self, deed: Deed) -> Result<bool, RunError> {
        match deed {
            Deed::Quit => return Ok(true),
            Deed::PresentMode(mode) => self.set_mode(mode),
            Deed::NextPresentMode => {
                let at = PresentMode::ALL.iter().position(|m| *m == self.screen.wanted_mode());
                let next = at.map_or(0, |at| (at + 1) % PresentMode::ALL.len());
                self.set_mode(PresentMode::ALL[next]);
            }
            _ => {
                self.session.act(deed)?;
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

    /// Says which present mode it is, if not the one that was wanted. That is known when the window has
    /// its images.
    fn tell_fallback(&mut self) {
        let fallback = self.screen.swapchain().fallback();
        if let Some(Fallback { wanted, taken }) = fallback
            && self.fallback != fallback
        {
            self.session.refuse(format!("this window has no {wanted}; it is {taken} instead"));
        }
        self.fallback = fallback;
    }

    fn clock_now(&self) -> Time {
        self.session.clock.now()
    }

    /// The mouse looks around, or is free again.
    fn grab(&self, is_looking: bool) {
        let (first, second) = match is_looking {
            true => (CursorGrabMode::Locked, CursorGrabMode::Confined),
            false => (CursorGrabMode::None, CursorGrabMode::None),
        };
        // Not every window system can; looking around works all the same, up to the edge.
        let _free =
            self.window.set_cursor_grab(first).or_else(|_| self.window.set_cursor_grab(second));
        self.window.set_cursor_visible(!is_looking);
    }

    /// Writes what is left, and tears all down.
    fn close(self, options: &ShowOptions) -> Result<(), RunError> {
        let Self { arrivals, session, mut screen, window, instance, .. } = self;
        // Whatever is on its way is given up before the device goes.
        drop(arrivals);
        tracing::info!("{}", super::page_text::in_short(&screen.facts()));
        let finished = session.finish(options);
        drop((screen, window));
        let log = instance.validation_log().clone();
        drop(instance);
        super::first_error([finished, super::check_log(&log)])
    }
}

impl App<'_> {
    /// Goes on, or ends with what went wrong.
    fn follow(&mut self, event_loop: &ActiveEventLoop, result: Result<Next, RunError>) {
        match result {
            Ok(Next::Now) => event_loop.set_control_flow(ControlFlow::Poll),
            Ok(Next::At(at)) => {
                let wait = at.since(self.clock.now()).min(LONGEST_SLEEP);
                event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + wait));
            }
            Ok(Next::End) => event_loop.exit(),
            Err(error) => {
                self.outcome = Err(error);
                event_loop.exit();
            }
        }
    }
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let Some(files) = self.files.take() else { return };
        match Opened::open(event_loop, self.source, self.options, files) {
            Ok(opened) => self.opened = Some(opened),
            Err(error) => self.follow(event_loop, Err(error)),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(opened) = &mut self.opened else { return };
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Destroyed => {
                opened.is_gone = true;
                event_loop.exit();
            }
            WindowEvent::Resized(size) => opened.size = size.into(),
            WindowEvent::Occluded(is_occluded) => {
                opened.is_occluded = is_occluded;
                opened.not_before = Time::ZERO;
            }
            WindowEvent::Focused(false) => {
                self.input.release();
                opened.grab(false);
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => {
                if let Some(deed) = self.input.key(&event) {
                    match opened.act(deed) {
                        Ok(false) => {}
                        Ok(true) => event_loop.exit(),
                        Err(error) => self.follow(event_loop, Err(error)),
                    }
                }
            }
            WindowEvent::MouseWheel { delta, .. } => opened.session.hasten(match delta {
                MouseScrollDelta::LineDelta(_, notches) => notches,
                MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / PIXELS_A_NOTCH,
            }),
            WindowEvent::DroppedFile(file) => {
                let size = opened.session.renderer().size();
                let device = opened.session.renderer().device().clone();
                let settings = self.source.settings_for_another();
                let begun = opened.arrivals.load(&device, &file, settings, self.options, size);
                if let Err(error) = begun {
                    opened.session.refuse_file(&file, &error);
                }
            }
            WindowEvent::MouseInput { state, .. } => {
                self.input.is_looking = state == ElementState::Pressed;
                opened.grab(self.input.is_looking);
            }
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let (DeviceEvent::MouseMotion { delta: (right, down) }, true, Some(opened)) =
            (event, self.input.is_looking, &mut self.opened)
        {
            opened.session.turn(right, down);
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let now = self.clock.now();
        if let Some(opened) = &mut self.opened
            && !event_loop.exiting()
        {
            let next = match self.signals.received() {
                Some(_) => Ok(Next::End),
                None => opened.turn(&self.input, self.options, now),
            };
            self.follow(event_loop, next);
        }
    }
}
