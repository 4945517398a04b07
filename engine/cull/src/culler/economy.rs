//! Leaves out the tests of a plan that cost more than they save; what is not tested is drawn.

use std::ops::Range;

use super::selection::{Candidate, Draw, Scratch};
use super::traversal::Walk;
use crate::cost_model::{CostModel, Question, covered_pixels, is_never};
use crate::plan::{FramePlan, PlanStats, ProxyTest, QueryKind, Tester};
use crate::view::View;

/// What tests are weighed by.
pub(super) struct Economy<'a> {
    pub(super) governor: &'a CostModel,
    /// Who answers; `None` for whoever is cheaper.
    pub(super) tester: Option<Tester>,
    pub(super) has_flags: bool,
}

impl Economy<'_> {
    /// Who answers for a box.
    pub(super) fn tester(&self, question: &Question) -> Tester {
        self.tester.unwrap_or_else(|| self.governor.cheaper(question, self.has_flags))
    }

    /// Gives those rounds of `plan` to the compute shader that cost least so, and says how many. A test
    /// that answers for others does not change without them, so rounds that have such in common go
    /// together or stay.
    pub(super) fn hand_to_compute(&self, view: &View, plan: &mut FramePlan) -> u32 {
        let mut handed = 0_u64;
        for (bit, round) in plan.rounds.iter().take(64).enumerate() {
            if self.is_for_compute(view, plan.tests.get(round.clone()).unwrap_or_default()) {
                handed |= 1 << bit;
            }
        }
        let bit_of = |rounds: &[Range<usize>], number: usize| {
            rounds.iter().take(64).position(|round| round.contains(&number)).map_or(0, |at| 1 << at)
        };
        // Each turn that changes something takes a round back.
        while handed != 0 {
            let before = handed;
            for (number, test) in plan.tests.iter().enumerate() {
                let Tester::Behind(front) = test.tester else { continue };
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
                test.tester = Tester::Compute;
            }
        }
        handed.count_ones()
    }

    /// Whether a round of `tests` costs least by compute shader.
    fn is_for_compute(&self, view: &View, tests: &[ProxyTest]) -> bool {
        let is_own = |test: &&ProxyTest| !matches!(test.tester, Tester::Behind(_));
        let boxes = tests.iter().filter(is_own).count() as u32;
        let shared = tests.len() as u32 - boxes;
        let covered = tests.iter().filter(is_own).map(|test| covered_pixels(view, &test.bounds));
        boxes > 0 && self.governor.is_for_compute(boxes, shared, covered.sum(), self.has_flags)
    }

    pub(super) fn question(view: &View, test: &Candidate) -> Question {
        Question {
            leaves: test.leaf_count,
            pixels: covered_pixels(view, &test.proxy),
            is_unknown: test.is_unknown(),
        }
    }
}

impl Scratch {
    /// Takes out each test that does not pay by itself, and all of them if together they do not pay
    /// for the breaks of rendering.
    pub(super) fn drop_by_cost(
        &mut self,
        walk: &Walk<'_>,
        economy: &Economy<'_>,
        stats: &mut PlanStats,
    ) {
        let mut saving_ns = 0.0;
        let mut dropped_leaves = 0;
        for (test, is_dropped) in self.tests.iter().zip(&mut self.is_dropped) {
            let question = Economy::question(walk.view, test);
            let tester = economy.tester(&question);
            let judgement = match test.kind {
                QueryKind::Proxy => economy.governor.judge(&question, tester),
                QueryKind::Probe => economy.governor.judge_probe(&question, tester),
                // Few, and no reason for a round.
                _ => continue,
            };
            if judgement.pays() {
                // Breaks are paid in every frame, so only what each frame saves pays for them: what
                // is known for later is worth nothing if later tests do not pay either.
                saving_ns += judgement.saving_now_ns - judgement.cost_ns;
                continue;
            }
            *is_dropped = true;
            if test.kind == QueryKind::Proxy {
                dropped_leaves += test.leaf_count as usize;
            }
        }
        let drawn = self.draws.len() + self.retests.len() + dropped_leaves;
        self.prospect_ns = [saving_ns, economy.governor.break_ns(drawn)];
        if saving_ns < self.prospect_ns[1] {
            self.is_dropped.fill(true);
            saving_ns = 0.0;
        }
        stats.expected_saving_ns = saving_ns as u64;
        self.draw_untested(walk, stats);
        if is_never(walk.policy.retest_max) {
            let excess = self.retests.drain(..);
            self.draws
                .extend(excess.map(|retest| Draw { nearness: retest.nearness, leaf: retest.leaf }));
        }
        self.discard();
        self.sort_draws();
    }

    /// Draws the leaves of the tests that are marked.
    fn draw_untested(&mut self, walk: &Walk<'_>, stats: &mut PlanStats) {
        for (test, is_dropped) in self.tests.iter().zip(&self.is_dropped) {
            if !is_dropped || test.kind != QueryKind::Proxy {
                continue;
            }
            // What counts as hidden and is drawn all the same is asked about now and then: it may be
            // visible by now, and a reason to test it with its neighbours no more.
            let is_asked =
                test.leaf_count == 1 && !test.is_unknown() && walk.is_turn_to_retest(test.node);
            walk.leaves_in_frustum(test.node, &mut self.stack, |leaf| {
                stats.untested_by_cost += 1;
                if is_asked {
                    self.retests.push(leaf);
                    return;
                }
                self.draws.push(Draw { nearness: leaf.nearness, leaf: leaf.leaf });
                if test.is_unknown() {
                    self.assumed.push([leaf.node, test.node]);
                }
            });
        }
    }
}
