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
pub mod trace;

use gpu::ValidationLog;

use crate::outputs::Outputs;
use crate::run::RunError;
use args::CityOptions;
use session::Files;

/// Runs as the options say, to the end.
///
/// # Errors
/// No display; a device or a file that is not what it should be; messages of the validation layer.
pub fn run(options: &CityOptions) -> Result<(), RunError> {
    let files = Files::open(options)?;
    let outputs = Outputs::for_city(options)?;
    let ran = match options.is_headless {
        true => headless::run(options, files),
        false => app::run(options, files),
    };
    drop(outputs);
    ran
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
