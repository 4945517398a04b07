//! Shows the scene of a glTF file in a window, or without one.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::Parser;
use samples::run::RunError;
use samples::window::{self, viewer_args::ViewerArguments};
use tracing_subscriber::EnvFilter;

fn main() -> ExitCode {
    let arguments = ViewerArguments::parse();
    let filter =
        EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn,winit=error"));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).init();
    window::end(arguments.options().map_err(RunError::from))
}
