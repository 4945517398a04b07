//! Signals that end a program as if its work were done: the results so far are printed and written.
//! SIGXFSZ, which would leave half a file, does not end it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::{fs, io};

use antumbra::gpu::CancellationToken;
#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::{SigId, flag};

use crate::run_error::RunError;

/// SIGBREAK of Windows' C library: Ctrl-Break, or a console that is closed.
#[cfg(not(unix))]
const SIGHUP: i32 = 21;

/// A signal that asks for the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// SIGHUP: the terminal is gone. On Windows SIGBREAK: Ctrl-Break, or the console is closed.
    Hangup,
    /// SIGINT: Ctrl-C.
    Interrupt,
    /// SIGTERM: the system, or `kill`, asks for the end.
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

    /// Returns the exit code of a program ended by this signal, as shells recognise it: 129 (149
    /// on Windows), 130 or 143.
    pub const fn exit_code(self) -> u8 {
        128 + self.number() as u8
    }
}

/// A record of the signals that come.
#[derive(Debug, Default)]
pub struct Signals {
    /// The number of the newest signal; 0 before the first.
    newest: Arc<AtomicUsize>,
    /// True from the first one on.
    has_come: Arc<AtomicBool>,
}

impl Signals {
    /// Starts noting signals. The second one ends the process at once: the first may have come
    /// while nothing checks for it, or the work may hang. Signals that the caller ignores, as
    /// `nohup` does, stay ignored.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn watch() -> Result<Self, RunError> {
        let newest = Arc::new(AtomicUsize::new(0));
        let has_come = Arc::new(AtomicBool::new(false));
        let ignored = ignored_signals();
        for signal in Signal::ALL {
            let number = signal.number();
            if ignored >> (number - 1) & 1 == 1 {
                continue;
            }
            // Called in this order, so that the first signal is not taken for the second.
            end_at_once_if(&has_come, signal)
                .and_then(|_| flag::register(number, Arc::clone(&has_come)))
                .and_then(|_| flag::register_usize(number, Arc::clone(&newest), number as usize))
                .map_err(|error| RunError::machine(format!("cannot watch for signals: {error}")))?;
        }
        Ok(Self { newest, has_come })
    }

    /// Returns a token for loading that every signal cancels.
    pub fn cancellation(&self) -> CancellationToken {
        CancellationToken::of_flag(Arc::clone(&self.has_come))
    }

    /// Returns the signal that asks for the end.
    pub fn received(&self) -> Option<Signal> {
        let newest = self.newest.load(Ordering::Relaxed);
        Signal::ALL.into_iter().find(|signal| signal.number() as usize == newest)
    }

    /// Gives up the work if a signal asks for the end.
    ///
    /// # Errors
    /// The error of work that was given up.
    pub fn check(&self) -> Result<(), RunError> {
        self.received().map_or(Ok(()), |_| Err(RunError::given_up()))
    }
}

/// Lets a signal end the process as it would end any other, if the condition holds when it comes.
#[cfg(unix)]
fn end_at_once_if(condition: &Arc<AtomicBool>, signal: Signal) -> io::Result<SigId> {
    flag::register_conditional_default(signal.number(), Arc::clone(condition))
}

/// Lets a signal end the process, if the condition holds when it comes. The default of SIGBREAK is
/// not known to `signal_hook`.
#[cfg(not(unix))]
fn end_at_once_if(condition: &Arc<AtomicBool>, signal: Signal) -> io::Result<SigId> {
    let status = signal.exit_code().into();
    flag::register_conditional_shutdown(signal.number(), status, Arc::clone(condition))
}

/// Lets writes beyond the limit of a file's size (`ulimit -f`) fail, instead of ending the process
/// with half a file. If the system refuses, or has no such limit, nothing changes.
pub fn survive_file_limits() {
    #[cfg(unix)]
    let _never_read = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
}

/// Returns a bit for each signal that is ignored, the lowest one for signal 1; none where the
/// system does not report them (they are read from Linux' `/proc/self/status`, `SigIgn`).
fn ignored_signals() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
