//! Walks through a scene without a window, measures strategies against each other, tells.
#![forbid(unsafe_code)]

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use samples::args::Arguments;
use samples::outputs::Outputs;
use samples::run::RunError;
use samples::{progress, run, table};
use tracing_subscriber::EnvFilter;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).init();
    match walk(&arguments) {
        Ok(text) => {
            // Whoever closed the pipe early has seen what they wanted.
            let _closed = std::io::stdout().write_all(text.as_bytes());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}

/// Does what the arguments say; the text is for standard output.
fn walk(arguments: &Arguments) -> Result<String, RunError> {
    let options = arguments.options()?;
    if arguments.list_devices {
        return Ok(run::list_devices()?.iter().map(|line| format!("{line}\n")).collect());
    }
    let outputs = Outputs::prepare(&options)?;
    let progress = progress::for_terminal(arguments.quiet);
    let result = run::run(&options, progress.as_ref());
    progress.finish();
    let report = result?;
    if let Some(path) = &options.report {
        report.write(path).map_err(RunError::machine)?;
    }
    drop(outputs);
    Ok(table::render(&report))
}
