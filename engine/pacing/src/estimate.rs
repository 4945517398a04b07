//! Estimates of durations: mean and spread of samples, robust against single outliers.

/// The weight of a new sample once there are enough samples.
const GAIN: f64 = 1.0 / 24.0;
/// The assumed relative mean deviation of a duration that is not measured well.
const USUAL_SPREAD: f64 = 1.0 / 16.0;
/// The weight of a guessed value.
const DRIFT: f64 = 0.1;
/// The distance of an outlier from the mean, in mean deviations; it must also exceed
/// `LEAST_SURPRISE`.
const SURPRISE: f64 = 8.0;
/// The least distance of an outlier, as a share of the mean: smaller distances are noise.
const LEAST_SURPRISE: f64 = 0.25;
/// The least distance of an outlier, in nanoseconds.
const LEAST_SURPRISE_NS: f64 = 200e3;
/// The number of consecutive outliers that become the new level.
const BELIEVED: usize = 3;

/// An estimate of a repeated duration, in nanoseconds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Estimate {
    mean: f64,
    /// The mean absolute deviation.
    deviation: f64,
    count: u32,
    surprises: [f64; BELIEVED],
    surprised: usize,
}

impl Estimate {
    pub(crate) fn observe(&mut self, sample: f64) {
        let sample = sample.clamp(0.0, 10e9);
        let off = sample - self.mean;
        let usual =
            (SURPRISE * self.deviation).max(LEAST_SURPRISE * self.mean).max(LEAST_SURPRISE_NS);
        if self.count >= 4 && off.abs() > usual {
            self.surprises[self.surprised] = sample;
            self.surprised += 1;
            if self.surprised == BELIEVED {
                // The outliers may have begun with a stall, so the smallest is taken as the new
                // level.
                let least = self.surprises.iter().copied().fold(f64::INFINITY, f64::min);
                *self = Self { mean: least, deviation: least / 16.0, count: 4, ..Self::default() };
            }
            return;
        }
        self.surprised = 0;
        self.count = self.count.saturating_add(1);
        let gain = GAIN.max(1.0 / f64::from(self.count));
        self.mean += gain * off;
        // The first sample has no spread, so one is assumed.
        let deviation = if self.count == 1 { sample / 8.0 } else { off.abs() };
        self.deviation += gain * (deviation - self.deviation);
    }

    /// Moves the mean towards a guess: nothing was measured, and the usual spread is assumed.
    pub(crate) fn drift_to(&mut self, maybe: f64) {
        self.mean += DRIFT * (maybe.clamp(0.0, 10e9) - self.mean);
        self.deviation += GAIN * (USUAL_SPREAD * self.mean - self.deviation);
    }

    /// Raises the mean to a known lower bound.
    pub(crate) fn raise_to(&mut self, least: f64) {
        self.mean = self.mean.max(least.clamp(0.0, 10e9));
    }

    /// Lowers the mean to the upper bound of a sample.
    pub(crate) fn lower_to(&mut self, most: f64) {
        self.mean = self.mean.min(most.max(0.0) + self.spread());
    }

    pub(crate) const fn known(&self) -> bool {
        self.count > 0
    }

    pub(crate) const fn expected(&self) -> f64 {
        self.mean
    }

    /// Returns the standard deviation of a normal distribution with this mean deviation.
    pub(crate) fn spread(&self) -> f64 {
        1.25 * self.deviation
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stall_changes_nothing_and_a_new_level_is_believed() {
        let mut estimate = Estimate::default();
        (0..100).for_each(|n| estimate.observe(5e6 + f64::from(n % 7) * 1e4));
        let before = estimate.expected();
        assert!((before - 5.03e6).abs() < 2e4, "{before}");
        estimate.observe(170e6);
        assert!((estimate.expected() - before).abs() < 1.0);
        (0..BELIEVED).for_each(|_| estimate.observe(9e6));
        assert!((estimate.expected() - 9e6).abs() < 1.0);
    }

    #[test]
    fn nonsense_stays_bounded() {
        let mut estimate = Estimate::default();
        for sample in [f64::MAX, -1.0, f64::INFINITY, 0.0, 1e300, -1e300, 1e300, 1e300] {
            estimate.observe(sample);
            assert!((0.0..=10e9).contains(&estimate.expected()), "{sample}");
            assert!(estimate.spread().is_finite());
        }
    }
}
