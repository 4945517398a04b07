//! The clock of a frame loop: the clock of the times that displays and GPUs report, if there is
//! one.

use antumbra::pacing::Time;

/// A reader of the clock. All readers return the same time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock;

impl Clock {
    /// Returns the current time: `CLOCK_MONOTONIC` on Unix.
    #[cfg(unix)]
    pub fn now(&self) -> Time {
        let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
        let seconds = u64::try_from(now.tv_sec).unwrap_or_default();
        let nanos = u64::try_from(now.tv_nsec).unwrap_or_default();
        Time::from_nanos(seconds.saturating_mul(1_000_000_000).saturating_add(nanos))
    }

    /// Returns the time since the first call.
    #[cfg(not(unix))]
    pub fn now(&self) -> Time {
        static ORIGIN: std::sync::LazyLock<std::time::Instant> =
            std::sync::LazyLock::new(std::time::Instant::now);
        Time::from_origin(ORIGIN.elapsed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_on() {
        let clock = Clock;
        let before = clock.now();
        std::thread::sleep(std::time::Duration::from_millis(2));
        let passed = clock.now().since(before);
        assert!(passed.as_millis() >= 2 && passed.as_secs() < 60, "{passed:?}");
    }
}
