//! The start of a program: its command line, its help, its log.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::prelude::*;

use super::ending::{Ending, refuse};
use super::names::harmless;
use super::output::print;
use super::style::{has_colour, width};
use crate::run_error::RunError;
use crate::signals::survive_file_limits;

/// The most columns of help: longer lines are hard to read.
const HELP_WIDTH_MAX: usize = 100;

/// Runs a program: reads its command line, starts the log as [`start`] does, does its work, and
/// prints the error if that is impossible. Returns its exit code.
pub fn run_program<A: Parser>(
    level: &str,
    work: impl FnOnce(&A) -> Result<Ending, RunError>,
) -> ExitCode {
    let arguments = match start::<A>(level) {
        Ok(arguments) => arguments,
        Err(code) => return code,
    };
    match work(&arguments) {
        Ok(ending) => ending.exit(),
        Err(error) => refuse(&error, error.exit_code()),
    }
}

/// Reads the command line and starts the log at `level` unless `RUST_LOG` sets another. From then
/// on a limit of file sizes fails writes instead of the process.
///
/// # Errors
/// The exit code if nothing remains to be done: help or version were printed, or an error in the
/// command line.
pub fn start<A: Parser>(level: &str) -> Result<A, ExitCode> {
    survive_file_limits();
    let arguments = parse().map_err(|error| answer(&error))?;
    let asked = std::env::var("RUST_LOG").ok().and_then(|text| text.parse::<Targets>().ok());
    let is_debugging = asked.is_some();
    let level = asked.or_else(|| level.parse().ok()).unwrap_or_default();
    let log = tracing_subscriber::fmt::layer()
        .with_ansi(has_colour(&io::stderr()))
        .with_writer(io::stderr)
        // Printing an internal error would panic if standard error is full.
        .log_internal_errors(false);
    // Modules and times are for those who set `RUST_LOG`; users read sentences.
    if is_debugging {
        tracing_subscriber::registry().with(log.with_filter(level)).init();
    } else {
        let plain = log.without_time().with_target(false);
        tracing_subscriber::registry().with(plain.with_filter(level)).init();
    }
    Ok(arguments)
}

fn parse<A: CommandFactory + FromArgMatches>() -> Result<A, clap::Error> {
    let mut command = A::command().term_width(width().min(HELP_WIDTH_MAX));
    let mut matches = command.try_get_matches_from_mut(std::env::args_os())?;
    A::from_arg_matches_mut(&mut matches).map_err(|error| error.format(&mut command))
}

/// Prints the answer of the parser: help, version or an error.
fn answer(error: &clap::Error) -> ExitCode {
    let mut ending = Ending::default();
    if !error.use_stderr() {
        ending.attempt(print(&styled(error, &io::stdout())));
        return ending.exit();
    }
    let _nobody_reads = io::stderr().write_all(styled(error, &io::stderr()).as_bytes());
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}

/// Returns the text with colours where those are shown and no argument contains escape codes of its
/// own.
fn styled(error: &clap::Error, stream: &impl IsTerminal) -> String {
    let text = error.render();
    let mut words = std::env::args_os();
    let is_harmless = words.all(|word| word.to_str().is_some_and(|word| harmless(word) == word));
    if has_colour(stream) && is_harmless {
        text.ansi().to_string()
    } else {
        harmless(&text.to_string())
    }
}
