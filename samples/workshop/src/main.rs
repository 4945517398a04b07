//! A CAD viewer: shows a model in a window, or runs a script on it without a window and writes a
//! report.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::run_error::RunError;
use bench::terminal::{self, Ending};
use workshop::args::WorkshopArguments;
use workshop::run;

fn main() -> ExitCode {
    terminal::run_program("warn,winit=error", work)
}

/// Runs the script of the arguments, or opens a window.
fn work(arguments: &WorkshopArguments) -> Result<Ending, RunError> {
    let mut ending = Ending::default();
    run::run(arguments, &mut ending)?;
    Ok(ending)
}
