//! A lock with a bounded wait: a present may hold a queue as long as its window is hidden.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The lock of a host for a queue that it shares with the engine. Every [`Mutex`] implements it.
///
/// Vulkan requires that no two threads use one queue at once. The engine holds the lock during each
/// of its submits and at no other time.
pub trait HostQueueLock: Send + Sync {
    /// Calls `submit` once, with exclusive use of the queue. A lock with a bounded wait returns
    /// without the call if others hold the queue for longer than `bound`.
    fn locked(&self, bound: Duration, submit: &mut dyn FnMut());
}

impl<T: Send> HostQueueLock for Mutex<T> {
    fn locked(&self, _bound: Duration, submit: &mut dyn FnMut()) {
        let _held = lock(self);
        submit();
    }
}

pub(crate) struct QueueLock<T> {
    value: T,
    is_taken: Mutex<bool>,
    is_free: Condvar,
    host: Option<Arc<dyn HostQueueLock>>,
}

/// The guard of exclusive use among the engine's own threads, which ends when the guard is dropped.
struct Turn<'a> {
    is_taken: &'a Mutex<bool>,
    is_free: &'a Condvar,
}

impl<T: Copy> QueueLock<T> {
    /// Returns a lock that also takes the lock of a host, if there is one.
    pub(crate) fn new(value: T, host: Option<Arc<dyn HostQueueLock>>) -> Self {
        Self { value, is_taken: Mutex::new(false), is_free: Condvar::new(), host }
    }

    /// Calls `user` with the value and exclusive use of it. Returns `None` if other users do not
    /// end within `bound`.
    pub(crate) fn locked<R>(&self, bound: Duration, user: impl FnOnce(T) -> R) -> Option<R> {
        let began = Instant::now();
        let _turn = self.take_turn(bound)?;
        let Some(host) = &self.host else { return Some(user(self.value)) };
        let left = bound.saturating_sub(began.elapsed());
        let mut user = Some(user);
        let mut result = None;
        host.locked(left, &mut || result = user.take().map(|user| user(self.value)));
        result
    }

    fn take_turn(&self, bound: Duration) -> Option<Turn<'_>> {
        let Self { is_taken, is_free, .. } = self;
        let waited = is_free.wait_timeout_while(lock(is_taken), bound, |is_taken| *is_taken);
        // A poisoned lock means that a thread panicked; the flag is still valid.
        let (mut now_taken, timeout) = waited.unwrap_or_else(|error| error.into_inner());
        if timeout.timed_out() && *now_taken {
            return None;
        }
        *now_taken = true;
        Some(Turn { is_taken, is_free })
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        *lock(self.is_taken) = false;
        self.is_free.notify_one();
    }
}

/// Locks a value that stays valid even if a thread panicked while it held the lock.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A poisoned lock means that a thread panicked; the locked values stay valid.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn a_turn_is_waited_for_and_the_wait_has_a_bound() {
        let queue = QueueLock::new(7, None);
        std::thread::scope(|scope| {
            let (began, has_begun) = channel();
            let (end, ends) = channel();
            let queue = &queue;
            scope.spawn(move || {
                queue.locked(Duration::ZERO, |_| {
                    began.send(()).unwrap();
                    ends.recv().unwrap();
                })
            });
            has_begun.recv().unwrap();
            assert_eq!(queue.locked(Duration::from_millis(5), |value| value), None);
            let other = scope.spawn(|| queue.locked(Duration::from_secs(60), |value| value));
            end.send(()).unwrap();
            assert_eq!(other.join().unwrap(), Some(7));
        });
        assert_eq!(queue.locked(Duration::ZERO, |value| value), Some(7));
    }

    #[test]
    fn the_lock_of_a_host_is_held_too() {
        let host = Arc::new(Mutex::new(()));
        let queue = QueueLock::new(7, Some(Arc::clone(&host) as Arc<dyn HostQueueLock>));
        let seen = queue.locked(Duration::ZERO, |value| (value, host.try_lock().is_err()));
        assert_eq!(seen, Some((7, true)));
        assert!(host.try_lock().is_ok());
    }

    /// A host that never releases its queue.
    struct Busy;

    impl HostQueueLock for Busy {
        fn locked(&self, _bound: Duration, _submit: &mut dyn FnMut()) {}
    }

    #[test]
    fn a_host_that_keeps_its_queue_is_not_waited_for_in_vain() {
        let queue = QueueLock::new(7, Some(Arc::new(Busy)));
        // The turn among the engine's threads is released each time.
        for _ in 0..2 {
            assert_eq!(queue.locked(Duration::ZERO, |value| value), None);
        }
    }
}
