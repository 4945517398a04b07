//! Walks through a scene without a window, measures strategies against each other, tells.
#![forbid(unsafe_code)]

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use samples::args::Arguments;
use samples::outputs::Outputs;
use samples::run::RunError;
use samples::strategy::Strategy;
use samples::{progress, run, table, verdict};
use tracing_subscriber::EnvFilter;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).init();
    match walk(&arguments) {
        Ok(told) => {
            // Whoever closed the pipe early has seen what they wanted.
            let _closed = std::io::stdout().write_all(told.text.as_bytes());
            match told.complaint {
                None => ExitCode::SUCCESS,
                Some(complaint) => {
                    eprintln!("error: {complaint}");
                    ExitCode::FAILURE
                }
            }
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}

/// What there is to tell in the end.
struct Told {
    /// For standard output.
    text: String,
    /// What the walk found that must not be.
    complaint: Option<String>,
}

/// Does what the arguments say.
fn walk(arguments: &Arguments) -> Result<Told, RunError> {
    if arguments.list_strategies {
        let text = Strategy::ALL.iter().map(|strategy| format!("{strategy}\n")).collect();
        return Ok(Told { text, complaint: None });
    }
    let options = arguments.options()?;
    if arguments.list_devices {
        let text = run::list_devices()?.iter().map(|line| format!("{line}\n")).collect();
        return Ok(Told { text, complaint: None });
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
    Ok(Told { text: table::render(&report), complaint: verdict::complaint(&report) })
}
