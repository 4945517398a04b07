//! Why there is no result, and whose fault that is: it decides the exit code.

use std::path::Path;

use scenes::GeneratorError;
use thiserror::Error;

use crate::options::UsageError;
use crate::terminal::shown;

/// Whose fault a failure is: it decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blame {
    /// The command line asks for what cannot be: exit code 2.
    User,
    /// The machine lacks something or failed: exit code 1.
    Machine,
    /// Nobody's: it was given up because the program is to end.
    Nobody,
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
    /// Returns the command line asks for what cannot be.
    pub fn user(message: impl ToString) -> Self {
        Self { blame: Blame::User, message: message.to_string() }
    }

    /// Returns the machine lacks something or failed.
    pub fn machine(message: impl ToString) -> Self {
        Self { blame: Blame::Machine, message: message.to_string() }
    }

    /// It was given up because the program is to end, which is no failure.
    pub fn given_up() -> Self {
        Self { blame: Blame::Nobody, message: "it was given up".to_owned() }
    }

    /// Returns the same, said of a scene's file.
    #[must_use]
    pub fn about(mut self, file: &Path) -> Self {
        self.message = format!("{}: {}", shown(file), self.message);
        self
    }

    /// Returns what the program ends with.
    pub fn exit_code(&self) -> u8 {
        match self.blame {
            Blame::User => 2,
            Blame::Machine => 1,
            Blame::Nobody => 0,
        }
    }
}

impl From<UsageError> for RunError {
    fn from(error: UsageError) -> Self {
        Self::user(error)
    }
}

impl From<render::Error> for RunError {
    fn from(error: render::Error) -> Self {
        match error {
            render::Error::Gpu(error) => error.into(),
            render::Error::Scene(_)
            | render::Error::NoShaderCompiler(_)
            | render::Error::SceneTooLarge { .. }
            | render::Error::Image { .. }
            | render::Error::FramesInFlight { .. }
            | render::Error::Cost(_)
            | render::Error::CannotCount { .. } => Self::user(error),
            render::Error::Hierarchy(_)
            | render::Error::NoMethod(_)
            | render::Error::NoMemory { .. }
            | render::Error::NoVisibleSet
            | render::Error::OldVisibleSet
            | render::Error::NoView
            | render::Error::ForeignRenderer { .. }
            | render::Error::ForeignHierarchy { .. }
            | render::Error::PictureSize { .. }
            | render::Error::Rect { .. }
            | render::Error::Atlas { .. }
            | render::Error::Transparent { .. }
            | render::Error::Deform { .. }
            | render::Error::Light { .. }
            | render::Error::Change { .. } => Self::machine(error),
        }
    }
}

impl From<gpu::Error> for RunError {
    fn from(error: gpu::Error) -> Self {
        match error {
            gpu::Error::UnknownDevice { .. }
            | gpu::Error::Unsupported { .. }
            | gpu::Error::TooLarge { .. }
            | gpu::Error::CannotCompare { .. }
            | gpu::Error::ShaderCompile { .. } => Self::user(error),
            _ => Self::machine(error),
        }
    }
}

impl From<GeneratorError> for RunError {
    fn from(error: GeneratorError) -> Self {
        match error {
            GeneratorError::NoMemory { .. } => Self::machine(error),
            _ => Self::user(error),
        }
    }
}
