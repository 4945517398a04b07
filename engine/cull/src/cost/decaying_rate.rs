//! Counts of the results of tests, which fade: recent results have more weight.

/// The number of frames after which evidence has half its weight.
const HALF_LIFE_FRAMES: f32 = 64.0;

/// The most results that count: more would not make a rate more certain.
const MOST: f32 = 256.0;

/// Fading counts of positive and negative results.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DecayingRate {
    pub(crate) yes: f32,
    pub(crate) no: f32,
}

impl DecayingRate {
    pub(crate) fn note(&mut self, is_so: bool) {
        let sum = self.yes + self.no;
        if sum >= MOST {
            let keep = (MOST - 1.0) / sum;
            self.yes *= keep;
            self.no *= keep;
        }
        if is_so {
            self.yes += 1.0;
        } else {
            self.no += 1.0;
        }
    }

    pub(crate) fn fade(&mut self) {
        let keep = keep();
        self.yes *= keep;
        self.no *= keep;
    }

    /// Returns the probability of a positive result, given `prior` and these counts.
    pub(crate) fn probability(&self, prior: Self) -> f32 {
        (self.yes + prior.yes) / (self.yes + self.no + prior.yes + prior.no)
    }
}

/// The rate at which visible leaves turn out hidden.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct HideRate {
    hides: f64,
    /// The number of visible leaves, summed over frames.
    exposure: f64,
}

/// The weight of the prior rate, in leaves times frames.
const EXPECTED_EXPOSURE: f64 = 256.0;

impl HideRate {
    pub(crate) fn note(&mut self) {
        self.hides += 1.0;
    }

    /// Fades the counts by one frame that has `visible` visible leaves.
    pub(crate) fn fade(&mut self, visible: u32) {
        let keep = f64::from(keep());
        self.hides *= keep;
        self.exposure = self.exposure * keep + f64::from(visible);
    }

    /// Returns the probability per leaf and frame that a visible leaf becomes hidden, with the
    /// prior `expected`.
    pub(crate) fn per_leaf_and_frame(&self, expected: f64) -> f64 {
        (self.hides + expected * EXPECTED_EXPOSURE) / (self.exposure + EXPECTED_EXPOSURE)
    }
}

fn keep() -> f32 {
    (-std::f32::consts::LN_2 / HALF_LIFE_FRAMES).exp()
}
