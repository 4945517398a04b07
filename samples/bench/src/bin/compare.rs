//! Makes a page with plots, a table and an image from a folder of walkthrough's reports.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::compare::args::Arguments;
use bench::compare::run;
use bench::terminal::{self, ending};

fn main() -> ExitCode {
    let arguments = match terminal::start::<Arguments>("warn") {
        Ok(arguments) => arguments,
        Err(code) => return code,
    };
    match run(&arguments) {
        Ok(ending) => ending.exit(),
        Err(error) => ending::refuse(&error, error.exit_code()),
    }
}
