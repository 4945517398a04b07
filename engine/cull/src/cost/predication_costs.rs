//! The costs of the ways to keep the GPU from drawing hidden objects, and the choice among these
//! ways. The module measures nothing: it gets the times of a device and returns an index.

/// The costs of one way to skip hidden draws, in nanoseconds of GPU time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PredicationCosts {
    /// A round: the time to turn the results of its tests into data that its draws depend on.
    pub round_ns: f32,
    /// A range of draws that depends on a result, including one skipped draw.
    pub range_ns: f32,
    /// Each further draw of a range.
    pub draw_ns: f32,
}

/// The work that a frame skips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SkippedWork {
    /// Rounds of tests.
    pub rounds: u32,
    /// Ranges of draws that depend on a result.
    pub ranges: u32,
    /// Draws of all ranges together.
    pub draws: u32,
}

/// The GPU times of frames that skip ranges of draws, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkipTimes {
    /// A frame without ranges, but with a draw.
    pub nothing_ns: f64,
    /// A frame with [`SkipTimes::RANGES`] ranges of one draw each, in one round.
    pub few_ns: f64,
    /// A frame with twice the ranges of `few_ns`.
    pub many_ns: f64,
    /// A frame with [`SkipTimes::RANGES`] ranges of [`SkipTimes::WIDE_DRAWS`] draws each, in one
    /// round.
    pub wide_ns: f64,
}

/// The measured costs of one way to skip hidden draws.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredSkip {
    /// The costs from the shortest time of each batch.
    pub costs: PredicationCosts,
    /// The costs from each measuring round, in which all ways took turns.
    pub rounds: Vec<PredicationCosts>,
}

/// The factor by which a way must be cheaper than the first way: smaller differences may be noise.
const LEAST_GAIN: f64 = 1.25;

/// The least measuring rounds that can show that a way is cheaper: its most expensive round must be
/// cheaper than the cheapest round of the first way. For two equal ways, noise causes this once in
/// 70 times.
const LEAST_ROUNDS: usize = 4;

impl SkipTimes {
    /// The number of ranges in the shorter measurement.
    pub const RANGES: u32 = 256;
    /// The number of draws in a wide range.
    pub const WIDE_DRAWS: u32 = 8;

    /// Returns the costs that follow from the times. A negative cost, which is noise, becomes 0.
    /// The NaN of a time that was not measured stays.
    #[must_use]
    pub fn costs(&self) -> PredicationCosts {
        let ranges = f64::from(Self::RANGES);
        let at_least_0 = |value: f64| if value < 0.0 { 0.0 } else { value };
        let range_ns = at_least_0((self.many_ns - self.few_ns) / ranges);
        let further = f64::from(Self::WIDE_DRAWS - 1);
        PredicationCosts {
            round_ns: at_least_0(self.few_ns - ranges * range_ns - self.nothing_ns) as f32,
            range_ns: range_ns as f32,
            draw_ns: at_least_0((self.wide_ns - self.few_ns) / (ranges * further)) as f32,
        }
    }
}

impl SkippedWork {
    /// Returns the work that a frame skips in a scene of `leaves` objects that are nearly all
    /// hidden, as in a city at street level: one round, as in a calm frame, and twice the square
    /// root of the leaves in ranges, because subtrees are skipped as a whole.
    #[must_use]
    pub fn of_leaves(leaves: u32) -> Self {
        Self { rounds: 1, ranges: (2 * leaves.isqrt()).min(leaves), draws: leaves }
    }

    /// Returns this work for objects whose draws are divided into `buckets`: a subtree has one
    /// range in each bucket that contains draws of it.
    #[must_use]
    pub fn in_buckets(self, buckets: u32) -> Self {
        Self { ranges: self.ranges.saturating_mul(buckets.max(1)).min(self.draws), ..self }
    }
}

impl PredicationCosts {
    /// Returns the time that skipping this work takes in a frame (ns).
    #[must_use]
    pub fn frame_ns(&self, work: &SkippedWork) -> f64 {
        let each = |count: u32, cost_ns: f32| f64::from(count) * f64::from(cost_ns);
        each(work.rounds, self.round_ns)
            + each(work.ranges, self.range_ns)
            + each(work.draws.saturating_sub(work.ranges), self.draw_ns)
    }
}

impl MeasuredSkip {
    /// Returns the index of the way that skips `work` at the least cost. It is the first way unless
    /// another is cheaper by a quarter in the worst of several measuring rounds, so that noise does
    /// not decide. Costs that are not numbers are chosen only if all are so; `None` without any
    /// ways.
    #[must_use]
    pub fn cheapest(ways: &[Self], work: &SkippedWork) -> Option<usize> {
        let ns = |place: usize| ways.get(place).map_or(f64::NAN, |way| way.costs.frame_ns(work));
        let first = ways.first()?;
        let is_better = |place: &usize| {
            if ns(0).is_finite() {
                ways.get(*place).is_some_and(|other| other.is_surely_cheaper(first, work))
            } else {
                ns(*place).is_finite()
            }
        };
        let others = (1..ways.len()).filter(is_better);
        Some(others.min_by(|a, b| ns(*a).total_cmp(&ns(*b))).unwrap_or(0))
    }

    /// Returns true if the most expensive measuring round of this way is cheaper by a quarter than
    /// the cheapest round of `than`.
    fn is_surely_cheaper(&self, than: &Self, work: &SkippedWork) -> bool {
        let of = |way: &Self| -> Vec<f64> {
            way.rounds.iter().map(|costs| costs.frame_ns(work)).collect()
        };
        let own = of(self);
        let other = of(than);
        let dearest = own.iter().copied().fold(0.0, f64::max);
        own.len() >= LEAST_ROUNDS
            && own.iter().chain(&other).all(|ns| ns.is_finite())
            && other.iter().all(|ns| LEAST_GAIN * dearest < *ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::table::CostTable;

    const WORK: SkippedWork = SkippedWork { rounds: 2, ranges: 100, draws: 1_000 };

    fn at(round_ns: f32, range_ns: f32, draw_ns: f32) -> PredicationCosts {
        PredicationCosts { round_ns, range_ns, draw_ns }
    }

    /// Returns the times of a device with these costs, whose frames take `frame_ns` in addition.
    fn times(costs: PredicationCosts, frame_ns: f64) -> SkipTimes {
        let ns = |ranges: u32, each: u32| {
            let work = SkippedWork { rounds: 1, ranges, draws: ranges * each };
            frame_ns + costs.frame_ns(&work)
        };
        SkipTimes {
            nothing_ns: frame_ns,
            few_ns: ns(SkipTimes::RANGES, 1),
            many_ns: ns(2 * SkipTimes::RANGES, 1),
            wide_ns: ns(SkipTimes::RANGES, SkipTimes::WIDE_DRAWS),
        }
    }

    #[test]
    fn costs_follow_from_the_times_of_frames() {
        for costs in [at(5_000.0, 80.0, 3.0), at(0.0, 1_000.0, 0.0), at(90_000.0, 2.0, 0.5)] {
            let found = times(costs, 40_000.0).costs();
            let near = |a: f32, b: f32| (a - b).abs() <= 1e-3 * b.max(1.0);
            assert!(near(found.round_ns, costs.round_ns), "{found:?}");
            assert!(near(found.range_ns, costs.range_ns), "{found:?}");
            assert!(near(found.draw_ns, costs.draw_ns), "{found:?}");
        }
        let noise = SkipTimes { nothing_ns: 10.0, few_ns: 9.0, many_ns: 8.0, wide_ns: 7.0 };
        assert_eq!(noise.costs(), PredicationCosts::default());
        let unknown = SkipTimes { wide_ns: f64::NAN, ..times(at(1.0, 1.0, 1.0), 1.0) };
        assert!(unknown.costs().draw_ns.is_nan());
    }

    #[test]
    fn the_work_of_a_scene_grows_with_it() {
        assert_eq!(at(1.0, 10.0, 100.0).frame_ns(&WORK), 2.0 + 1_000.0 + 90_000.0);
        assert_eq!(SkippedWork::of_leaves(0), SkippedWork { rounds: 1, ranges: 0, draws: 0 });
        assert_eq!(SkippedWork::of_leaves(2).ranges, 2);
        assert_eq!(SkippedWork::of_leaves(10_000).ranges, 200);
        assert_eq!(SkippedWork::of_leaves(u32::MAX).draws, u32::MAX);
        let buckets = |count| SkippedWork::of_leaves(10_000).in_buckets(count).ranges;
        assert_eq!([0, 1, 16, u32::MAX].map(buckets), [200, 200, 3_200, 10_000]);
    }

    #[test]
    fn the_first_stays_unless_another_is_clearly_cheaper() {
        let way = |range_ns| {
            let costs = at(0.0, range_ns, 0.0);
            MeasuredSkip { costs, rounds: vec![costs; LEAST_ROUNDS] }
        };
        let [dear, near, cheap, unknown] = [100.0, 90.0, 20.0, f32::NAN].map(way);
        let cheapest = |ways: &[&MeasuredSkip]| {
            MeasuredSkip::cheapest(
                &ways.iter().map(|way| (*way).clone()).collect::<Vec<_>>(),
                &WORK,
            )
        };
        assert_eq!(cheapest(&[&dear, &near]), Some(0));
        assert_eq!(cheapest(&[&dear, &near, &cheap]), Some(2));
        assert_eq!(cheapest(&[&unknown, &near, &dear]), Some(1));
        assert_eq!(cheapest(&[&near, &unknown]), Some(0));
        assert_eq!(cheapest(&[&unknown, &unknown]), Some(0));
        assert_eq!(cheapest(&[]), None);
    }

    #[test]
    fn one_lucky_time_chooses_nothing() {
        let dear = at(0.0, 100.0, 0.0);
        let cheap = at(0.0, 20.0, 0.0);
        let first = MeasuredSkip { costs: dear, rounds: vec![dear; 4] };
        let lucky = MeasuredSkip { costs: cheap, rounds: vec![cheap, cheap, dear, cheap] };
        let once = MeasuredSkip { costs: cheap, rounds: vec![cheap] };
        let chosen = MeasuredSkip::cheapest(&[first, lucky, once], &WORK);
        assert_eq!(chosen, Some(0));
    }

    #[test]
    fn a_table_takes_the_costs_of_the_way_that_skips() {
        let table = CostTable::uniform(10.0).skipping_at(&at(5.0, 7.0, 3.0));
        assert_eq!((table.predicate_ns, table.skipped_draw_ns, table.break_ns), (7.0, 3.0, 15.0));
    }
}
