//! Signals that end the program as if its window was closed: what was asked for is written.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::run::RunError;

/// A signal that asks for the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// SIGINT: Ctrl-C.
    Interrupt,
    /// SIGTERM.
    Terminate,
}

impl Signal {
    const ALL: [Self; 2] = [Self::Interrupt, Self::Terminate];

    const fn number(self) -> i32 {
        match self {
            Self::Interrupt => SIGINT,
            Self::Terminate => SIGTERM,
        }
    }

    /// What shells know a program by that this signal ended: 130 or 143.
    pub const fn exit_code(self) -> u8 {
        128 + self.number() as u8
    }
}

/// Notes the signals that come.
#[derive(Debug)]
pub struct Signals {
    /// The number of the newest; 0 before the first.
    newest: Arc<AtomicUsize>,
}

impl Signals {
    /// From here on a signal is noted, and the second one ends the process at once: the first may have
    /// come while nobody looks, or what it asks for may hang.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn watch() -> Result<Self, RunError> {
        let newest = Arc::new(AtomicUsize::new(0));
        let is_second = Arc::new(AtomicBool::new(false));
        for signal in Signal::ALL {
            let number = signal.number();
            // They are called in this order: the first signal finds that it is not the second.
            flag::register_conditional_default(number, Arc::clone(&is_second))
                .and_then(|_| flag::register(number, Arc::clone(&is_second)))
                .and_then(|_| flag::register_usize(number, Arc::clone(&newest), number as usize))
                .map_err(|error| RunError::machine(format!("cannot watch for signals: {error}")))?;
        }
        Ok(Self { newest })
    }

    /// The one that asks for the end.
    pub fn received(&self) -> Option<Signal> {
        let newest = self.newest.load(Ordering::Relaxed);
        Signal::ALL.into_iter().find(|signal| signal.number() as usize == newest)
    }
}
