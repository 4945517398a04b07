//! Flies through a city in a window, or without one.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::run_error::RunError;
use bench::terminal;
use samples::window::{self, args::CityArguments};

fn main() -> ExitCode {
    match terminal::start::<CityArguments>("warn,winit=error") {
        Ok(arguments) => window::end(arguments.options().map_err(RunError::from)),
        Err(code) => code,
    }
}
