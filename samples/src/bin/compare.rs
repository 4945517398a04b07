//! Makes a page with plots, a table and a picture of a folder of walkthrough's reports.
#![forbid(unsafe_code)]

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use samples::compare::args::Arguments;
use samples::compare::run;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(told) => {
            // Whoever closed the pipe early has seen what they wanted.
            let _closed = std::io::stdout().write_all(told.as_bytes());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
