//! The margin by which a frame must be ready before its refresh, learnt from late frames.
//!
//! Each miss adds a step, and each frame in time subtracts a small part of a step. So the share of
//! misses settles where both balance: a quantile tracked by stochastic approximation (Robbins and
//! Monro 1951). The margin covers delays that no prediction includes, such as an early latch of a
//! compositor.

use crate::options::PresentReports;
use crate::time::MICROSECOND_NS;

/// The step, as a share of a period.
const STEP: f64 = 1.0 / 16.0;
/// The number of frames in time that outweigh a miss; it bounds the share of misses once the margin
/// has settled.
const FRAMES_PER_MISS: f64 = 4_000.0;
const FIRST: f64 = 1.0 / 16.0;
/// The fixed margin if misses are not reported, with room for unknown delays.
const BLIND: f64 = 3.0 / 16.0;
const LEAST: f64 = 1.0 / 64.0;
const MOST: f64 = 1.5;
/// The least margin in nanoseconds: no scheduler wakes a thread more precisely.
const LEAST_NS: f64 = 100.0 * MICROSECOND_NS;

/// The margin in periods, so that it keeps its meaning on another display.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Margin {
    periods: f64,
    misses_in_a_row: u32,
    /// The number of increases: a frame with an older margin says nothing about the current one.
    version: u32,
}

impl Margin {
    pub(crate) const fn new(reports: PresentReports) -> Self {
        let periods = match reports {
            PresentReports::Times => FIRST,
            PresentReports::Missing => BLIND,
        };
        Self { periods, misses_in_a_row: 0, version: 0 }
    }

    pub(crate) fn ns(&self, period: f64) -> f64 {
        (self.periods * period).max(LEAST_NS)
    }

    pub(crate) const fn version(&self) -> u32 {
        self.version
    }

    pub(crate) fn missed(&mut self) {
        self.version = self.version.wrapping_add(1);
        // Consecutive misses indicate a constant delay, for which small steps would be too slow.
        let step = STEP * f64::from(1_u32 << self.misses_in_a_row.min(2));
        self.misses_in_a_row = self.misses_in_a_row.saturating_add(1);
        self.periods = (self.periods + step).min(MOST);
    }

    pub(crate) fn in_time(&mut self) {
        self.misses_in_a_row = 0;
        self.periods = (self.periods - STEP / FRAMES_PER_MISS).max(LEAST);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settles_where_misses_are_rare() {
        // The required margin is distributed evenly over half a period.
        let mut margin = Margin::new(PresentReports::Times);
        let mut state = 9_u64;
        let mut misses = 0;
        for frame in 0..200_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let needed = 0.5 * (state >> 40) as f64 / f64::from(1 << 24);
            if needed > margin.ns(1e9) / 1e9 {
                margin.missed();
                misses += i32::from(frame >= 1_000);
            } else {
                margin.in_time();
            }
        }
        assert!(misses < 200, "{misses}");
        assert!(margin.ns(1e9) < 0.65e9);
    }

    #[test]
    fn is_bounded() {
        let mut margin = Margin::new(PresentReports::Times);
        (0..1_000).for_each(|_| margin.missed());
        assert!(margin.ns(1e6) <= 1.5e6);
        (0..1_000_000).for_each(|_| margin.in_time());
        assert!(margin.ns(0.0) > 0.0);
    }
}
