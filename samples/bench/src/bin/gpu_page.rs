//! Measures the costs of a device and makes its page.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::gpu_page::args::Arguments;
use bench::gpu_page::run;
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
