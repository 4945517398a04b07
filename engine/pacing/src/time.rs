//! Points in time on the caller's clock. This crate never reads that clock.

use std::time::Duration;

/// A point in time in nanoseconds, on a monotonic clock of the caller's choice with any origin.
///
/// All times given to a [`Pacer`](crate::Pacer) must be from the same clock. The caller converts
/// times that the presentation engine reports on another clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Time(u64);

impl Time {
    /// The origin of the clock.
    pub const ZERO: Self = Self(0);

    /// Returns the time `nanos` nanoseconds after the origin.
    #[must_use]
    pub const fn from_nanos(nanos: u64) -> Self {
        Self(nanos)
    }

    /// Returns the time after the origin by a duration, for example from `Instant::elapsed`. The
    /// result is at most the last representable time (584 years).
    #[must_use]
    pub fn from_origin(elapsed: Duration) -> Self {
        Self(u64::try_from(elapsed.as_nanos()).unwrap_or(u64::MAX))
    }

    /// Returns the number of nanoseconds since the origin.
    #[must_use]
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// Returns the duration since `earlier`; zero if `earlier` is later.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Duration {
        Duration::from_nanos(self.0.saturating_sub(earlier.0))
    }

    /// Returns the time after this one by a duration, at most the last representable time.
    #[must_use]
    pub fn after(self, duration: Duration) -> Self {
        Self(self.0.saturating_add(u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)))
    }

    /// Returns nanoseconds for predictions: exact up to 104 days from the origin, and within 64 ns
    /// for a decade.
    pub(crate) const fn to_ns(self) -> f64 {
        self.0 as f64
    }

    /// Returns the nearest representable time; the origin if `ns` is not a number.
    pub(crate) fn from_ns(ns: f64) -> Self {
        Self(ns.round() as u64)
    }
}

/// Returns a duration in nanoseconds for predictions.
pub(crate) fn ns(duration: Duration) -> f64 {
    duration.as_nanos() as f64
}

pub(crate) const MICROSECOND_NS: f64 = 1e3;
pub(crate) const MILLISECOND_NS: f64 = 1e6;
pub(crate) const SECOND_NS: f64 = 1e9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_is_bounded() {
        let last = Time::from_nanos(u64::MAX);
        assert_eq!(last.after(Duration::from_secs(1 << 62)), last);
        assert_eq!(Time::from_origin(Duration::from_secs(1 << 62)), last);
        assert_eq!(Time::ZERO.since(last), Duration::ZERO);
        assert_eq!(Time::from_ns(f64::NAN), Time::ZERO);
        assert_eq!(Time::from_ns(-5.0), Time::ZERO);
        assert_eq!(Time::from_ns(f64::INFINITY), last);
        assert_eq!(Time::from_nanos(7).after(Duration::from_nanos(5)).as_nanos(), 12);
    }
}
