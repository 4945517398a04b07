//! Cuts the tests of a frame into slabs, front to back. Each slab is tested against the depth that
//! the draws of the previous slab left.

use std::ops::Range;

use crate::plan::config::CullConfig;
use crate::plan::frame_plan::{DrawPhases, FramePlan, ProxyTest, VisibilityTest};

/// The lengths of the slabs of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slabs {
    /// All slabs have the same length, as in a calm frame.
    Equal,
    /// Each slab is twice as long as the one before, as after a cut.
    Doubling,
}

impl Slabs {
    /// Returns the length of a round relative to the first.
    fn weight(self, round: usize) -> usize {
        match self {
            Self::Equal => 1,
            Self::Doubling => 1 << round,
        }
    }
}

/// The costs that decide how many rounds pay off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoundCosts {
    /// The cost of a further round.
    pub(crate) round_ns: f32,
    /// The expected time of all draws that the tests reveal, over the frames for which the leaves
    /// then count as visible.
    pub(crate) revealed_ns: f32,
}

impl RoundCosts {
    /// Returns the number of rounds with the best balance, at most `most`. Every further round
    /// costs an interruption of rendering and may save draws: the draws of one round may hide
    /// objects of the next. At most, every draw is saved whose occluder lies in another slab. For
    /// pairs drawn at random, the share of these is one minus the sum of the squared shares of the
    /// slabs.
    fn best(self, most: u32, slabs: Slabs) -> u32 {
        let net_ns = |rounds: u32| {
            let weights = (0..rounds).map(|round| slabs.weight(round as usize) as f32);
            let (sum, squares) = weights.fold((0.0, 0.0), |(sum, squares), weight| {
                (sum + weight, squares + weight * weight)
            });
            let apart = 1.0 - squares / (sum * sum);
            self.revealed_ns * apart - (rounds - 1) as f32 * self.round_ns
        };
        let pays = |a: &u32, b: &u32| net_ns(*a).total_cmp(&net_ns(*b));
        (1..=most.clamp(1, ROUNDS_MAX)).max_by(pays).unwrap_or(1)
    }
}

/// The most rounds of a frame.
const ROUNDS_MAX: u32 = 16;

/// Cuts the tests of `plan` into rounds. `draw_phases` and `tester` limit their number, and so do
/// `device_costs`: no more rounds than pay off.
pub(crate) fn schedule(
    plan: &mut FramePlan,
    tester: VisibilityTest,
    draw_phases: DrawPhases,
    slabs: Slabs,
    device_costs: Option<RoundCosts>,
    config: &CullConfig,
) {
    let most = match (draw_phases, tester, slabs) {
        (DrawPhases::Two, ..) => 1,
        (_, VisibilityTest::Compute, Slabs::Equal) => config.tuning.rounds_compute_calm,
        (_, VisibilityTest::Compute, Slabs::Doubling) => config.tuning.rounds_compute_cut,
        (_, _, Slabs::Equal) => config.rounds_calm,
        (_, _, Slabs::Doubling) => config.tuning.rounds_cut,
    };
    let most = device_costs.map_or(most, |device_costs| device_costs.best(most, slabs));
    split(plan.tests.len(), most, slabs, config, &mut plan.rounds);
}

/// Fills `rounds` with at most `wished` ranges of the lengths of `slabs` that cover `0..tests`.
fn split(
    tests: usize,
    wished: u32,
    slabs: Slabs,
    config: &CullConfig,
    rounds: &mut Vec<Range<usize>>,
) {
    rounds.clear();
    let worth = tests / (config.tuning.round_tests_min.max(1) as usize);
    let count = (wished.min(ROUNDS_MAX) as usize).min(worth).max(1);
    let total: usize = (0..count).map(|round| slabs.weight(round)).sum();
    let mut passed = 0;
    let mut start = 0;
    for round in 0..count {
        passed += slabs.weight(round);
        let end = if round + 1 == count {
            tests
        } else {
            (tests as u64 * passed as u64 / total as u64) as usize
        };
        if end > start {
            rounds.push(start..end);
            start = end;
        }
    }
}

/// Groups the tests of each round by their tester, front to back within a group: the order of tests
/// within a round does not matter. `scratch` keeps its memory.
pub(crate) fn group_by_tester(plan: &mut FramePlan, scratch: &mut Grouping) {
    let tests = &mut plan.tests;
    let rounds = &plan.rounds;
    scratch.places.clear();
    scratch.places.resize(tests.len(), 0);
    for round in rounds {
        scratch.grouped.clear();
        for kind in [Answers::Queries, Answers::Compute, Answers::Flags, Answers::Others] {
            for (number, test) in round.clone().zip(&tests[round.clone()]) {
                if Answers::of(test.tester) == kind {
                    scratch.places[number] = (round.start + scratch.grouped.len()) as u32;
                    scratch.grouped.push(*test);
                }
            }
        }
        tests[round.clone()].copy_from_slice(&scratch.grouped);
    }
    for test in tests {
        if let VisibilityTest::SharedProxy(front) = &mut test.tester {
            *front = scratch.places[*front as usize];
        }
    }
}

/// The memory of [`group_by_tester`].
#[derive(Debug, Default)]
pub(crate) struct Grouping {
    grouped: Vec<ProxyTest>,
    /// The new index of each test.
    places: Vec<u32>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Answers {
    Queries,
    Compute,
    Flags,
    Others,
}

impl Answers {
    fn of(tester: VisibilityTest) -> Self {
        match tester {
            VisibilityTest::Query => Self::Queries,
            VisibilityTest::Compute => Self::Compute,
            VisibilityTest::Flag => Self::Flags,
            VisibilityTest::SharedProxy(_) => Self::Others,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounds(tests: usize, slabs: Slabs) -> Vec<Range<usize>> {
        let mut rounds = Vec::new();
        let config = CullConfig::default();
        let wished = match slabs {
            Slabs::Equal => config.rounds_calm,
            Slabs::Doubling => config.tuning.rounds_cut,
        };
        split(tests, wished, slabs, &config, &mut rounds);
        rounds
    }

    #[test]
    fn slabs_are_contiguous_and_complete() {
        for tests in 0..200 {
            for slabs in [Slabs::Equal, Slabs::Doubling] {
                let rounds = rounds(tests, slabs);
                let mut next = 0;
                for round in &rounds {
                    assert_eq!(round.start, next);
                    assert!(round.end > round.start);
                    next = round.end;
                }
                assert_eq!(next, tests);
            }
        }
    }

    #[test]
    fn rounds_are_as_many_as_pay() {
        let best = |round_ns, revealed_ns, most, slabs| {
            RoundCosts { round_ns, revealed_ns }.best(most, slabs)
        };
        for slabs in [Slabs::Equal, Slabs::Doubling] {
            assert_eq!(best(0.0, 1.0, 7, slabs), 7, "a break costs nothing");
            assert_eq!(best(0.0, 0.0, 7, slabs), 7);
            assert_eq!(best(1.0, 0.0, 7, slabs), 1, "nothing is revealed");
            assert_eq!(best(1.0, 1.9, 7, slabs), 1, "half of it at most is spared");
            assert_eq!(best(1.0, 1e9, 0, slabs), 1);
            assert_eq!(best(f32::MAX, f32::MAX, 40, slabs), 1);
            let counts = (0..12).map(|power| best(1.0, 3.0 * f32::powi(3.0, power), 16, slabs));
            let counts: Vec<u32> = counts.collect();
            assert!(counts.is_sorted() && counts.first() < counts.last(), "{counts:?}");
        }
        assert_eq!([3.0, 7.0].map(|revealed| best(1.0, revealed, 7, Slabs::Equal)), [2, 3]);
    }

    #[test]
    fn slabs_double_after_a_cut_only() {
        let doubling = [0..1, 1..4, 4..8, 8..18, 18..37, 37..74, 74..150];
        assert_eq!(rounds(150, Slabs::Doubling), doubling);
        assert_eq!(rounds(150, Slabs::Equal), [0..50, 50..100, 100..150]);
        assert_eq!(rounds(5, Slabs::Doubling).len(), 1);
    }
}
