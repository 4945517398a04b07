//! The clock of a frame loop: the one that displays and GPUs tell their times on, where there is one.

use pacing::Time;

/// Reads the time.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    #[cfg(not(unix))]
    origin: std::time::Instant,
}

impl Default for Clock {
    fn default() -> Self {
        Self {
            #[cfg(not(unix))]
            origin: std::time::Instant::now(),
        }
    }
}

impl Clock {
    /// The time now: `CLOCK_MONOTONIC` on Unix.
    #[cfg(unix)]
    pub fn now(&self) -> Time {
        let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
        let seconds = u64::try_from(now.tv_sec).unwrap_or_default();
        let nanos = u64::try_from(now.tv_nsec).unwrap_or_default();
        Time::from_nanos(seconds.saturating_mul(1_000_000_000).saturating_add(nanos))
    }

    /// The time now, since the clock was made.
    #[cfg(not(unix))]
    pub fn now(&self) -> Time {
        Time::from_origin(self.origin.elapsed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_on() {
        let clock = Clock::default();
        let before = clock.now();
        std::thread::sleep(std::time::Duration::from_millis(2));
        let passed = clock.now().since(before);
        assert!(passed.as_millis() >= 2 && passed.as_secs() < 60, "{passed:?}");
    }
}
