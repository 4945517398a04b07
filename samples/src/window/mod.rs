//! The program `city`, in a window and without one.
//!
//! [`args`] turns the command line into options. A [`session`] draws one frame after the other, whoever
//! asks: [`app`] when its [`screen`]'s pacer says so, [`headless`] at once. Keys and scripts have
//! [`deeds`] done ([`act`]).

pub mod act;
pub mod app;
pub mod args;
pub mod capture;
pub mod clock;
pub mod deeds;
pub mod evenness;
pub mod fly_camera;
pub mod frame_times;
pub mod headless;
pub mod input;
pub mod notice;
pub mod page;
mod page_text;
pub mod profiler;
pub mod screen;
pub mod screenshots;
pub mod script;
pub mod session;
pub mod shader_watch;
pub mod signals;
pub mod trace;

use gpu::ValidationLog;

use crate::outputs::Outputs;
use crate::run::RunError;
use args::CityOptions;
use session::Files;
use signals::{Signal, Signals};

/// Runs as the options say, to the end; answers the signal, if one brought it about.
///
/// # Errors
/// No display; a device or a file that is not what it should be; messages of the validation layer.
pub fn run(options: &CityOptions) -> Result<Option<Signal>, RunError> {
    let files = Files::open(options)?;
    let outputs = Outputs::for_city(options)?;
    let signals = Signals::watch()?;
    let ran = match options.is_headless {
        true => headless::run(options, files, &signals),
        false => app::run(options, files, &signals),
    };
    drop(outputs);
    ran.map(|()| signals.received())
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
