//! Tickets: the tick of commands, for users that need it later but must refer to it before the
//! submit.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::core::tick::Tick;

/// The tick of commands. It is set when they are submitted, and stays 0 if they never are.
#[derive(Debug, Default)]
pub(crate) struct Ticket(AtomicU64);

impl Ticket {
    /// Notes that the commands were submitted.
    pub(crate) fn submitted(&self, tick: Tick) {
        self.0.store(tick.0, Ordering::Release);
    }

    /// Returns true while the commands may still be submitted: until then they hold a reference.
    pub(crate) fn is_pending(self: &Arc<Self>) -> bool {
        self.tick().is_none() && Arc::strong_count(self) > 1
    }

    /// Returns the tick; `None` before the submit.
    pub(crate) fn tick(&self) -> Option<Tick> {
        Some(Tick(self.0.load(Ordering::Acquire))).filter(|tick| *tick > Tick::ZERO)
    }
}
