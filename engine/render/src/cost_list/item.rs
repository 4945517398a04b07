//! The items of a cost list, and their costs. Pure: tests need no device.

use cull::VisibilityTest;
use gpu::{PredicationMode, Resubmission};
use occlusion::BenchItem;
pub use occlusion::{BoxSize, PredicateResult};

/// An action that a device performs many times in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CostItem {
    /// Draws of a hidden triangle, each under a predicate of this executor, including the resolve
    /// of all predicates.
    Predicates(PredicationMode, PredicateResult),
    /// Empty occlusion queries, including the copy of their results.
    Queries,
    /// Tests of hidden boxes of this size.
    Boxes(VisibilityTest, BoxSize),
    /// Tests of hidden boxes of this size by flags that all fragments may set, on a device that
    /// normally chooses one fragment.
    BoxesOfAllFragments(BoxSize),
    /// Draws of a hidden triangle by indirect calls with several draws each.
    IndirectDraws {
        /// The number of draws per call.
        per_call: u32,
    },
    /// Breaks: the end of a rendering, and the begin of the next with a load of the contents. Each
    /// rendering draws a hidden triangle.
    Breaks,
    /// Resets of queries. The CPU resets them, and the CPU time counts, if frames are submitted
    /// once; a command resets them if frames may be submitted again.
    Resets(Resubmission),
}

impl CostItem {
    /// Returns all items, in the order of tables.
    pub fn all() -> Vec<Self> {
        let results = [PredicateResult::Skipped, PredicateResult::Taken];
        let testers = [VisibilityTest::Query, VisibilityTest::Flag, VisibilityTest::Compute];
        let sizes = [BoxSize::Small, BoxSize::Large];
        let mut all: Vec<Self> = PredicationMode::ALL
            .into_iter()
            .flat_map(|executor| results.map(|result| Self::Predicates(executor, result)))
            .collect();
        all.push(Self::Queries);
        all.extend(
            testers.into_iter().flat_map(|tester| sizes.map(|size| Self::Boxes(tester, size))),
        );
        all.extend(sizes.map(Self::BoxesOfAllFragments));
        all.extend([10_000, 10].map(|per_call| Self::IndirectDraws { per_call }));
        all.push(Self::Breaks);
        all.extend([Resubmission::Never, Resubmission::Allowed].map(Self::Resets));
        all
    }

    /// Returns the name of the item in tables.
    #[must_use]
    pub fn name(self) -> String {
        let size = |size| match size {
            BoxSize::Small => "small",
            BoxSize::Large => "large",
        };
        match self {
            Self::Predicates(executor, PredicateResult::Skipped) => {
                format!("draws skipped by {}", executor.name())
            }
            Self::Predicates(executor, PredicateResult::Taken) => {
                format!("draws taken by {}", executor.name())
            }
            Self::Queries => "empty queries".to_owned(),
            Self::Boxes(VisibilityTest::Flag, of) => format!("{} boxes by flags", size(of)),
            Self::Boxes(VisibilityTest::Compute, of) => format!("{} boxes by compute", size(of)),
            Self::Boxes(_, of) => format!("{} boxes by queries", size(of)),
            Self::BoxesOfAllFragments(of) => {
                format!("{} boxes by flags of all fragments", size(of))
            }
            Self::IndirectDraws { per_call } => format!("draws in calls of {per_call}"),
            Self::Breaks => "breaks of a rendering".to_owned(),
            Self::Resets(Resubmission::Never) => "resets of queries by the CPU".to_owned(),
            Self::Resets(Resubmission::Allowed) => "resets of queries by a command".to_owned(),
        }
    }

    /// Returns the item of the bench that is measured.
    pub(super) fn benched(self) -> BenchItem {
        match self {
            Self::Predicates(executor, result) => BenchItem::Ranges { executor, width: 1, result },
            Self::Queries => BenchItem::EmptyQueries,
            Self::Boxes(tester, size) => BenchItem::Boxes(tester, size),
            Self::BoxesOfAllFragments(size) => BenchItem::BoxesOfAllFragments(size),
            Self::IndirectDraws { per_call } => BenchItem::Draws { per_call },
            Self::Breaks => BenchItem::Breaks,
            Self::Resets(by) => BenchItem::Resets(by),
        }
    }

    /// Returns the lowest number that differs from other items.
    pub(super) fn least(self) -> u32 {
        match self {
            Self::IndirectDraws { per_call } => per_call,
            _ => 1,
        }
    }

    /// Returns the highest number to measure together, which real frames do not exceed.
    pub(super) fn most(self) -> u32 {
        match self {
            Self::Breaks => 100,
            _ => 10_000,
        }
    }
}

/// The time of a number of equal items in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ItemCost {
    /// The item.
    pub item: CostItem,
    /// The number of items.
    pub count: u32,
    /// The median time of all these items together, less the time of a frame without them
    /// (nanoseconds); may be negative because of noise.
    pub total_ns: f64,
}

impl ItemCost {
    /// Returns the time of one item (nanoseconds).
    #[must_use]
    pub fn each_ns(&self) -> f64 {
        self.total_ns / f64::from(self.count.max(1))
    }
}

/// Returns the median of several times; NaN of an empty list.
pub(super) fn median(times: &mut [f64]) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    let low = times.len().saturating_sub(1) / 2;
    let high = times.len() / 2;
    match (times.get(low), times.get(high)) {
        (Some(low), Some(high)) => (low + high) * 0.5,
        _ => f64::NAN,
    }
}

/// Measures every candidate once per round, so that disturbances of the machine affect all
/// candidates alike. Returns the median of each candidate, in their order, or the first error of
/// `time`.
pub(super) fn interleaved_medians<C: Copy, E>(
    candidates: &[C],
    rounds: usize,
    mut time: impl FnMut(C) -> Result<f64, E>,
) -> Result<Vec<f64>, E> {
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); candidates.len()];
    for round in 0..rounds {
        for place in 0..candidates.len() {
            // Each round begins with another candidate.
            let place = (place + round) % candidates.len();
            if let (Some(candidate), Some(times)) = (candidates.get(place), times.get_mut(place)) {
                times.push(time(*candidate)?);
            }
        }
    }
    Ok(times.iter_mut().map(|times| median(times)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_median_is_in_the_middle_or_between_two() {
        assert_eq!(median(&mut [9.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [1.0, 4.0, 2.0, 9.0]), 3.0);
        assert!(median(&mut []).is_nan());
    }

    #[test]
    fn candidates_take_turns_and_one_disturbance_changes_no_median() {
        let mut order = Vec::new();
        let medians = interleaved_medians(&[10, 20, 30], 3, |candidate| {
            order.push(candidate);
            let disturbance = if order.len() == 5 { 1e6 } else { 0.0 };
            Ok::<_, ()>(f64::from(candidate) + disturbance)
        });
        assert_eq!(medians, Ok(vec![10.0, 20.0, 30.0]));
        assert_eq!(order, [10, 20, 30, 20, 30, 10, 30, 10, 20]);
        assert_eq!(interleaved_medians(&[1], 2, |_| Err::<f64, _>("lost")), Err("lost"));
    }

    #[test]
    fn every_item_has_a_name_of_its_own_and_a_cost_for_each() {
        let all = CostItem::all();
        let names: std::collections::BTreeSet<_> = all.iter().map(|item| item.name()).collect();
        assert_eq!(names.len(), all.len());
        let cost = ItemCost { item: CostItem::Queries, count: 100, total_ns: 5_000.0 };
        assert_eq!(cost.each_ns(), 50.0);
    }
}
