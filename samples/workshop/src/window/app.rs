//! The viewer's event loop: handles winit's events, and draws frames when something changes.

use std::path::Path;
use std::time::{Duration, Instant};

use bench::outputs::{OutputFile, Outputs};
use bench::run_error::RunError;
use bench::signals::Signals;
use bench::terminal::Ending;
use samples::window::clock::Clock;
use samples::window::display;
use samples::window::failures::first_error;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::WindowId;

use super::opened::{Next, Opened};
use crate::args::WorkshopArguments;
use crate::inputs::{files_of, keep_inputs};
use crate::run::{Model, model, write_report};

/// The longest sleep of the loop, since signals do not wake it.
const LONGEST_SLEEP: Duration = Duration::from_millis(250);

/// Shows the model of the arguments in a window until it is closed or a signal arrives, then writes
/// the report.
///
/// # Errors
/// An invalid model or file; no display, or a failed one; an unsuitable device; messages of the
/// validation layer.
pub fn run(arguments: &WorkshopArguments, ending: &mut Ending) -> Result<(), RunError> {
    let report_file = OutputFile::of("--report", arguments.report.as_deref());
    let files: Vec<OutputFile<'_>> = report_file.into_iter().collect();
    keep_inputs(&files, &files_of(Path::new(&arguments.model)))?;
    let _outputs = Outputs::prepare(None, files)?;
    let signals = Signals::watch()?;
    let event_loop = display::event_loop().map_err(display::no_display)?;
    let model = Some(model(arguments)?);
    let mut app = App { arguments, model, signals: &signals, opened: None, outcome: Ok(()) };
    let failed = |error| RunError::machine(format!("the window system failed: {error}"));
    let ran = event_loop.run_app(&mut app).map_err(failed);
    let App { opened, outcome, .. } = app;
    let mut closed = Ok(());
    if let Some(opened) = opened {
        let (report, log) = opened.close();
        write_report(arguments, &report, ending);
        closed = log;
    }
    ending.interrupted(signals.received());
    first_error([outcome, ran, closed])
}

/// The event handler for winit.
struct App<'a> {
    arguments: &'a WorkshopArguments,
    /// The model, until the window is open.
    model: Option<Model>,
    signals: &'a Signals,
    opened: Option<Opened>,
    outcome: Result<(), RunError>,
}

impl App<'_> {
    /// Continues with the next step, or ends with the error.
    fn follow(&mut self, event_loop: &ActiveEventLoop, result: Result<Next, RunError>) {
        match result {
            Ok(Next::Now) => event_loop.set_control_flow(ControlFlow::Poll),
            Ok(Next::At(at)) => {
                let wait = at.since(Clock.now()).min(LONGEST_SLEEP);
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
        let Some(model) = self.model.take() else { return };
        match Opened::open(event_loop, self.arguments, model) {
            Ok(opened) => self.opened = Some(opened),
            Err(error) => self.follow(event_loop, Err(error)),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(opened) = &mut self.opened else { return };
        if matches!(event, WindowEvent::CloseRequested | WindowEvent::Destroyed) {
            event_loop.exit();
        }
        if let Err(error) = opened.take(&event) {
            let next = opened.plan_recovery(error);
            self.follow(event_loop, next);
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if event_loop.exiting() {
            return;
        }
        let Some(opened) = &mut self.opened else { return };
        let next = match self.signals.received() {
            Some(_) => Ok(Next::End),
            None => opened.turn(),
        };
        self.follow(event_loop, next);
    }
}
