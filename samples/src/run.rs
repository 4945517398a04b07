//! The walk itself: drives the engine through the schedule and measures.

use thiserror::Error;

use crate::Options;
use crate::options::UsageError;
use crate::progress::Progress;
use crate::report::Report;

/// Whose fault a failure is: it decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blame {
    /// The command line asks for what cannot be: exit code 2.
    User,
    /// The machine lacks something or failed: exit code 1.
    Machine,
}

/// Why there is no report: one sentence that says what is wrong and what to do.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct RunError {
    /// Whose fault it is.
    pub blame: Blame,
    message: String,
}

impl RunError {
    /// The command line asks for what cannot be.
    pub fn user(message: impl ToString) -> Self {
        Self { blame: Blame::User, message: message.to_string() }
    }

    /// The machine lacks something or failed.
    pub fn machine(message: impl ToString) -> Self {
        Self { blame: Blame::Machine, message: message.to_string() }
    }

    /// What the program ends with.
    pub fn exit_code(&self) -> u8 {
        match self.blame {
            Blame::User => 2,
            Blame::Machine => 1,
        }
    }
}

impl From<UsageError> for RunError {
    fn from(error: UsageError) -> Self {
        Self::user(error)
    }
}

/// Walks, measures, writes the pictures into `options.output` (which exists and is writable).
///
/// # Errors
/// When the device is not there or cannot do it, or a picture cannot be written.
pub fn run(_options: &Options, _progress: &dyn Progress) -> Result<Report, RunError> {
    Err(RunError::machine("this build has no renderer"))
}

/// A line for each Vulkan device, in the order that `--device INDEX` counts, from 0.
///
/// # Errors
/// When there is no Vulkan loader or no driver.
pub fn list_devices() -> Result<Vec<String>, RunError> {
    Err(RunError::machine("this build has no renderer"))
}
