//! Flies through a city in a window, or without one.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::Parser;
use samples::run::RunError;
use samples::window::{self, args::CityArguments};
use tracing_subscriber::EnvFilter;

fn main() -> ExitCode {
    let arguments = CityArguments::parse();
    let filter =
        EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn,winit=error"));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).init();
    window::end(arguments.options().map_err(RunError::from))
}
