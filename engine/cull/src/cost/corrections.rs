//! Corrections of the costs of tests relative to draws, learned from the times of frames.
//!
//! Recursive least squares with a prior and forgetting, as a Kalman filter (R. E. Kalman 1960, "A
//! New Approach to Linear Filtering and Prediction Problems") for
//!
//! ```text
//! gpu_ns = draws * (draw_ns + test_ns) + excess * test_ns + rest_ns
//! ```
//!
//! where `draw_ns` and `test_ns` are the costs of the frame by the table. `rest_ns` is the work
//! that has no entry in the table, above all the shading of pixels. Tests cost `draws + excess`
//! times their cost in the table. The prior is that the table is right, and that the excess is 0
//! for any `draws`: a clock of a wrong scale makes everything more expensive and changes no
//! decision. The rest may have any size and drifts. So only frames that differ in their tests give
//! information about tests. The corrections fade back to the prior: if tests stopped because they
//! were expensive, a few are tried again after a while.
//!
//! The excess counts only as far as it is certain, so that noise does not affect decisions. A frame
//! with an implausible time is left out, unless several such frames in a row agree.

use crate::cost::contents::Predicted;

/// The corrections of the cost table that follow from the times of frames. Only `proportion`
/// affects decisions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corrections {
    /// The factor by which draws are more expensive than the table says (1/8 to 8).
    pub draws: f32,
    /// The factor by which tests are more expensive than the table says (1/8 to 8).
    pub tests: f32,
    /// The factor for the costs of tests: `tests` over `draws` as far as it is certain (1/8 to 8),
    /// and 1 until then.
    pub proportion: f32,
    /// The number of frames that this was learned from; 0 if the device does not measure times.
    pub frames: u64,
}

impl Default for Corrections {
    fn default() -> Self {
        Self { draws: 1.0, tests: 1.0, proportion: 1.0, frames: 0 }
    }
}

/// The largest correction, in either direction.
const MOST: f64 = 8.0;

/// The longest time of a frame (ns): a longer time means that the clock is wrong.
const LONGEST_NS: f64 = 60.0e9;
/// The shortest time of a frame (ns).
const SHORTEST_NS: f64 = 1.0;

/// The largest ratio of a predicted time to the times of frames; beyond it the frame is ignored.
const MOST_PREDICTED: f64 = 1.0e3;

/// The number of frames after which information about draws and tests has half its weight.
const HALF_LIFE_FRAMES: f64 = 64.0;

/// The prior variance of the factor of draws.
const DRAWS_VARIANCE: f64 = 1.0;
/// The prior variance of the excess: tests at five times their cost are two deviations away.
const EXCESS_VARIANCE: f64 = 4.0;

/// The drift of the rest per frame, relative to the time of a frame.
const REST_DRIFT: f64 = 0.01;

/// The number of deviations above which errors have less weight (Huber 1964, "Robust Estimation of
/// a Location Parameter").
const LARGE_ERROR: f64 = 2.0;
/// The number of deviations above which errors are ignored ...
const ODD_ERROR: f64 = 4.0;
/// ... unless this number of frames in a row is odd: then something has changed.
const ODD_FRAMES: u32 = 4;

/// The number of deviations after which a correction counts as certain.
const SURE: f64 = 2.0;

/// The least change of costs that is applied, so that decisions do not flip back and forth.
const LEAST_CHANGE: f64 = 1.125;

/// The indices in the state.
const DRAWS: usize = 0;
const EXCESS: usize = 1;
const REST: usize = 2;

/// The prior means and variances of draws and excess.
const PRIOR: [(f64, f64); 2] = [(1.0, DRAWS_VARIANCE), (0.0, EXCESS_VARIANCE)];

/// The estimate of the corrections with its covariance.
#[derive(Clone, Debug)]
pub(crate) struct Learner {
    /// The factor of draws, the excess, and the rest (ns).
    state: [f64; 3],
    covariance: [[f64; 3]; 3],
    /// The smoothed time of frames (ns).
    level_ns: f64,
    /// The average error of the predicted times (ns).
    noise_ns: f64,
    odd: u32,
    frames: u64,
    proportion: f64,
}

impl Default for Learner {
    fn default() -> Self {
        let [(draws, draws_variance), (excess, excess_variance)] = PRIOR;
        Self {
            state: [draws, excess, 0.0],
            covariance: [[draws_variance, 0.0, 0.0], [0.0, excess_variance, 0.0], [0.0; 3]],
            level_ns: 0.0,
            noise_ns: 0.0,
            odd: 0,
            frames: 0,
            proportion: 1.0,
        }
    }
}

impl Learner {
    pub(crate) fn corrections(&self) -> Corrections {
        Corrections {
            draws: self.state[DRAWS] as f32,
            tests: (self.state[DRAWS] + self.state[EXCESS]) as f32,
            proportion: self.proportion as f32,
            frames: self.frames,
        }
    }

    /// Takes the time of a frame. Returns true if the proportion changed.
    pub(crate) fn note(&mut self, gpu_ns: f64, predicted: Predicted) -> bool {
        let all_ns = predicted.draw_ns + predicted.test_ns;
        let can_be = (SHORTEST_NS..LONGEST_NS).contains(&gpu_ns);
        let most_ns = MOST_PREDICTED * gpu_ns.max(self.level_ns);
        if !(can_be && all_ns > 0.0 && all_ns < most_ns) {
            return false;
        }
        if self.frames == 0 {
            self.level_ns = gpu_ns;
            self.noise_ns = 0.1 * gpu_ns;
            self.covariance[REST][REST] = gpu_ns * gpu_ns;
        }
        self.frames += 1;
        self.level_ns *= (gpu_ns / self.level_ns).clamp(0.9, 1.1);
        self.reset();
        self.correct(gpu_ns, [all_ns, predicted.test_ns, 1.0]);
        self.settle()
    }

    /// Moves the state towards the prior: older information loses weight, the prior does not.
    fn reset(&mut self) {
        let keep = (-std::f64::consts::LN_2 / HALF_LIFE_FRAMES).exp();
        for (place, (mean, prior)) in PRIOR.into_iter().enumerate() {
            let variance = self.covariance[place][place];
            let kept = prior / (keep * prior + (1.0 - keep) * variance);
            self.state[place] = mean + keep * kept * (self.state[place] - mean);
            for other in 0..3 {
                self.covariance[place][other] *= kept.sqrt();
                self.covariance[other][place] *= kept.sqrt();
            }
        }
        self.covariance[REST][REST] += (REST_DRIFT * self.level_ns).powi(2);
    }

    /// Updates the estimate with the time of a frame.
    fn correct(&mut self, gpu_ns: f64, contents: [f64; 3]) {
        let error = gpu_ns - dot(self.state, contents);
        let noise_ns = self.noise_ns.max(0.01 * self.level_ns);
        let variance = (1.25 * noise_ns).powi(2);
        let expected = dot(self.times(contents), contents) + variance;
        let deviations = error.abs() / expected.sqrt();
        // Bounded, so that odd frames do not inflate the noise and then pass as normal.
        self.noise_ns = noise_ns + 0.05 * (error.abs().min(3.0 * noise_ns) - noise_ns);
        let is_odd = deviations > ODD_ERROR;
        self.odd = if is_odd { self.odd + 1 } else { 0 };
        if is_odd && self.odd < ODD_FRAMES {
            return;
        }
        if is_odd {
            self.odd = 0;
            self.rest_changed(error);
        }
        let weight = if is_odd { 1.0 } else { (LARGE_ERROR / deviations).min(1.0) };
        let towards = self.times(contents);
        let expected = dot(towards, contents) + variance / weight;
        for row in 0..3 {
            self.state[row] += towards[row] * error / expected;
            for column in 0..3 {
                self.covariance[row][column] -= towards[row] * towards[column] / expected;
            }
        }
        let draws = self.state[DRAWS].clamp(1.0 / MOST, MOST);
        self.state[DRAWS] = draws;
        self.state[EXCESS] = self.state[EXCESS].clamp(1.0 / MOST - draws, MOST - draws);
        // Rounding must not make a variance zero or negative.
        for (place, least) in [(DRAWS, 1.0e-9), (EXCESS, 1.0e-9), (REST, 1.0e-9 * variance)] {
            self.covariance[place][place] = self.covariance[place][place].max(least);
        }
    }

    /// Resets the knowledge of the rest to an uncertainty of about `error_ns`.
    fn rest_changed(&mut self, error_ns: f64) {
        for place in [DRAWS, EXCESS] {
            self.covariance[REST][place] = 0.0;
            self.covariance[place][REST] = 0.0;
        }
        self.covariance[REST][REST] = 4.0 * error_ns.powi(2).max(self.level_ns.powi(2));
    }

    fn times(&self, contents: [f64; 3]) -> [f64; 3] {
        self.covariance.map(|row| dot(row, contents))
    }

    /// Updates the proportion as far as it is certain. Returns true if it changed.
    fn settle(&mut self) -> bool {
        let beyond_doubt = |place: usize, mean: f64| {
            let learned = self.state[place] - mean;
            let variance = self.covariance[place][place];
            mean + learned.signum() * (learned.abs() - SURE * variance.sqrt()).max(0.0)
        };
        let [draws, excess] = [DRAWS, EXCESS].map(|place| beyond_doubt(place, PRIOR[place].0));
        let sure = (1.0 + excess / draws).clamp(1.0 / MOST, MOST);
        let change = (sure / self.proportion).max(self.proportion / sure);
        // A NaN changes nothing.
        let changes = change >= LEAST_CHANGE;
        if changes {
            self.proportion = sure;
        }
        changes
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests;
