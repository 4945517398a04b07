//! Measures the time that each part of a frame adds to the ideal, over the walk that the options of
//! `walkthrough` describe, and prints a table in Markdown.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::args::Arguments;
use bench::run_error::RunError;
use bench::signals::Signals;
use bench::terminal::{self, Ending, print};
use bench::{budget, progress};

/// The times that each ablation walks the path.
const ROUNDS: u32 = 15;

fn main() -> ExitCode {
    terminal::run_program("warn", measure)
}

fn measure(arguments: &Arguments) -> Result<Ending, RunError> {
    let mut ending = Ending::default();
    let options = arguments.options()?;
    let signals = Signals::watch()?;
    let progress = progress::for_terminal(arguments.quiet);
    let result = budget::measure(&options, ROUNDS, progress.as_ref(), &signals);
    progress.finish();
    ending.attempt(print(&result?.table()));
    Ok(ending)
}
