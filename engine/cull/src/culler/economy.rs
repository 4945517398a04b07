//! Leaves out the tests of a plan that cost more than they save; what is not tested is drawn.

use std::ops::Range;

use super::selection::{Candidate, Draw, Scratch};
use super::traversal::Walk;
use crate::governor::{CheapestTester, Governor, Question, covered_pixels, is_never};
use crate::plan::{FramePlan, PlanStats, QueryKind, Tester};
use crate::view::View;

/// What tests are weighed by.
pub(super) struct Economy<'a> {
    pub(super) governor: &'a Governor,
    /// Who answers; `None` for whoever is cheaper.
    pub(super) tester: Option<Tester>,
    pub(super) has_flags: bool,
}

impl Economy<'_> {
    /// Who answers for a box.
    pub(super) fn tester(&self, question: &Question) -> Tester {
        self.tester.unwrap_or_else(|| self.governor.cheaper(question, self.has_flags))
    }

    /// How many rounds of `plan` would cost least by compute shader.
    pub(super) fn rounds_for_compute(&self, view: &View, plan: &FramePlan) -> u32 {
        let is_for_compute = |round: &&Range<usize>| {
            let tests = plan.tests[(*round).clone()].iter();
            let pixels = tests.map(|test| covered_pixels(view, &test.bounds)).sum();
            let boxes = round.len() as u32;
            let cheapest = self.governor.round_tester(boxes, pixels, self.has_flags);
            cheapest == CheapestTester::Compute
        };
        plan.rounds.iter().filter(is_for_compute).count() as u32
    }

    pub(super) fn question(view: &View, test: &Candidate) -> Question {
        Question {
            leaves: test.leaf_count,
            pixels: covered_pixels(view, &test.proxy),
            is_unknown: test.is_unknown,
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
                saving_ns += judgement.saving_ns - judgement.cost_ns;
                continue;
            }
            *is_dropped = true;
            if test.kind == QueryKind::Proxy {
                dropped_leaves += test.leaf_count as usize;
            }
        }
        let drawn = self.draws.len() + self.retests.len() + dropped_leaves;
        if saving_ns < economy.governor.break_ns(drawn) {
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
                test.leaf_count == 1 && !test.is_unknown && walk.is_turn_to_retest(test.node);
            walk.leaves_in_frustum(test.node, &mut self.stack, |leaf| {
                stats.untested_by_cost += 1;
                if is_asked {
                    self.retests.push(leaf);
                    return;
                }
                self.draws.push(Draw { nearness: leaf.nearness, leaf: leaf.leaf });
                if test.is_unknown {
                    self.assumed.push([leaf.node, test.node]);
                }
            });
        }
    }
}
