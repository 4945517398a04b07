//! The programs `city` and `viewer`, in a window and without one.
//!
//! [`args`] and [`viewer_args`] turn command lines into a [`source`] and [how to show](show) it. It
//! becomes a [`stage`]: a renderer, and the [`world`] around its scene; files do so while frames go on
//! ([`loading`]). A [`session`] draws one frame after the other, whoever
//! asks: [`app`] when its [`screen`]'s pacer says so, [`headless`] at once. Keys and scripts have
//! [`deeds`] done ([`act`]).

pub mod act;
pub mod app;
pub mod args;
mod arrivals;
pub mod capture;
pub mod clock;
pub mod deeds;
mod enter;
pub mod evenness;
pub mod fly_camera;
pub mod frame_times;
pub mod headless;
pub mod input;
pub mod loading;
pub mod notice;
pub mod page;
mod page_text;
pub mod profiler;
pub mod screen;
pub mod screenshots;
pub mod script;
pub mod session;
pub mod shader_watch;
pub mod show;
pub mod signals;
pub mod source;
pub mod stage;
pub mod trace;
pub mod viewer_args;
pub mod world;

use std::process::ExitCode;

use gpu::ValidationLog;

use crate::outputs::Outputs;
use crate::run::{Blame, RunError};
use session::Files;
use show::ShowOptions;
use signals::{Signal, Signals};
use source::Source;

/// Runs as the options say, to the end; answers the signal, if one brought it about.
///
/// # Errors
/// No display; a device or a file that is not what it should be; messages of the validation layer.
pub fn run(source: &Source, options: &ShowOptions) -> Result<Option<Signal>, RunError> {
    let files = Files::open(source, options)?;
    let outputs = Outputs::for_window(options)?;
    let signals = Signals::watch()?;
    let ran = match options.is_headless {
        true => headless::run(source, options, files, &signals),
        false => app::run(source, options, files, &signals),
    };
    drop(outputs);
    match ran {
        Err(error) if error.blame == Blame::Nobody => Ok(signals.received()),
        ran => ran.map(|()| signals.received()),
    }
}

/// Runs what the command line asks for, says what went wrong, and what the program ends with.
pub fn end(options: Result<(Source, ShowOptions), RunError>) -> ExitCode {
    match options.and_then(|(source, options)| run(&source, &options)) {
        Ok(None) => ExitCode::SUCCESS,
        Ok(Some(signal)) => ExitCode::from(signal.exit_code()),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}

/// The first error, which is the cause; the others are told on the log.
fn first_error<const COUNT: usize>(results: [Result<(), RunError>; COUNT]) -> Result<(), RunError> {
    let mut errors = results.into_iter().filter_map(Result::err);
    let first = errors.next();
    errors.for_each(|error| tracing::error!("{error}"));
    first.map_or(Ok(()), Err)
}

/// What the validation layer found is an error of the program.
fn check_log(log: &ValidationLog) -> Result<(), RunError> {
    let messages = log.drain();
    match messages.first() {
        None => Ok(()),
        Some(first) => Err(RunError::machine(format!(
            "the validation layer has {} messages, the first: {first:?}",
            messages.len()
        ))),
    }
}
