//! Cuts the tests of a frame into slabs, front to back, each tested against the depth that the
//! draws of the previous one left.

use std::ops::Range;

use crate::plan::config::CullConfig;
use crate::plan::frame_plan::{DrawPhases, FramePlan, ProxyTest, Tester};

/// Cuts the tests of `plan`, which `tester` tests, into as many rounds as draws may come between.
pub(crate) fn schedule(
    plan: &mut FramePlan,
    (tester, draw_phases): (Tester, DrawPhases),
    is_cut: bool,
    config: &CullConfig,
) {
    let most = match (draw_phases, tester, is_cut) {
        (DrawPhases::Two, ..) => 1,
        (_, Tester::Compute, false) => config.rounds_compute_calm,
        (_, Tester::Compute, true) => config.rounds_compute_cut,
        (_, _, false) => config.rounds_calm,
        (_, _, true) => config.rounds_cut,
    };
    split(plan.tests.len(), most, is_cut, config, &mut plan.rounds);
}

/// Fills `rounds` with at most `wished` ranges that cover `0..tests`. After a cut each is twice as
/// long as the one before; in a calm frame they are equal.
fn split(
    tests: usize,
    wished: u32,
    is_cut: bool,
    config: &CullConfig,
    rounds: &mut Vec<Range<usize>>,
) {
    rounds.clear();
    let worth = tests / (config.round_tests_min.max(1) as usize);
    let count = (wished.min(16) as usize).min(worth).max(1);
    let weight = |round: usize| if is_cut { 1_usize << round } else { 1 };
    let total: usize = (0..count).map(weight).sum();
    let mut passed = 0;
    let mut start = 0;
    for round in 0..count {
        passed += weight(round);
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

/// Groups the tests of each round by their tester, front to back as they were: in a round nothing
/// depends on their order. `scratch` keeps its memory.
pub(crate) fn group_by_tester(plan: &mut FramePlan, scratch: &mut Grouping) {
    let (tests, rounds) = (&mut plan.tests, &plan.rounds);
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
        if let Tester::SharedProxy(front) = &mut test.tester {
            *front = scratch.places[*front as usize];
        }
    }
}

/// The memory of [`group_by_tester`].
#[derive(Debug, Default)]
pub(crate) struct Grouping {
    grouped: Vec<ProxyTest>,
    /// The new place of each test.
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
    fn of(tester: Tester) -> Self {
        match tester {
            Tester::Query => Self::Queries,
            Tester::Compute => Self::Compute,
            Tester::Flag => Self::Flags,
            Tester::SharedProxy(_) => Self::Others,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounds(tests: usize, is_cut: bool) -> Vec<Range<usize>> {
        let mut rounds = Vec::new();
        let config = CullConfig::default();
        let wished = if is_cut { config.rounds_cut } else { config.rounds_calm };
        split(tests, wished, is_cut, &config, &mut rounds);
        rounds
    }

    #[test]
    fn slabs_are_contiguous_and_complete() {
        for tests in 0..200 {
            for is_cut in [false, true] {
                let rounds = rounds(tests, is_cut);
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
    fn slabs_double_after_a_cut_only() {
        let doubling = [0..1, 1..4, 4..8, 8..18, 18..37, 37..74, 74..150];
        assert_eq!(rounds(150, true), doubling);
        assert_eq!(rounds(150, false), [0..50, 50..100, 100..150]);
        assert_eq!(rounds(5, true).len(), 1);
    }
}
