//! What may be recorded: things of the same device, as long as nothing has failed.

use ash::vk;

use super::Commands;
use crate::error::{Called, Error};
use crate::ownership::OfDevice;

/// Why a recording goes nowhere.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Failure {
    /// A call failed.
    Call(&'static str, vk::Result),
    /// What was to be recorded is invalid.
    Wrong(&'static str),
    /// Something of another device was to be recorded.
    Foreign(&'static str),
}

impl Commands {
    /// The first failure while recording, which [`crate::Frame::submit`] reports.
    pub(crate) fn check(&self) -> Result<(), Error> {
        match self.failed.get() {
            None => Ok(()),
            Some(Failure::Call(call, code)) => Err(code).called(call),
            Some(Failure::Wrong(what)) => Err(Error::WrongCommands(what)),
            Some(Failure::Foreign(thing)) => Err(foreign(thing)),
        }
    }

    /// Lets `thing` into the recording if it is of the same device; else the recording fails, and
    /// nothing may be recorded with the thing. Every command that takes handles asks here.
    pub(crate) fn admit<T: OfDevice>(&self, thing: &T) -> Result<(), Error> {
        if thing.device_id() == self.device.id() {
            return Ok(());
        }
        self.fail(Failure::Foreign(T::KIND));
        Err(foreign(T::KIND))
    }

    /// [`Commands::admit`] for several things of a kind.
    pub(super) fn admit_all<'a, T: OfDevice + 'a>(
        &self,
        things: impl IntoIterator<Item = &'a T>,
    ) -> bool {
        things.into_iter().all(|thing| self.admit(thing).is_ok())
    }

    /// Makes [`Commands::check`] fail. Only the first failure counts: others may come of it.
    pub(crate) fn fail(&self, failure: Failure) {
        if self.is_sound() {
            self.failed.set(Some(failure));
        }
    }

    /// Whether nothing has failed. What could not be bound must not be drawn with; the recording goes
    /// nowhere then, [`Commands::check`] sees to that.
    pub(super) fn is_sound(&self) -> bool {
        self.failed.get().is_none()
    }
}

fn foreign(thing: &'static str) -> Error {
    Error::Foreign { thing, user: "commands (`Commands`)", owner: "Device" }
}
