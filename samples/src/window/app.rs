//! The program in its window: handles winit's events, and draws frames when the pacer starts them.

use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::event::{
    DeviceEvent, DeviceId, ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent,
};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::WindowId;

use super::clock::Clock;
use super::display;
use super::failures::first_error;
use super::input::Input;
use super::menu::MenuKey;
use super::opened::{Next, Opened};
use super::pointer::Button;
use super::session::Files;
use super::show::ShowOptions;
use super::source::SceneSource;
use bench::run_error::RunError;
use bench::signals::Signals;

/// The distance of a wheel without notches that equals one notch.
const PIXELS_A_NOTCH: f32 = 40.0;
/// The longest sleep of the loop, since signals do not wake it.
const LONGEST_SLEEP: Duration = Duration::from_millis(250);

/// Runs in a window until it is closed, or until a signal arrives.
///
/// # Errors
/// No display, or a failed one; an unsuitable device or a bad file; messages of the validation
/// layer.
pub fn run(
    source: &SceneSource,
    options: &ShowOptions,
    files: Files,
    signals: &Signals,
) -> Result<(), RunError> {
    let event_loop = display::event_loop().map_err(display::no_display)?;
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
    first_error([outcome, ran, closed])
}

/// The event handler for winit.
struct App<'a> {
    source: &'a SceneSource,
    options: &'a ShowOptions,
    signals: &'a Signals,
    files: Option<Files>,
    opened: Option<Opened>,
    input: Input,
    clock: Clock,
    outcome: Result<(), RunError>,
}

impl App<'_> {
    /// Continues with the next step, or ends with the error.
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

impl App<'_> {
    /// Continues on another device if the error is the loss of the present one; ends otherwise.
    fn follow_error(&mut self, event_loop: &ActiveEventLoop, error: RunError) {
        let next = match &mut self.opened {
            Some(opened) => opened.plan_recovery(error),
            None => Err(error),
        };
        self.follow(event_loop, next);
    }

    /// Carries out the action of a key; returns true if the program should end.
    fn key(&mut self, event: &KeyEvent) -> Result<bool, RunError> {
        let Some(opened) = &mut self.opened else { return Ok(false) };
        let is_escape = event.physical_key == PhysicalKey::Code(KeyCode::Escape);
        // Keys for a list or field neither steer nor trigger actions.
        if opened.session.menu.is_none() || is_escape || !event.state.is_pressed() {
            let action = self.input.key(event);
            return action.map_or(Ok(false), |action| opened.act(action, self.options));
        }
        let Some(key) = self.input.menu_key(event) else { return Ok(false) };
        self.choose(key).map(|()| false)
    }

    /// Passes a key or a click to the open list or field.
    fn choose(&mut self, key: MenuKey) -> Result<(), RunError> {
        let Some(opened) = &mut self.opened else { return Ok(()) };
        if opened.recovery.due().is_some() {
            return Ok(());
        }
        let settings = || self.source.settings_for_another();
        let another = |file| SceneSource::File { file, settings: settings() };
        opened.choose(key, another, self.options)
    }
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let Some(files) = self.files.take() else { return };
        let cancellation = self.signals.cancellation();
        match Opened::open(event_loop, self.source, self.options, files, cancellation) {
            Ok(opened) => self.opened = Some(opened),
            Err(error) => self.follow(event_loop, Err(error)),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(opened) = &mut self.opened else { return };
        if opened.give_to_list(&event) {
            return;
        }
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Destroyed => {
                opened.is_gone = true;
                event_loop.exit();
            }
            WindowEvent::Resized(size) => opened.size = size.into(),
            WindowEvent::Occluded(is_occluded) => opened.set_occluded(is_occluded),
            WindowEvent::Focused(false) => {
                self.input.release();
                let action = opened.pointer.free();
                opened.point(action);
            }
            WindowEvent::ModifiersChanged(modifiers) => {
                self.input.set_modifiers(modifiers.state());
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => {
                let acted = self.key(&event);
                match acted {
                    Ok(false) => {}
                    Ok(true) => event_loop.exit(),
                    Err(error) => self.follow_error(event_loop, error),
                }
            }
            WindowEvent::MouseWheel { delta, .. } => opened.hasten(match delta {
                MouseScrollDelta::LineDelta(_, notches) => notches,
                MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / PIXELS_A_NOTCH,
            }),
            WindowEvent::DroppedFile(file) => {
                let settings = self.source.settings_for_another();
                opened.load(&SceneSource::File { file, settings }, self.options);
            }
            WindowEvent::CursorMoved { position, .. } => opened.cursor = position.into(),
            WindowEvent::MouseInput { state, button, .. } => {
                let button = match button {
                    MouseButton::Left => Button::Left,
                    MouseButton::Right => Button::Right,
                    _ => return,
                };
                match state {
                    ElementState::Pressed => opened.pointer.press(button),
                    ElementState::Released => {
                        let action = opened.pointer.release(button);
                        opened.point(action);
                    }
                }
            }
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        let (DeviceEvent::MouseMotion { delta: (right, down) }, Some(opened)) =
            (event, &mut self.opened)
        else {
            return;
        };
        let action = opened.pointer.move_by(right, down);
        opened.point(action);
        if opened.pointer.is_looking() {
            opened.session.turn(right, down);
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let now = self.clock.now();
        let clicked = self.opened.as_mut().and_then(|opened| opened.session.clicked_row.take());
        if let Some(row) = clicked
            && let Err(error) = self.choose(MenuKey::Row(row))
        {
            self.follow_error(event_loop, error);
        }
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
