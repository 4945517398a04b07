//! A gate that lets threads take memory while some is left, and makes them wait until others return
//! theirs.

use std::sync::{Condvar, Mutex, PoisonError};

/// A shared amount.
pub(super) struct Gate {
    left: Mutex<u64>,
    given_back: Condvar,
}

impl Gate {
    pub(super) fn new(amount: u64) -> Self {
        Self { left: Mutex::new(amount), given_back: Condvar::new() }
    }

    /// Calls `work` while holding `amount`, which must be at most the whole; otherwise it would
    /// wait forever. `work` must not panic.
    pub(super) fn with<T>(&self, amount: u64, work: impl FnOnce() -> T) -> T {
        let left = self.left.lock().unwrap_or_else(PoisonError::into_inner);
        let mut left = self
            .given_back
            .wait_while(left, |left| *left < amount)
            .unwrap_or_else(PoisonError::into_inner);
        *left -= amount;
        drop(left);
        let result = work();
        *self.left.lock().unwrap_or_else(PoisonError::into_inner) += amount;
        self.given_back.notify_all();
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn never_more_is_taken_than_there_is() {
        let gate = Gate::new(10);
        let taken = AtomicU64::new(0);
        let most = AtomicU64::new(0);
        std::thread::scope(|scope| {
            for thread in 1..=4 {
                let gate = &gate;
                let taken = &taken;
                let most = &most;
                scope.spawn(move || {
                    for _ in 0..100 {
                        gate.with(2 * thread, || {
                            let now = taken.fetch_add(2 * thread, Ordering::SeqCst) + 2 * thread;
                            most.fetch_max(now, Ordering::SeqCst);
                            std::thread::yield_now();
                            taken.fetch_sub(2 * thread, Ordering::SeqCst);
                        });
                    }
                });
            }
        });
        assert!((8..=10).contains(&most.into_inner()));
    }
}
