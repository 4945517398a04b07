//! What goes wrong while results are written, collected for the end.

use std::fmt::Display;
use std::process::ExitCode;

use super::output::say;
use crate::signals::Signal;

/// The end of a program whose work is done: each result is written whatever becomes of the others.
#[derive(Debug, Default)]
pub struct Ending {
    failures: Vec<String>,
    signal: Option<Signal>,
}

impl Ending {
    /// Keeps the reason for the end if something failed; passes on what did not.
    pub fn attempt<T>(&mut self, result: Result<T, impl Display>) -> Option<T> {
        result.map_err(|error| self.fail(error)).ok()
    }

    /// Adds something that failed.
    pub fn fail(&mut self, error: impl Display) {
        self.failures.push(error.to_string());
    }

    /// Adds the signal that brought the end about.
    pub fn interrupted(&mut self, signal: Option<Signal>) {
        self.signal = signal;
    }

    /// Says what failed, a line each. Returns 1 if something did, else the code of the signal, else
    /// 0.
    pub fn exit(self) -> ExitCode {
        for failure in &self.failures {
            say(&format!("error: {failure}"));
        }
        match self.signal {
            _ if !self.failures.is_empty() => ExitCode::FAILURE,
            Some(signal) => ExitCode::from(signal.exit_code()),
            None => ExitCode::SUCCESS,
        }
    }
}

/// Says what made the work impossible, and returns its exit code.
pub fn refuse(error: &impl Display, exit_code: u8) -> ExitCode {
    say(&format!("error: {error}"));
    ExitCode::from(exit_code)
}
