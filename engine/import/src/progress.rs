//! How far loading has come, and who is told.

use std::ops::ControlFlow;

use crate::{Cause, ImportError};

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// The file and all that it refers to are read and checked, images are decoded.
    Reading,
    /// Meshes and objects are made.
    Meshes,
}

/// How far loading has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub stage: Stage,
    /// How much of that is done, 0 to 1.
    pub fraction: f32,
}

/// Who is told how far loading has come, and says whether it shall go on.
pub type ProgressFn<'a> = dyn FnMut(Progress) -> ControlFlow<()> + 'a;

/// Tells, and stops when nobody wants it any more.
pub(crate) struct ProgressSender<'a> {
    pub(crate) file: String,
    pub(crate) listener: &'a mut ProgressFn<'a>,
}

impl ProgressSender<'_> {
    pub(crate) fn go_on(&mut self, stage: Stage, fraction: f32) -> ControlFlow<()> {
        (self.listener)(Progress { stage, fraction })
    }

    pub(crate) fn tell(&mut self, stage: Stage, fraction: f32) -> Result<(), ImportError> {
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

/// Who is told what part of a file was read, and says whether to go on.
pub(crate) type ReadProgress<'a> = dyn FnMut(f32) -> ControlFlow<()> + 'a;
