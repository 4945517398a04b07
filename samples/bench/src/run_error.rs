//! The error of a program without a result, and the blame for it: it decides the exit code.

use std::path::Path;

use antumbra::{gpu, render};
use scenes::GeneratorError;
use thiserror::Error;

use crate::options::UsageError;
use crate::terminal::shown;

/// The blame for a failure: it decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blame {
    /// The user: the command line asks for the impossible; exit code 2.
    User,
    /// The machine: it lacks something or failed; exit code 1.
    Machine,
    /// The device, which was lost; exit code 1, unless the program continues on another.
    LostDevice,
    /// No one: the work was given up because the program is to end.
    Nobody,
}

/// The reason why there is no report: one sentence that names the error and the remedy.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct RunError {
    /// The blame for it.
    pub blame: Blame,
    message: String,
}

impl RunError {
    /// Creates the error of a command line that asks for the impossible.
    pub fn user(message: impl ToString) -> Self {
        Self { blame: Blame::User, message: message.to_string() }
    }

    /// Creates the error of a machine that lacks something or failed.
    pub fn machine(message: impl ToString) -> Self {
        Self { blame: Blame::Machine, message: message.to_string() }
    }

    /// Creates the error of a device that was lost.
    pub fn lost_device(message: impl ToString) -> Self {
        Self { blame: Blame::LostDevice, message: message.to_string() }
    }

    /// Creates the error of work given up because the program is to end, which is not a failure.
    pub fn given_up() -> Self {
        Self { blame: Blame::Nobody, message: "it was given up".to_owned() }
    }

    /// Returns the same error with the name of a scene's file.
    #[must_use]
    pub fn about(mut self, file: &Path) -> Self {
        self.message = format!("{}: {}", shown(file), self.message);
        self
    }

    /// Returns the exit code.
    pub fn exit_code(&self) -> u8 {
        match self.blame {
            Blame::User => 2,
            Blame::Machine | Blame::LostDevice => 1,
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
            | render::Error::Shadows(_)
            | render::Error::NoSurfacesForShadows
            | render::Error::MultisampledVolumes
            | render::Error::Edges(_)
            | render::Error::NoSurfacesForEnvironment
            | render::Error::SampleDepths { .. }
            | render::Error::CannotCount(_) => Self::user(error),
            _ => Self::machine(error),
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
            gpu::Error::Cancelled => Self::given_up(),
            error if error.is_device_lost() => Self::lost_device(error),
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
