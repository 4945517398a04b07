//! Shows a courtyard and its shadows in a window, or without one.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::terminal;
use samples::window::{self, shadows_args::ShadowsArguments};

fn main() -> ExitCode {
    match terminal::start::<ShadowsArguments>("warn,winit=error") {
        Ok(arguments) => window::end(Ok(arguments.options())),
        Err(code) => code,
    }
}
