//! A CAD viewer: carries out a script on a model, without a window, and reports what it did.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::run_error::RunError;
use bench::terminal::{self, Ending, ending};
use workshop::args::WorkshopArguments;
use workshop::run;

fn main() -> ExitCode {
    let arguments = match terminal::start::<WorkshopArguments>("warn") {
        Ok(arguments) => arguments,
        Err(code) => return code,
    };
    match work(&arguments) {
        Ok(ending) => ending.exit(),
        Err(error) => ending::refuse(&error, error.exit_code()),
    }
}

/// Carries out the script of the arguments.
fn work(arguments: &WorkshopArguments) -> Result<Ending, RunError> {
    let mut ending = Ending::default();
    run::run(arguments, &mut ending)?;
    Ok(ending)
}
