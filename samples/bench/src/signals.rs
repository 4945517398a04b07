//! Signals that end a program as if all was done: what there is by then is printed and written.

use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;

use crate::run_error::RunError;

/// A signal that asks for the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// SIGHUP: the terminal is gone.
    Hangup,
    /// SIGINT: Ctrl-C.
    Interrupt,
    /// SIGTERM.
    Terminate,
}

impl Signal {
    const ALL: [Self; 3] = [Self::Hangup, Self::Interrupt, Self::Terminate];

    const fn number(self) -> i32 {
        match self {
            Self::Hangup => SIGHUP,
            Self::Interrupt => SIGINT,
            Self::Terminate => SIGTERM,
        }
    }

    /// Returns what shells know a program by that this signal ended: 129, 130 or 143.
    pub const fn exit_code(self) -> u8 {
        128 + self.number() as u8
    }
}

/// Notes the signals that come.
#[derive(Debug, Default)]
pub struct Signals {
    /// The number of the newest; 0 before the first.
    newest: Arc<AtomicUsize>,
}

impl Signals {
    /// From here on a signal is noted, and the second one ends the process at once: the first may
    /// have come while nobody looks, or what it asks for may hang. What the caller ignores, as
    /// `nohup` does, stays ignored.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn watch() -> Result<Self, RunError> {
        let newest = Arc::new(AtomicUsize::new(0));
        let is_second = Arc::new(AtomicBool::new(false));
        let ignored = ignored_signals();
        for signal in Signal::ALL {
            let number = signal.number();
            if ignored >> (number - 1) & 1 == 1 {
                continue;
            }
            // They are called in this order: the first signal finds that it is not the second.
            flag::register_conditional_default(number, Arc::clone(&is_second))
                .and_then(|_| flag::register(number, Arc::clone(&is_second)))
                .and_then(|_| flag::register_usize(number, Arc::clone(&newest), number as usize))
                .map_err(|error| RunError::machine(format!("cannot watch for signals: {error}")))?;
        }
        Ok(Self { newest })
    }

    /// Returns the one that asks for the end.
    pub fn received(&self) -> Option<Signal> {
        let newest = self.newest.load(Ordering::Relaxed);
        Signal::ALL.into_iter().find(|signal| signal.number() as usize == newest)
    }

    /// Gives the work up if a signal asks for the end.
    ///
    /// # Errors
    /// That it was given up.
    pub fn check(&self) -> Result<(), RunError> {
        self.received().map_or(Ok(()), |_| Err(RunError::given_up()))
    }
}

/// Returns a bit for each signal that is ignored, the lowest one for signal 1; none where the
/// system does not tell (it is read from Linux' `/proc/self/status`, `SigIgn`).
fn ignored_signals() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
