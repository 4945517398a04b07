//! An open window: interaction with a session, and its frames.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use antumbra::cull::Aabb;
use antumbra::glam::Vec2;
use antumbra::gpu::{DisplayLink, Instance, PresentMode, PresentResult, PresentSkipped, Surface};
use antumbra::pacing::{PacedFrameId, Step, Time};
use bench::choices::DeviceChoice;
use bench::options::FrameSize;
use bench::outputs::OutputFile;
use bench::run;
use bench::run_error::RunError;
use egui::{Context, Popup, Rect, ViewportId};
use samples::hud::{HudFrame, HudOverlay, Measures};
use samples::window::clock::Clock;
use samples::window::failures::check_log;
use samples::window::recovery::WindowRecovery;
use samples::window::screen::{Screen, ScreenOptions};
use samples::window::window_device::{WindowDevice, WindowOptions};
use winit::event::{ElementState, MouseScrollDelta, WindowEvent};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::{Fullscreen, Window};

use super::camera_path::OrbitPath;
use super::context::InteractionContext;
use super::input::InputEvent;
use super::interaction::Interaction;
use super::panel::{PanelPage, ToolPanel};
use super::signs;
use super::tools::Tools;
use crate::args::WorkshopArguments;
use crate::inputs::{files_of, keep_inputs};
use crate::orbit::OrbitCamera;
use crate::report::{CommandOutcome, ScriptReport, ScriptStep};
use crate::run::{Model, begin_report};
use crate::script::Command;
use crate::session::{FrameQuestions, LateResults, WorkshopSession};
use crate::viewport::ViewportOptions;

/// The way of frames to the window.
const SCREEN: ScreenOptions =
    ScreenOptions { present_mode: PresentMode::Fifo, frames_in_flight: 2, frame_limit_hz: None };

/// The number of frames that are drawn after the last change, until late results arrive.
const SETTLING_FRAMES: u32 = 8;

/// The longest time that an animation advances in one frame, in seconds.
const LONGEST_STEP_S: f32 = 0.1;

/// The interval at which a window without changes is checked.
const IDLE_INTERVAL: Duration = Duration::from_millis(250);

/// The delay of a requested repaint of the panel from which on it is ignored.
const LONGEST_DELAY: Duration = Duration::from_secs(5);

/// The distance of a wheel without notches that equals one notch, in pixels.
const PIXELS_A_NOTCH: f32 = 40.0;

/// The side length of windows below which the panel is closed at first, in points.
const ROOMY_POINTS: f32 = 600.0;

/// The window and the objects that draw in it. [`Opened::close`] drops later fields first.
pub(super) struct Opened {
    session: WorkshopSession,
    interaction: Interaction,
    panel: ToolPanel,
    late: LateResults,
    /// The box around the whole model at rest.
    rest: Aabb,
    /// The part of the image that the panel does not cover, in points.
    room: Rect,
    cursor: Vec2,
    context: Context,
    egui: egui_winit::State,
    overlay: HudOverlay,
    screen: Screen,
    surface: Surface,
    /// The refresh period of the window's monitor, if it is known.
    refresh: Option<Duration>,
    recovery: WindowRecovery,
    /// The device that the user requested.
    device: DeviceChoice,
    window: Arc<Window>,
    instance: Instance,
    display: DisplayLink,
    /// The files of the model.
    inputs: Vec<PathBuf>,
    report: ScriptReport,
    size: [u32; 2],
    frames_due: u32,
    repaint_at: Option<Time>,
    last_frame: Option<Time>,
    is_occluded: bool,
    is_gone: bool,
}

/// The next step of the loop.
pub(super) enum Next {
    At(Time),
    Now,
    End,
}

impl Opened {
    pub(super) fn open(
        event_loop: &winit::event_loop::ActiveEventLoop,
        arguments: &WorkshopArguments,
        model: Model,
    ) -> Result<Self, RunError> {
        let wanted = WindowOptions {
            title: "Antumbra workshop",
            size: arguments.size,
            validation: arguments.validation,
            device: arguments.device.as_ref().unwrap_or(&DeviceChoice::Best),
        };
        let opened = WindowDevice::open(event_loop, &wanted)?;
        let WindowDevice { window, display, instance, surface, device, refresh } = opened;
        let size: [u32; 2] = window.inner_size().into();
        let screen = Screen::new(&device, &surface, SCREEN, refresh)?;
        let Model { document, path } = model;
        let report = begin_report(&document, &device.adapter().name);
        let options =
            ViewportOptions { keeps_scene: true, ..arguments.viewport_options(frame_size(size)) };
        let mut session = WorkshopSession::new(&device, document, path, &options)?;
        let bounds = session.bounds();
        let middle = (bounds.min + bounds.max) * 0.5;
        let own = session.path().iter().map(|camera| OrbitCamera::of_camera(camera, middle));
        let mut interaction = Interaction::new(&bounds, OrbitPath::new(own.collect()));
        let measures = Measures::of(size, window.scale_factor() as f32);
        let has_panel = size[0] as f32 / measures.scale >= ROOMY_POINTS;
        interaction.use_tools(Tools { has_panel, ..*interaction.tools() });
        if let Err(error) = session.check_pointer() {
            interaction.tell(&format!("nothing is found below the pointer: {error}"));
        }
        let context = Context::default();
        context.options_mut(|options| options.zoom_with_keyboard = false);
        let viewport = ViewportId::ROOT;
        let egui = egui_winit::State::new(context.clone(), viewport, &window, None, None, None);
        Ok(Self {
            panel: ToolPanel::new(&session.document),
            overlay: HudOverlay::new(&device),
            session,
            interaction,
            late: LateResults::default(),
            rest: bounds,
            room: Rect::NOTHING,
            cursor: Vec2::ZERO,
            context,
            egui,
            screen,
            surface,
            refresh,
            recovery: WindowRecovery::default(),
            device: wanted.device.clone(),
            window,
            instance,
            display,
            inputs: files_of(Path::new(&arguments.model)),
            report,
            size,
            frames_due: SETTLING_FRAMES,
            repaint_at: None,
            last_frame: None,
            is_occluded: false,
            is_gone: false,
        })
    }

    /// Handles an event of the window.
    pub(super) fn take(&mut self, event: &WindowEvent) -> Result<(), RunError> {
        let response = self.egui.on_window_event(&self.window, event);
        if response.repaint || !matches!(event, WindowEvent::RedrawRequested) {
            self.frames_due = SETTLING_FRAMES;
        }
        match event {
            WindowEvent::Destroyed => self.is_gone = true,
            WindowEvent::Resized(size) => self.size = (*size).into(),
            WindowEvent::Occluded(is_occluded) => self.is_occluded = *is_occluded,
            WindowEvent::RedrawRequested => self.frames_due = self.frames_due.max(1),
            // An open list receives all keys: Esc only closes the list.
            WindowEvent::KeyboardInput { .. }
                if response.consumed || Popup::is_any_open(&self.context) => {}
            _ => {
                if let Some(input) = self.input_of(event) {
                    let commands = self.interaction.handle(input, &context_of(&self.session));
                    self.act(commands)?;
                }
            }
        }
        Ok(())
    }

    /// Returns an event for the interaction, unless the panel consumes it.
    fn input_of(&mut self, event: &WindowEvent) -> Option<InputEvent> {
        match event {
            WindowEvent::CursorMoved { position, .. } => {
                self.cursor = Vec2::new(position.x as f32, position.y as f32);
                Some(if self.is_on_panel() {
                    InputEvent::Left
                } else {
                    InputEvent::Moved(self.cursor)
                })
            }
            WindowEvent::CursorLeft { .. } | WindowEvent::Focused(false) => Some(InputEvent::Left),
            WindowEvent::MouseInput { state: ElementState::Pressed, button, .. } => {
                (!self.is_on_panel()).then_some(InputEvent::Pressed(*button))
            }
            WindowEvent::MouseInput { state: ElementState::Released, button, .. } => {
                Some(InputEvent::Released(*button))
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, notches) => *notches,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / PIXELS_A_NOTCH,
                };
                (!self.is_on_panel()).then_some(InputEvent::Wheel(notches))
            }
            WindowEvent::ModifiersChanged(modifiers) => {
                Some(InputEvent::Modifiers(modifiers.state()))
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => {
                let PhysicalKey::Code(key) = event.physical_key else { return None };
                if !event.state.is_pressed() || event.repeat {
                    return None;
                }
                if key == KeyCode::F11 && self.interaction.takes_keys() {
                    let is_full = self.window.fullscreen().is_some();
                    let wanted = (!is_full).then_some(Fullscreen::Borderless(None));
                    self.window.set_fullscreen(wanted);
                }
                Some(InputEvent::Key(key))
            }
            _ => None,
        }
    }

    /// Returns true if the pointer is on the panel, or drags an element of it.
    fn is_on_panel(&self) -> bool {
        let scale = self.context.pixels_per_point();
        let at = egui::pos2(self.cursor.x / scale, self.cursor.y / scale);
        let layer = self.context.layer_id_at(at);
        let is_on_window = layer.is_some_and(|layer| layer.order != egui::Order::Background);
        is_on_window || !self.room.contains(at) || self.context.egui_is_using_pointer()
    }

    /// Carries out commands. Failures and refusals are shown as messages. If the device is lost,
    /// the next frame returns the error.
    fn act(&mut self, commands: Vec<Command>) -> Result<(), RunError> {
        for command in commands {
            let outcome = self
                .keep_model(&command)
                .and_then(|()| self.session.act(&command))
                .unwrap_or_else(|error| CommandOutcome::Refused(error.to_string()));
            self.interaction.learn_outcome(&command, &outcome);
            self.frames_due = SETTLING_FRAMES;
            if matches!(command, Command::Camera(_)) {
                continue;
            }
            if command.changes_displays() {
                self.panel.rows.count(&self.session.document);
            }
            let selected = self.session.document.selected().next();
            if let (Command::SelectObjects(objects), Some(object)) = (&command, selected)
                && objects.len() == 1
            {
                self.panel.reveal(&self.session.document, object);
            }
            tracing::info!("{}: {outcome:?}", command.verb());
            let step = ScriptStep { command: command.verb().to_owned(), outcome };
            // A drag is recorded as one command.
            let is_dragged = matches!(command, Command::Section(_) | Command::Lid { .. });
            let newest = self.report.steps.last_mut().filter(|_| is_dragged);
            match newest.filter(|newest| newest.command == step.command) {
                Some(newest) => *newest = step,
                None => self.report.steps.push(step),
            }
        }
        Ok(())
    }

    /// Refuses to overwrite files of the model.
    fn keep_model(&self, command: &Command) -> Result<(), RunError> {
        let output = OutputFile::of(command.verb(), command.written_file());
        Ok(keep_inputs(output.as_slice(), &self.inputs)?)
    }

    /// Runs one iteration of the loop, and returns its next step. After the loss of the device it
    /// continues on another one.
    pub(super) fn turn(&mut self) -> Result<Next, RunError> {
        if self.is_gone || self.display.is_lost() {
            return Ok(Next::End);
        }
        let now = Clock.now();
        let turned = match self.recovery.due() {
            Some(at) if now < at => return Ok(Next::At(at)),
            Some(_) => self.recover().map(|()| Next::Now),
            None => self.draw_next(now),
        };
        turned.or_else(|error| self.plan_recovery(error))
    }

    /// Decides when to try to continue after an error, or returns it.
    pub(super) fn plan_recovery(&mut self, error: RunError) -> Result<Next, RunError> {
        let Some(at) = self.recovery.after(&error, Clock.now()) else { return Err(error) };
        let report = self.session.renderer().loss_report();
        tracing::warn!("{error}; {report}; the model is drawn on another device");
        Ok(Next::At(at))
    }

    /// Opens another device for the window after a loss, and continues on it.
    fn recover(&mut self) -> Result<(), RunError> {
        let wanted = run::wanted(&self.device);
        let adapter = self.instance.pick_adapter_for(&self.surface, wanted.as_deref())?;
        let device = run::open_device(&self.instance, &adapter)?;
        let screen = Screen::new(&device, &self.surface, SCREEN, self.refresh)?;
        let overlay = self.overlay.on(&device)?;
        self.session.recover(&device)?;
        // The window's images follow with the next frame, once the former device is closed.
        self.screen = screen;
        self.overlay = overlay;
        self.recovery.continued();
        self.frames_due = SETTLING_FRAMES;
        self.interaction.tell(&format!("the device was lost; now on {}", adapter.name));
        Ok(())
    }

    /// Draws a frame if something changes and its time has come.
    fn draw_next(&mut self, now: Time) -> Result<Next, RunError> {
        if self.repaint_at.take_if(|at| *at <= now).is_some() {
            self.frames_due = self.frames_due.max(1);
        }
        let is_moving = self.interaction.is_moving(&self.session.orbit());
        if self.size.contains(&0) || self.is_occluded || (self.frames_due == 0 && !is_moving) {
            let idle = now.after(IDLE_INTERVAL);
            return Ok(Next::At(self.repaint_at.map_or(idle, |at| at.min(idle))));
        }
        match self.screen.next_step()? {
            Step::Wait(wait) => Ok(Next::At(wait.until)),
            Step::Start(plan) => self.frame(plan.frame),
        }
    }

    /// Draws a frame and shows it.
    fn frame(&mut self, frame: PacedFrameId) -> Result<Next, RunError> {
        if !self.screen.is_ready()? {
            self.screen.drop_frame(frame);
            return Ok(Next::At(Clock.now().after(Duration::from_millis(2))));
        }
        let now = Clock.now();
        let since = self.last_frame.replace(now).map(|last| now.since(last).as_secs_f32());
        let seconds = since.unwrap_or_default().min(LONGEST_STEP_S);
        self.frames_due = self.frames_due.saturating_sub(1);
        if self.session.renderer().size() != self.size {
            self.session.resize(frame_size(self.size))?;
        }
        let drawn = self.late.drawn;
        self.late = self.session.late_results();
        self.late.drawn = self.late.drawn.or(drawn);
        if let Some(pointed) = self.late.pointed {
            let commands = self.interaction.learn_pointed(&pointed, &context_of(&self.session));
            self.act(commands)?;
        }
        let commands = self.interaction.advance(seconds, &context_of(&self.session));
        self.act(commands)?;
        self.lay_out(now)?;
        let questions = FrameQuestions {
            pointer: self.interaction.pointer(&context_of(&self.session)),
            hovered: self.interaction.hovered().map(|hovered| hovered.object),
            watched: self.panel.listed().to_vec(),
        };
        self.session.draw(&questions, self.overlay.shown())?;
        match self.screen.show(self.session.renderer(), frame, self.size)? {
            PresentResult::Not(PresentSkipped::WindowGone) => Ok(Next::End),
            PresentResult::Not(reason @ PresentSkipped::DeviceLost) => {
                Err(RunError::lost_device(reason))
            }
            PresentResult::Not(_) => {
                self.frames_due = self.frames_due.max(1);
                Ok(Next::At(now.after(Duration::from_millis(10))))
            }
            PresentResult::Presented(_) => Ok(Next::Now),
        }
    }

    /// Lays out the panel and the signs, and applies input in the panel.
    fn lay_out(&mut self, now: Time) -> Result<(), RunError> {
        let window_scale = self.window.scale_factor() as f32;
        let scale = Measures::of(self.size, window_scale).scale;
        self.context.set_zoom_factor(scale / window_scale);
        let [width, height] = self.size.map(|side| side as f32);
        self.interaction.lay_out(Vec2::new(width, height), scale);
        let input = self.egui.take_egui_input(&self.window);
        let page = PanelPage {
            document: &self.session.document,
            rest: self.rest,
            tools: *self.interaction.tools(),
            seen: &self.late.seen,
            drawn: self.late.drawn,
        };
        let seen = context_of(&self.session);
        let notice = self.session.transparency_notice();
        let mut answer = None;
        let mut output = self.context.run_ui(input, |ui| {
            answer = Some(self.panel.show(ui, &page));
            self.room = ui.available_rect_before_wrap();
            signs::paint(ui.painter(), self.room, &self.interaction, &seen, notice.as_deref());
        });
        let platform = std::mem::take(&mut output.platform_output);
        self.egui.handle_platform_output(&self.window, platform);
        let viewport = output.viewport_output.get(&ViewportId::ROOT);
        let delay = viewport.map(|viewport| viewport.repaint_delay);
        if let Some(delay) = delay.filter(|delay| *delay < LONGEST_DELAY) {
            self.repaint_at = Some(now.after(delay));
        }
        self.overlay.show(HudFrame::of(&self.context, output))?;
        if let Some(answer) = answer {
            let mut commands = answer.commands;
            commands.extend(self.interaction.use_tools(answer.tools));
            self.act(commands)?;
        }
        Ok(())
    }

    /// Destroys the window and its objects. Returns the report, and the result of the validation
    /// layer.
    pub(super) fn close(self) -> (ScriptReport, Result<(), RunError>) {
        let Self { session, overlay, screen, surface, window, instance, egui, mut report, .. } =
            self;
        // The final value: a change of the size may have changed it.
        report.transparency = session.transparency();
        drop(session);
        drop(overlay);
        drop(egui);
        drop(screen);
        drop(surface);
        drop(window);
        let log = instance.validation_log().clone();
        drop(instance);
        report.validation_messages = log.len() as u64;
        (report, check_log(&log))
    }
}

fn context_of(session: &WorkshopSession) -> InteractionContext<'_> {
    InteractionContext {
        document: &session.document,
        camera: session.orbit(),
        view: session.view(),
        bounds: session.bounds(),
        frame: session.frame(),
    }
}

/// Returns the size of a window's images, at least one pixel.
fn frame_size(size: [u32; 2]) -> FrameSize {
    let [width, height] = size.map(|side| side.max(1));
    FrameSize { width, height }
}
