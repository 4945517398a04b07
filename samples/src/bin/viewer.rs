//! Shows the scene of a glTF file in a window, or without one.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::run_error::RunError;
use bench::terminal;
use samples::window::{self, viewer_args::ViewerArguments};

fn main() -> ExitCode {
    match terminal::start::<ViewerArguments>("warn,winit=error") {
        Ok(arguments) => window::end(arguments.options().map_err(RunError::from)),
        Err(code) => code,
    }
}
