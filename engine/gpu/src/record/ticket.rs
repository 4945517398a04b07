//! Tickets: the tick of commands, for users that need it before it is known.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::core::tick::Tick;

/// The tick of commands, known once they are submitted; 0 until then, and for ever if they never
/// are.
#[derive(Debug, Default)]
pub(crate) struct Ticket(AtomicU64);

impl Ticket {
    /// Notes that the commands were submitted.
    pub(crate) fn submitted(&self, tick: Tick) {
        self.0.store(tick.0, Ordering::Release);
    }

    /// Returns true while the commands may still be submitted: they hold a ticket of their own.
    pub(crate) fn is_pending(self: &Arc<Self>) -> bool {
        self.tick().is_none() && Arc::strong_count(self) > 1
    }

    /// Returns the tick, once there is one.
    pub(crate) fn tick(&self) -> Option<Tick> {
        Some(Tick(self.0.load(Ordering::Acquire))).filter(|tick| *tick > Tick::ZERO)
    }
}
