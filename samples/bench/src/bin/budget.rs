//! Measures the time that each part of a frame adds to the ideal, and prints a table in Markdown.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::budget::{self, BudgetArguments};
use bench::progress;
use bench::run_error::RunError;
use bench::signals::Signals;
use bench::terminal::{self, Ending, print};

fn main() -> ExitCode {
    terminal::run_program("warn", measure)
}

fn measure(arguments: &BudgetArguments) -> Result<Ending, RunError> {
    let mut ending = Ending::default();
    let options = arguments.options()?;
    let signals = Signals::watch()?;
    let progress = progress::for_terminal(arguments.quiet);
    let result = budget::measure(&options, arguments.rounds, progress.as_ref(), &signals);
    progress.finish();
    ending.attempt(print(&result?.table()));
    Ok(ending)
}
