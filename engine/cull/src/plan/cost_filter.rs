//! Leaves out the tests of a plan that cost more than they save; untested leaves are drawn.

use std::ops::Range;

use crate::cost::learned_costs::{CostBenefit, LearnedCosts, TestEstimate, is_never};
use crate::geom::multi_view::MultiView;
use crate::plan::candidates::{Candidate, Draw, Prospect, Scratch};
use crate::plan::frame_plan::{
    FramePlan, PlanStats, ProxyTest, QueryKind, VisibilityTest, VisibilityTestSupport,
};
use crate::plan::rounds::RoundCosts;
use crate::plan::strategy::Strategy;
use crate::plan::traverse::Walk;

/// The inputs by which tests are weighed.
pub(crate) struct CostFilter<'a> {
    learned_costs: &'a LearnedCosts,
    /// The tester; `None` for the cheapest.
    tester: Option<VisibilityTest>,
    has_flags: bool,
    /// True if a compute shader may test a round.
    has_compute: bool,
    /// True if the compute shader was chosen for all rounds of the frame.
    is_all_compute: bool,
}

impl<'a> CostFilter<'a> {
    /// Creates a filter; `None` for strategies or cullers without a cost model.
    /// [`Strategy::ANTUMBRA`] uses the cheapest tester per test, all other strategies use `tester`.
    pub(crate) fn new(
        learned_costs: Option<&'a LearnedCosts>,
        strategy: Strategy,
        tester: VisibilityTest,
        testers: VisibilityTestSupport,
    ) -> Option<Self> {
        let is_open = strategy == Strategy::ANTUMBRA;
        learned_costs.filter(|_| strategy.uses_cost_model()).map(|learned_costs| Self {
            learned_costs,
            tester: (!is_open).then_some(tester),
            has_flags: testers.flags,
            has_compute: is_open && testers.compute,
            is_all_compute: false,
        })
    }

    /// Returns the tester of a box.
    pub(crate) fn tester(&self, estimate: &TestEstimate) -> VisibilityTest {
        self.tester.unwrap_or_else(|| self.learned_costs.cheaper(estimate, self.has_flags))
    }

    /// Assigns the rounds of `plan` for which the compute shader is cheapest to it, and returns
    /// their number. A test with a shared result can change its tester only together with the test
    /// whose result it shares. So two rounds with such a pair change together or not at all.
    pub(crate) fn hand_to_compute(&self, views: MultiView<'_>, plan: &mut FramePlan) -> u32 {
        match (self.is_all_compute, self.has_compute) {
            (true, _) => return plan.rounds.len() as u32,
            (false, false) => return 0,
            (false, true) => {}
        }
        let mut handed = 0_u64;
        for (bit, round) in plan.rounds.iter().take(64).enumerate() {
            if self.is_for_compute(views, plan.tests.get(round.clone()).unwrap_or_default()) {
                handed |= 1 << bit;
            }
        }
        let bit_of = |rounds: &[Range<usize>], number: usize| {
            rounds.iter().take(64).position(|round| round.contains(&number)).map_or(0, |at| 1 << at)
        };
        // Each pass that changes something takes at least one round back.
        while handed != 0 {
            let before = handed;
            for (number, test) in plan.tests.iter().enumerate() {
                let VisibilityTest::SharedProxy(front) = test.tester else { continue };
                let pair: u64 = bit_of(&plan.rounds, number) | bit_of(&plan.rounds, front as usize);
                if handed & pair != pair {
                    handed &= !pair;
                }
            }
            if handed == before {
                break;
            }
        }
        let is_handed = |(bit, _): &(usize, &Range<usize>)| *bit < 64 && handed >> bit & 1 == 1;
        for (_, round) in plan.rounds.iter().enumerate().filter(is_handed) {
            for test in plan.tests.get_mut(round.clone()).unwrap_or_default() {
                test.tester = VisibilityTest::Compute;
            }
        }
        handed.count_ones()
    }

    /// Returns true if the compute shader is the cheapest tester of a round of `tests`.
    fn is_for_compute(&self, views: MultiView<'_>, tests: &[ProxyTest]) -> bool {
        let is_own = |test: &&ProxyTest| !matches!(test.tester, VisibilityTest::SharedProxy(_));
        let boxes = tests.iter().filter(is_own).count() as u32;
        let shared = tests.len() as u32 - boxes;
        let covered = tests.iter().filter(is_own).map(|test| views.covered_pixels(&test.bounds));
        boxes > 0 && self.learned_costs.is_for_compute(boxes, shared, covered.sum(), self.has_flags)
    }

    /// Returns the costs that decide how many rounds pay off if `tester` tests them.
    pub(crate) fn round_costs(&self, tester: VisibilityTest, revealed_ns: f32) -> RoundCosts {
        RoundCosts { round_ns: self.learned_costs.round_ns(tester), revealed_ns }
    }

    pub(crate) fn estimate(views: MultiView<'_>, test: &Candidate) -> TestEstimate {
        TestEstimate {
            leaves: test.leaf_count,
            pixels: views.covered_pixels(&test.proxy),
            is_unknown: test.is_unknown(),
        }
    }

    /// Returns the saving and the cost of a test; `None` for kinds of tests that are few and do not
    /// justify a round.
    fn weigh(
        &self,
        kind: QueryKind,
        estimate: &TestEstimate,
        tester: VisibilityTest,
    ) -> Option<CostBenefit> {
        match kind {
            QueryKind::Proxy => Some(self.learned_costs.weigh(estimate, tester)),
            QueryKind::PullUpQuery => Some(self.learned_costs.weigh_pull_up(estimate, tester)),
            _ => None,
        }
    }

    /// Lets the compute shader test the whole frame if the tests pay off with it and with no other
    /// tester: its cost per box is so low that many tests can pay off that do not by pixels or
    /// queries. Where they pay off either way, [`CostFilter::hand_to_compute`] decides, because
    /// shared results are known there.
    fn choose_compute(&mut self, scratch: &Scratch, views: MultiView<'_>) {
        if !self.has_compute {
            return;
        }
        let drawn = scratch.draws.len() + scratch.retests.len();
        let [mut rastered_ns, mut computed_ns] = [VisibilityTest::Flag, VisibilityTest::Compute]
            .map(|tester| -self.learned_costs.break_ns(drawn, tester));
        let net_ns = |benefit: Option<CostBenefit>| {
            let benefit = benefit.filter(|benefit| benefit.pays());
            benefit.map_or(0.0, |benefit| benefit.saving_now_ns - benefit.cost_ns)
        };
        for test in &scratch.tests {
            let estimate = Self::estimate(views, test);
            rastered_ns += net_ns(self.weigh(test.kind, &estimate, self.tester(&estimate)));
            computed_ns += net_ns(self.weigh(test.kind, &estimate, VisibilityTest::Compute));
        }
        if computed_ns > 0.0 && rastered_ns <= 0.0 {
            self.tester = Some(VisibilityTest::Compute);
            self.is_all_compute = true;
        }
    }

    /// Removes each test that does not pay individually, and all tests if together they do not pay
    /// for the interruptions of rendering. Returns the tester of the rounds, if this filter
    /// determines it.
    pub(crate) fn drop_unpaid(
        &mut self,
        scratch: &mut Scratch,
        walk: &Walk<'_>,
        stats: &mut PlanStats,
    ) -> Option<VisibilityTest> {
        self.choose_compute(scratch, walk.views);
        let mut saving_ns = 0.0;
        let mut dropped_leaves = 0;
        scratch.revealed_ns = 0.0;
        for (test, is_dropped) in scratch.tests.iter().zip(&mut scratch.is_dropped) {
            let estimate = Self::estimate(walk.views, test);
            let Some(benefit) = self.weigh(test.kind, &estimate, self.tester(&estimate)) else {
                continue;
            };
            if benefit.pays() {
                // The interruptions are paid in every frame, so only the saving of this frame
                // counts: knowledge for later frames is worth nothing if later tests do not pay
                // either.
                saving_ns += benefit.saving_now_ns - benefit.cost_ns;
                scratch.revealed_ns += benefit.revealed_ns;
                continue;
            }
            *is_dropped = true;
            if test.kind == QueryKind::Proxy {
                dropped_leaves += test.leaf_count as usize;
            }
        }
        let drawn = scratch.draws.len() + scratch.retests.len() + dropped_leaves;
        let tester = self.tester.unwrap_or(VisibilityTest::Flag);
        let break_ns = self.learned_costs.break_ns(drawn, tester);
        scratch.prospect = Prospect { saving_ns, break_ns };
        if saving_ns < break_ns {
            scratch.is_dropped.fill(true);
            saving_ns = 0.0;
        }
        stats.expected_saving_ns = saving_ns as u64;
        draw_untested(scratch, walk, stats);
        if is_never(walk.config.retest_max) {
            scratch.draw_unasked(0);
        }
        scratch.discard();
        scratch.sort_draws();
        self.tester
    }
}

/// Draws the leaves of the marked tests.
fn draw_untested(scratch: &mut Scratch, walk: &Walk<'_>, stats: &mut PlanStats) {
    for (test, is_dropped) in scratch.tests.iter().zip(&scratch.is_dropped) {
        if !is_dropped || test.kind != QueryKind::Proxy {
            continue;
        }
        // A leaf that counts as hidden but is drawn for its low cost is tested now and then: it may
        // be visible by now, and is then not a reason to test it with its neighbours any more.
        let is_tested =
            test.leaf_count == 1 && !test.is_unknown() && walk.is_turn_to_retest(test.node);
        walk.leaves_in_frustum(test.node, &mut scratch.stack, |leaf| {
            stats.untested_by_cost += 1;
            if is_tested {
                scratch.retests.push(leaf);
                return;
            }
            scratch.draws.push(Draw { nearness: leaf.nearness, leaf: leaf.leaf });
            if test.is_unknown() {
                scratch.assumed.push([leaf.node, test.node]);
            }
        });
    }
}
