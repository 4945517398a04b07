//! A lock with a bounded wait: a present may hold a queue for as long as its window is hidden.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The lock of a host around a queue that it shares with the engine.
///
/// Vulkan leaves it to the program that no two threads use one queue at once. The engine holds the
/// lock around each of its submits and nowhere else.
pub trait HostQueueLock: Send + Sync {
    /// Locks the queue for the calling thread. Returns false if others hold it for longer than
    /// `bound`, after which the engine does not use it.
    fn lock(&self, bound: Duration) -> bool;

    /// Unlocks the queue, on the thread that locked it.
    fn unlock(&self);
}

pub(crate) struct QueueLock<T> {
    value: T,
    is_taken: Mutex<bool>,
    is_free: Condvar,
    host: Option<Arc<dyn HostQueueLock>>,
}

/// The guard of a turn, which ends when the guard is dropped.
pub(crate) struct QueueGuard<'a, T> {
    turns: &'a QueueLock<T>,
    pub(crate) value: T,
}

impl<T: Copy> QueueLock<T> {
    /// Returns a lock that the lock of a host, if any, is part of.
    pub(crate) fn new(value: T, host: Option<Arc<dyn HostQueueLock>>) -> Self {
        Self { value, is_taken: Mutex::new(false), is_free: Condvar::new(), host }
    }

    /// Returns the next turn, or `None` if the others do not end theirs within `bound`.
    pub(crate) fn take(&self, bound: Duration) -> Option<QueueGuard<'_, T>> {
        let began = Instant::now();
        self.take_own(bound)?;
        let left = bound.saturating_sub(began.elapsed());
        if self.host.as_ref().is_some_and(|host| !host.lock(left)) {
            self.release();
            return None;
        }
        Some(QueueGuard { turns: self, value: self.value })
    }
}

impl<T> QueueLock<T> {
    /// Takes the turn among the threads of the engine.
    fn take_own(&self, bound: Duration) -> Option<()> {
        let waited =
            self.is_free.wait_timeout_while(lock(&self.is_taken), bound, |is_taken| *is_taken);
        // A poisoned lock means that a thread panicked; a flag stays whole.
        let (mut is_taken, timeout) = waited.unwrap_or_else(|error| error.into_inner());
        if timeout.timed_out() && *is_taken {
            return None;
        }
        *is_taken = true;
        Some(())
    }

    fn release(&self) {
        *lock(&self.is_taken) = false;
        self.is_free.notify_one();
    }
}

impl<T> Drop for QueueGuard<'_, T> {
    fn drop(&mut self) {
        if let Some(host) = &self.turns.host {
            host.unlock();
        }
        self.turns.release();
    }
}

/// Locks a value that stays whole even where a thread panicked while it held the lock.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A poisoned lock means that a thread panicked; the values behind our locks stay whole.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

    use super::*;

    #[test]
    fn a_turn_is_waited_for_and_the_wait_has_a_bound() {
        let turns = QueueLock::new(7, None);
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

    /// A host that holds its queue for as long as `is_held`, and counts.
    #[derive(Default)]
    struct Host {
        is_held: AtomicBool,
        locked: AtomicU32,
        unlocked: AtomicU32,
    }

    impl HostQueueLock for Host {
        fn lock(&self, _bound: Duration) -> bool {
            let is_free = !self.is_held.load(Ordering::Relaxed);
            self.locked.fetch_add(u32::from(is_free), Ordering::Relaxed);
            is_free
        }

        fn unlock(&self) {
            self.unlocked.fetch_add(1, Ordering::Relaxed);
        }
    }

    #[test]
    fn a_turn_holds_the_lock_of_the_host() {
        let host = Arc::new(Host::default());
        let counts =
            || (host.locked.load(Ordering::Relaxed), host.unlocked.load(Ordering::Relaxed));
        let turns = QueueLock::new(7, Some(Arc::clone(&host) as Arc<dyn HostQueueLock>));
        let turn = turns.take(Duration::ZERO).unwrap();
        assert_eq!(counts(), (1, 0));
        drop(turn);
        assert_eq!(counts(), (1, 1));
        host.is_held.store(true, Ordering::Relaxed);
        assert!(turns.take(Duration::ZERO).is_none());
        // The turn among our own threads was given back.
        host.is_held.store(false, Ordering::Relaxed);
        drop(turns.take(Duration::ZERO).unwrap());
        assert_eq!(counts(), (2, 2));
    }
}
