//! Tests of the corrections with exact, noisy and nonsensical times.

use super::*;
use crate::rng::SplitMix64;

/// Frames with various draws and tests, on a device where the rest takes 10 ms.
struct Frames {
    rng: SplitMix64,
    learner: Learner,
    /// The factors by which draws and tests are more expensive than the table says.
    truth: [f64; 2],
    /// The relative error of the times.
    noise: f64,
    /// The average interval between frames that take ten times as long; 0 for none.
    odd_one_in: u32,
    rest_ns: f64,
}

impl Frames {
    fn new(truth: [f64; 2], seed: u64) -> Self {
        let rng = SplitMix64::new(seed);
        let learner = Learner::default();
        Self { rng, learner, truth, noise: 0.0, odd_one_in: 0, rest_ns: 10.0e6 }
    }

    fn share(&mut self) -> f64 {
        f64::from(self.rng.between(0, 10_000)) / 10_000.0
    }

    fn step(&mut self) -> f64 {
        let draw_ns = 2.0e6 + 2.0e6 * self.share();
        let test_ns = 1.0e6 + 2.0e6 * self.share();
        let clean = self.rest_ns + self.truth[0] * draw_ns + self.truth[1] * test_ns;
        let noisy = clean * (1.0 + self.noise * (2.0 * self.share() - 1.0));
        let is_odd = self.odd_one_in > 0 && self.rng.between(1, self.odd_one_in) == 1;
        let gpu_ns = if is_odd { 10.0 * noisy } else { noisy };
        self.learner.note(gpu_ns, Predicted { draw_ns, test_ns });
        self.learner.proportion
    }

    fn steps(&mut self, frames: usize) -> f64 {
        (0..frames).map(|_| self.step()).last().unwrap_or(1.0)
    }
}

#[test]
fn what_is_dearer_or_cheaper_is_found() {
    for (truth, low, high) in [
        ([1.0, 5.0], 3.0, 5.5),
        ([1.0, 3.0], 2.0, 3.3),
        ([1.0, 0.2], 0.15, 0.8),
        ([2.0, 2.0], 0.9, 1.1),
        ([1.0, 1.0], 0.9, 1.1),
        ([0.5, 2.5], 2.0, 5.6),
    ] {
        for seed in 0..10 {
            let mut frames = Frames { noise: 0.05, ..Frames::new(truth, seed) };
            let found = frames.steps(128);
            assert!(found > low && found < high, "{truth:?}: {found} {:?}", frames.learner);
        }
    }
}

#[test]
fn noise_and_odd_frames_move_next_to_nothing() {
    for seed in 0..20 {
        let noisy = Frames { noise: 0.3, odd_one_in: 20, ..Frames::new([1.0, 1.0], seed) };
        let mut frames = noisy;
        let mut most = 1.0_f64;
        for _ in 0..4_000 {
            let found = frames.step();
            most = most.max(found).max(1.0 / found);
        }
        assert!(most < 1.5, "{most} with seed {seed}");
    }
}

#[test]
fn another_rest_is_no_reason_to_believe_in_dearer_tests() {
    for seed in 0..10 {
        let mut frames = Frames { noise: 0.05, ..Frames::new([1.0, 1.0], seed) };
        for cut in 0..20 {
            frames.rest_ns = [10.0e6, 60.0e6, 3.0e6][cut % 3];
            for _ in 0..60 {
                let found = frames.step();
                assert!(found > 0.7 && found < 1.4, "{found} with seed {seed}, cut {cut}");
            }
        }
    }
}

#[test]
fn frames_that_are_all_alike_teach_nothing_about_tests() {
    let mut learner = Learner::default();
    for _ in 0..5_000 {
        learner.note(40.0e6, Predicted { draw_ns: 3.0e6, test_ns: 2.0e6 });
    }
    assert_eq!(learner.proportion, 1.0);
}

#[test]
fn what_is_no_longer_seen_is_forgotten() {
    let mut frames = Frames::new([1.0, 5.0], 1);
    assert!(frames.steps(128) > 4.0);
    let mut forgotten = 0;
    while frames.learner.proportion > 1.2 {
        frames.learner.note(13.0e6, Predicted { draw_ns: 3.0e6, test_ns: 0.0 });
        forgotten += 1;
        assert!(forgotten < 1_000, "{:?}", frames.learner);
    }
    assert!(forgotten > 100, "not at once: {forgotten}");
}

#[test]
fn times_that_cannot_be_are_ignored() {
    let mut frames = Frames::new([1.0, 5.0], 1);
    frames.steps(128);
    let before = frames.learner.corrections();
    let sound = Predicted { draw_ns: 3.0e6, test_ns: 2.0e6 };
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, 1.0e15, f64::MAX] {
        for _ in 0..100 {
            frames.learner.note(bad, sound);
            frames.learner.note(1.0e7, Predicted { draw_ns: bad, test_ns: bad });
        }
    }
    for _ in 0..100 {
        frames.learner.note(1.0e-300, sound);
        frames.learner.note(1.0e7, Predicted { draw_ns: 0.0, test_ns: 0.0 });
    }
    let after = frames.learner.corrections();
    assert!((after.proportion - before.proportion).abs() < 1.0, "{before:?} {after:?}");
    for value in [after.draws, after.tests, after.proportion] {
        assert!((0.125..=8.0).contains(&value), "{after:?}");
    }
}

#[test]
fn corrections_stay_within_their_bounds() {
    for truth in [[1.0, 1_000.0], [1_000.0, 1.0], [1.0, 0.0], [0.0, 1.0], [1.0e3, 1.0e3]] {
        let mut frames = Frames::new(truth, 7);
        for _ in 0..2_000 {
            frames.step();
            let found = frames.learner.corrections();
            for value in [found.draws, found.tests, found.proportion] {
                assert!((0.125..=8.0).contains(&value), "{truth:?}: {found:?}");
            }
        }
    }
}
