//! The clock of the display's refreshes: their period and phase, learnt from noisy times of past
//! refreshes.
//!
//! Learning uses a handful of samples: it finds the period of which all their distances are
//! multiples, and fits a line. From then on a Kalman filter over (phase, period) tracks the clock
//! (R. E. Kalman 1960). Unlike a plain phase-locked loop, it is right for samples that are
//! thousands of refreshes apart, and it quantifies the uncertainty of a prediction. Samples off the
//! grid are left out; if they persist, learning starts again.

use crate::time::MICROSECOND_NS;

/// The number of samples that learning uses.
const WINDOW: usize = 12;
/// The fewest samples to learn from.
const ENOUGH: usize = 5;
/// The largest root mean square distance from the grid while learning, as a share of a period.
const FIT: f64 = 0.09;
/// The variance of phase per refresh, in periods squared. Displays are steadier than that,
/// compositors are not.
const PHASE_DRIFT: f64 = 1e-8;
/// The variance of the period per refresh, in periods squared.
const PERIOD_DRIFT: f64 = 1e-15;
/// The least plausible standard deviation of a sample, in nanoseconds.
const LEAST_NOISE_NS: f64 = 5.0 * MICROSECOND_NS;
/// The number of consecutive errors of one sign that cannot be noise.
const ONE_SIDED: i32 = 12;
/// The weight of an outlier relative to good samples, and the sum of weights that ends the lock.
const OUTLIER_WEIGHT: u32 = 4;
const DISCORD: u32 = 12;
/// The number of samples earlier than the last one that prove the last one wrong.
const STALE: u32 = 6;

/// The known grid of refreshes.
#[derive(Clone, Copy, Debug)]
struct Lock {
    /// The time of a refresh.
    anchor: f64,
    period: f64,
    /// The covariance of (phase, period).
    phase_variance: f64,
    covariance: f64,
    period_variance: f64,
    /// The variance of a sample.
    noise: f64,
    /// The number of consecutive samples that were later than predicted; negative if they were
    /// earlier.
    one_sided: i32,
}

/// A clock that learns and predicts refreshes, with all times in nanoseconds.
#[derive(Clone, Debug)]
pub(crate) struct RefreshClock {
    hint: Option<f64>,
    samples: [f64; WINDOW],
    count: usize,
    lock: Option<Lock>,
    discord: u32,
    /// The number of consecutive samples that lay before the last one.
    stale: u32,
    /// The number of times that the grid was learnt anew.
    generation: u32,
}

impl RefreshClock {
    pub(crate) const fn new(hint: Option<f64>) -> Self {
        Self {
            hint,
            samples: [0.0; WINDOW],
            count: 0,
            lock: None,
            discord: 0,
            stale: 0,
            generation: 0,
        }
    }

    /// Notes the time of a refresh. Times that are not after the last one are ignored.
    pub(crate) fn observe(&mut self, at: f64) {
        if self.count > 0 && at <= self.samples[self.count - 1] {
            // A single time far in the future must not suppress all later ones.
            self.stale += 1;
            if self.stale >= STALE {
                self.forget(None);
            }
            return;
        }
        self.stale = 0;
        if self.count == WINDOW {
            self.samples.copy_within(1.., 0);
            self.count -= 1;
        }
        self.samples[self.count] = at;
        self.count += 1;
        if let Some(mut lock) = self.lock {
            let agreed = lock.follow(at);
            self.lock = Some(lock);
            if agreed {
                self.discord = self.discord.saturating_sub(1);
                return;
            }
            self.discord += OUTLIER_WEIGHT;
            if self.discord < DISCORD {
                return;
            }
            // The newest samples caused this; older ones belong to another grid.
            self.lock = None;
            self.samples.copy_within(self.count.saturating_sub(ENOUGH)..self.count, 0);
            self.count = self.count.min(ENOUGH);
            self.generation += 1;
        }
        self.discord = 0;
        self.learn();
    }

    /// Learns the period from the newest samples again, because its predictions fail.
    pub(crate) fn doubt(&mut self) {
        let before = self.period();
        self.lock = None;
        self.discord = 0;
        self.learn();
        let same = before.zip(self.period()).is_some_and(|(a, b)| (a / b - 1.0).abs() < 0.02);
        self.generation += u32::from(!same);
    }

    /// Forgets the phase, but keeps the period as a hint.
    pub(crate) fn forget(&mut self, hint: Option<f64>) {
        let generation = self.generation + 1;
        *self = Self { generation, ..Self::new(hint.or(self.period()).or(self.hint)) };
    }

    pub(crate) fn period(&self) -> Option<f64> {
        self.lock.map(|lock| lock.period)
    }

    /// Returns the first refresh at or after a time.
    pub(crate) fn at_or_after(&self, time: f64) -> Option<f64> {
        let lock = self.lock?;
        let refreshes = ((time - lock.anchor) / lock.period - 1e-6).ceil();
        Some(lock.anchor + refreshes * lock.period)
    }

    /// Returns the standard deviation of a prediction for a time near `time`.
    pub(crate) fn uncertainty(&self, time: f64) -> Option<f64> {
        let lock = self.lock?;
        let refreshes = ((time - lock.anchor) / lock.period).max(0.0);
        Some(lock.predicted(refreshes).0.sqrt())
    }

    /// Returns a number that changes when the grid is learnt anew, which makes earlier predictions
    /// invalid.
    pub(crate) const fn generation(&self) -> u32 {
        self.generation
    }

    pub(crate) fn agrees_with_hint(&self) -> bool {
        let both = self.hint.zip(self.period());
        both.is_some_and(|(hint, period)| (hint / period - 1.0).abs() < 0.05)
    }

    fn learn(&mut self) {
        // The newest few samples first, since the very first frames may have been shown between
        // refreshes.
        for count in [ENOUGH, self.count] {
            let Some(first) = self.count.checked_sub(count) else { return };
            let samples = &self.samples[first..self.count];
            let steps = samples.windows(2).map(|pair| pair[1] - pair[0]);
            let shortest = steps.clone().fold(f64::INFINITY, f64::min);
            let halves = steps.filter(|step| (2.0 * step / shortest).round() % 2.0 == 1.0).count();
            // The hint is used if it explains the samples. Half of the shortest step explains
            // nearly all samples, so it is tried last.
            self.lock = self
                .hint
                .and_then(|hint| fit(samples, hint))
                .or_else(|| fit(samples, shortest))
                .or_else(|| (halves > 2).then(|| fit(samples, shortest / 2.0)).flatten());
            if self.lock.is_some() {
                return;
            }
        }
    }
}

impl Lock {
    /// Returns the variances (phase, covariance, period) after this number of refreshes.
    fn predicted(&self, refreshes: f64) -> (f64, f64, f64) {
        let square = self.period * self.period;
        let phase = self.phase_variance
            + 2.0 * refreshes * self.covariance
            + refreshes * refreshes * self.period_variance
            + refreshes * square * PHASE_DRIFT;
        let covariance = self.covariance + refreshes * self.period_variance;
        (phase.max(0.0), covariance, self.period_variance + refreshes * square * PERIOD_DRIFT)
    }

    /// Updates the lock with a sample, or returns false if the sample is off the grid.
    fn follow(&mut self, at: f64) -> bool {
        let refreshes = ((at - self.anchor) / self.period).round();
        if refreshes < 1.0 {
            // Too soon after the last sample: another sample of the same refresh, or a finer grid.
            return at - self.anchor < 0.3 * self.period;
        }
        let expected = self.anchor + refreshes * self.period;
        let (mut phase, covariance, mut period) = self.predicted(refreshes);
        let error = at - expected;
        let side = if error > 0.0 { 1 } else { -1 };
        self.one_sided = if self.one_sided * side > 0 { self.one_sided + side } else { side };
        if self.one_sided.abs() >= ONE_SIDED {
            // This is not noise: the period has changed slightly.
            self.one_sided = 0;
            phase += error * error;
            period += error * error / f64::from(ONE_SIDED).powi(2);
            self.noise = self.noise.min(error * error);
        }
        let variance = phase + self.noise;
        let gate = (5.0 * variance.sqrt()).clamp(0.03 * self.period, 0.3 * self.period);
        if error.abs() > gate {
            return false;
        }
        let phase_gain = phase / variance;
        let period_gain = covariance / variance;
        self.anchor = expected + phase_gain * error;
        self.period += period_gain * error;
        self.phase_variance = (1.0 - phase_gain) * phase;
        self.covariance = (1.0 - phase_gain) * covariance;
        self.period_variance = (period - period_gain * covariance).max(0.0);
        let noise = self.noise + (error * error - self.noise) / 32.0;
        self.noise = noise.max(LEAST_NOISE_NS * LEAST_NOISE_NS);
        true
    }
}

/// Returns a line through the samples if all of them lie near multiples of about the period
/// `about`.
fn fit(samples: &[f64], about: f64) -> Option<Lock> {
    if !about.is_finite() || about < 100.0 * MICROSECOND_NS {
        return None;
    }
    let origin = samples[0];
    let count = samples.len() as f64;
    // Steps are rounded individually, so that an error of the period does not add up.
    let mut index = 0.0;
    let mut previous = origin;
    let [mut sum_i, mut sum_t, mut sum_ii, mut sum_it] = [0.0; 4];
    for &sample in samples {
        index += ((sample - previous) / about).round();
        previous = sample;
        let time = sample - origin;
        sum_i += index;
        sum_t += time;
        sum_ii += index * index;
        sum_it += index * time;
    }
    let spread = sum_ii - sum_i * sum_i / count;
    if spread < 1.0 || index < count - 1.0 {
        return None;
    }
    let period = (sum_it - sum_i * sum_t / count) / spread;
    let start = (sum_t - period * sum_i) / count;
    if (period / about - 1.0).abs() > 0.2 {
        return None;
    }
    let mut index_again = 0.0;
    let mut squares = 0.0;
    previous = origin;
    for &sample in samples {
        index_again += ((sample - previous) / about).round();
        previous = sample;
        let error = sample - origin - start - index_again * period;
        squares += error * error;
    }
    let noise = (squares / (count - 2.0)).max(1e-6 * period * period);
    if noise > FIT * FIT * period * period {
        return None;
    }
    let from_mean = index - sum_i / count;
    Some(Lock {
        anchor: origin + start + index * period,
        period,
        phase_variance: noise / count + noise * from_mean * from_mean / spread,
        covariance: noise * from_mean / spread,
        period_variance: noise / spread,
        noise,
        one_sided: 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 16_683_350.0;

    fn locked(samples: impl Iterator<Item = f64>) -> RefreshClock {
        let mut clock = RefreshClock::new(None);
        samples.for_each(|at| clock.observe(at));
        clock
    }

    #[test]
    fn exact_samples_give_the_exact_grid() {
        let clock = locked((0..40).map(|n| 7e6 + PERIOD * f64::from(n)));
        assert!((clock.period().unwrap() - PERIOD).abs() < 1.0);
        let next = clock.at_or_after(7e6 + PERIOD * 100.5).unwrap();
        assert!((next - (7e6 + PERIOD * 101.0)).abs() < 100.0);
    }

    #[test]
    fn gaps_are_multiples() {
        let steps = [1, 1, 2, 1, 3, 1, 1, 2, 5, 1, 1, 1];
        let times = steps.iter().scan(0, |sum, step| {
            *sum += step;
            Some(1e9 + PERIOD * f64::from(*sum))
        });
        assert!((locked(times).period().unwrap() - PERIOD).abs() < 1.0);
    }

    #[test]
    fn noise_averages_out_and_uncertainty_tells_how_far() {
        let noise = |n: i32| f64::from((n * 7_919) % 401 - 200) * 1e3;
        let clock = locked((0..400).map(|n| PERIOD * f64::from(n) + noise(n)));
        let error = (clock.period().unwrap() - PERIOD).abs();
        assert!(error < 2e3, "{error} ns");
        let near = clock.uncertainty(PERIOD * 401.0).unwrap();
        let far = clock.uncertainty(PERIOD * 9_000.0).unwrap();
        assert!(near < 1e5 && far > 5.0 * near, "{near} {far}");
        let off = clock.at_or_after(PERIOD * 500.5).unwrap() - PERIOD * 501.0;
        assert!(off.abs() < 5.0 * clock.uncertainty(PERIOD * 501.0).unwrap());
    }

    #[test]
    fn another_rate_is_learnt_and_an_outlier_is_not() {
        let mut clock = locked((0..50).map(|n| PERIOD * f64::from(n)));
        clock.observe(PERIOD * 50.4);
        clock.observe(PERIOD * 51.0);
        assert!((clock.period().unwrap() - PERIOD).abs() < 1e3);
        let base = PERIOD * 52.3;
        (0..40).for_each(|n| clock.observe(base + 6.94e6 * f64::from(n)));
        assert!((clock.period().unwrap() - 6.94e6).abs() < 1e4, "{:?}", clock.period());
    }

    #[test]
    fn a_period_that_changes_a_little_is_followed() {
        let mut clock = locked((0..600).map(|n| PERIOD * f64::from(n)));
        let slower = PERIOD * 1.0013;
        (1..200).for_each(|n| clock.observe(PERIOD * 599.0 + slower * f64::from(n)));
        assert!((clock.period().unwrap() / slower - 1.0).abs() < 1e-4, "{:?}", clock.period());
        let next = clock.at_or_after(PERIOD * 599.0 + slower * 199.5).unwrap();
        assert!((next - (PERIOD * 599.0 + slower * 200.0)).abs() < 0.01 * PERIOD);
    }

    #[test]
    fn random_times_are_no_grid() {
        let mut state = 1_u64;
        let mut time = 0.0;
        let clock = locked((0..200).map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            time += 1e6 + (state >> 40) as f64;
            time
        }));
        assert!(clock.uncertainty(1e18).is_none_or(f64::is_finite));
        assert!(clock.at_or_after(1e18).is_none_or(f64::is_finite));
    }
}
