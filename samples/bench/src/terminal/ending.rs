//! Failures while results are written, collected for the end.

use std::fmt::Display;
use std::process::ExitCode;

use super::output::say;
use crate::signals::Signal;

/// The end of a program whose work is done: each result is written even if others failed.
#[derive(Debug, Default)]
pub struct Ending {
    failures: Vec<String>,
    signal: Option<Signal>,
}

impl Ending {
    /// Keeps the error for the end if something failed; returns the value otherwise.
    pub fn attempt<T>(&mut self, result: Result<T, impl Display>) -> Option<T> {
        result.map_err(|error| self.fail(error)).ok()
    }

    /// Adds a failure.
    pub fn fail(&mut self, error: impl Display) {
        self.failures.push(error.to_string());
    }

    /// Adds the signal that caused the end.
    pub fn interrupted(&mut self, signal: Option<Signal>) {
        self.signal = signal;
    }

    /// Prints the failures, a line each. Returns 1 if there are any, else the code of the signal,
    /// else 0.
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

/// Prints the error that made the work impossible, and returns its exit code.
pub fn refuse(error: &impl Display, exit_code: u8) -> ExitCode {
    say(&format!("error: {error}"));
    ExitCode::from(exit_code)
}
