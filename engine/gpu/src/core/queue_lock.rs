//! A lock with a bounded wait: a present may hold a queue for as long as its window is hidden.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

pub(crate) struct QueueLock<T> {
    value: T,
    is_taken: Mutex<bool>,
    is_free: Condvar,
}

/// The guard of a turn, which ends when the guard is dropped.
pub(crate) struct QueueGuard<'a, T> {
    turns: &'a QueueLock<T>,
    pub(crate) value: T,
}

impl<T: Copy> QueueLock<T> {
    pub(crate) fn new(value: T) -> Self {
        Self { value, is_taken: Mutex::new(false), is_free: Condvar::new() }
    }

    /// Returns the next turn, or `None` if the others do not end theirs within `bound`.
    pub(crate) fn take(&self, bound: Duration) -> Option<QueueGuard<'_, T>> {
        let waited =
            self.is_free.wait_timeout_while(lock(&self.is_taken), bound, |is_taken| *is_taken);
        // A poisoned lock means that a thread panicked; a flag stays whole.
        let (mut is_taken, timeout) = waited.unwrap_or_else(|error| error.into_inner());
        if timeout.timed_out() && *is_taken {
            return None;
        }
        *is_taken = true;
        Some(QueueGuard { turns: self, value: self.value })
    }
}

impl<T> Drop for QueueGuard<'_, T> {
    fn drop(&mut self) {
        *lock(&self.turns.is_taken) = false;
        self.turns.is_free.notify_one();
    }
}

/// Locks a value that stays whole even where a thread panicked while it held the lock.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A poisoned lock means that a thread panicked; the values behind our locks stay whole.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_waited_for_and_the_wait_has_a_bound() {
        let turns = QueueLock::new(7);
        let turn = turns.take(Duration::ZERO).unwrap();
        assert_eq!(turn.value, 7);
        assert!(turns.take(Duration::from_millis(5)).is_none());
        std::thread::scope(|scope| {
            let other = scope.spawn(|| turns.take(Duration::from_secs(60)).is_some());
            drop(turn);
            assert!(other.join().unwrap());
        });
        assert!(turns.take(Duration::ZERO).is_some());
    }
}
