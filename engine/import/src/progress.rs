//! The progress of loading, and the functions that receive it.

use std::ops::ControlFlow;

use crate::{Cause, ImportError};

/// A stage of loading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// The file and its references are read and checked, and images are decoded.
    Reading,
    /// Meshes and objects are created.
    Meshes,
}

/// The progress of loading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The current stage.
    pub stage: Stage,
    /// The finished share of the stage, 0 to 1.
    pub fraction: f32,
}

/// The function that receives the progress of loading and returns whether to continue.
pub type ProgressFn<'a> = dyn FnMut(Progress) -> ControlFlow<()> + 'a;

/// The sender of progress, which stops loading if its function requests it.
pub(crate) struct ProgressSender<'a> {
    pub(crate) file: String,
    pub(crate) progress_fn: &'a mut ProgressFn<'a>,
}

impl ProgressSender<'_> {
    pub(crate) fn go_on(&mut self, stage: Stage, fraction: f32) -> ControlFlow<()> {
        (self.progress_fn)(Progress { stage, fraction })
    }

    pub(crate) fn report(&mut self, stage: Stage, fraction: f32) -> Result<(), ImportError> {
        match self.go_on(stage, fraction) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(ImportError {
                file: self.file.clone(),
                object: "loading".to_owned(),
                reason: "it was given up".to_owned(),
                cause: Cause::GivenUp,
            }),
        }
    }
}

/// The function that receives the finished share of reading and returns whether to continue.
pub(crate) type ReadProgress<'a> = dyn FnMut(f32) -> ControlFlow<()> + 'a;
