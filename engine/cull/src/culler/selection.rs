//! From what a walk would like to do to what the queries allow.
//!
//! Tests decide about draws and come first. If there are more of them than wished, larger nodes
//! are allowed and the walk is repeated; if there are still more than queries, the tests with the most leaves
//! stay and the leaves of the others are drawn. What is left of the queries is shared by probes,
//! which save tests later on, and own-draw tests, which can as well be draws.

use std::collections::BinaryHeap;

use super::economy::Economy;
use super::record::Stamp;
use super::traversal::{Nearness, Waiting, Walk};
use crate::bounds::Aabb;
use crate::frustum::PlaneMask;
use crate::ids::LeafIndex;
use crate::plan::{PlanStats, QueryKind};
use crate::policy::Policy;

/// A leaf to draw.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draw {
    pub(super) nearness: Nearness,
    pub(super) leaf: LeafIndex,
}

/// A leaf to draw under a query.
#[derive(Clone, Copy, Debug)]
pub(super) struct Retest {
    pub(super) nearness: Nearness,
    pub(super) leaf: LeafIndex,
    pub(super) node: u32,
    /// How many draws come before it.
    pub(super) after: u32,
}

/// A node to test.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) node: u32,
    /// Proxy, probe or own box.
    pub(super) kind: QueryKind,
    pub(super) proxy: Aabb,
    pub(super) leaf_count: u32,
    /// Since when a node above it was hidden, where nothing newer is known.
    pub(super) inherited: Option<Stamp>,
    /// For how long the node has been hidden; `None` where it is not known to be. 0 where nothing
    /// depends on that: probes and own boxes, whose nodes are visible.
    pub(super) hidden_frames: Option<u32>,
}

impl Candidate {
    pub(super) fn is_unknown(&self) -> bool {
        self.hidden_frames.is_none()
    }
}

/// The lists of one plan in the making, kept so that steady frames do not allocate.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub(super) queue: BinaryHeap<Waiting>,
    pub(super) draws: Vec<Draw>,
    pub(super) retests: Vec<Retest>,
    pub(super) tests: Vec<Candidate>,
    pub(super) visited: Vec<u32>,
    /// Leaves that are drawn without a test although nothing is known, and the node that was not
    /// tested.
    pub(super) assumed: Vec<[u32; 2]>,
    pub(super) stack: Vec<(u32, PlaneMask)>,
    by_size: Vec<u32>,
    pub(super) is_dropped: Vec<bool>,
    /// What all tests that pay by themselves save together, and what their breaks of rendering cost.
    pub(super) prospect_ns: [f32; 2],
}

impl Scratch {
    pub(super) fn clear(&mut self) {
        self.queue.clear();
        self.draws.clear();
        self.retests.clear();
        self.tests.clear();
        self.visited.clear();
        self.assumed.clear();
    }

    /// Fills the lists with a plan that needs at most `budget` queries. Answers whether much is
    /// unknown, as after a cut.
    pub(super) fn choose(
        &mut self,
        walk: &mut Walk<'_>,
        budget: usize,
        economy: Option<&Economy<'_>>,
        stats: &mut PlanStats,
    ) -> bool {
        // Then everything there can be is small enough to be tested as one.
        const MOST_ATTEMPTS: u32 = 16;
        loop {
            walk.run(self, stats);
            let is_last =
                budget == 0 || walk.coarseness >= walk.policy.coarsen_attempts.min(MOST_ATTEMPTS);
            let wished = budget.min(walk.policy.tests_wished as usize);
            if is_last || self.frontier().count() <= wished {
                break;
            }
            walk.coarseness += 1;
        }
        stats.coarsened = walk.coarseness;
        self.is_dropped.clear();
        self.is_dropped.resize(self.tests.len(), false);
        if let Some(economy) = economy {
            self.drop_by_cost(walk, economy, stats);
        }
        let is_cut = self.is_cut(walk.policy);
        if is_cut {
            self.draw_occluders(walk, stats);
        }
        self.drop_tests(walk, budget, stats);
        self.drop_optional(walk.policy, budget, stats);
        self.count(stats);
        is_cut
    }

    /// Finds the place of each retest among the draws.
    pub(super) fn place_retests(&mut self) {
        for retest in &mut self.retests {
            let before = self.draws.partition_point(|draw| draw.nearness <= retest.nearness);
            retest.after = before as u32;
        }
        self.retests.sort_unstable_by_key(|retest| (retest.nearness, retest.leaf));
    }

    /// The tests that decide about draws.
    fn frontier(&self) -> impl Iterator<Item = &Candidate> {
        self.tests.iter().filter(|test| test.kind == QueryKind::Proxy)
    }

    fn is_cut(&self, policy: &Policy) -> bool {
        let unknown = self.frontier().filter(|test| test.is_unknown()).count();
        unknown >= policy.cut_tests as usize
            && unknown.saturating_mul(policy.cut_share as usize) >= self.frontier().count()
    }

    /// Turns the nearest unknown tests into draws, each under its own query so that it is known
    /// afterwards.
    fn draw_occluders(&mut self, walk: &Walk<'_>, stats: &mut PlanStats) {
        let mut left = walk.policy.occluders;
        for (test, is_dropped) in self.tests.iter().zip(&mut self.is_dropped) {
            let is_fit = test.is_unknown() && test.leaf_count <= walk.policy.unknown_leaves;
            if !is_fit {
                continue;
            }
            if test.leaf_count > left {
                break;
            }
            left -= test.leaf_count;
            *is_dropped = true;
            walk.leaves_in_frustum(test.node, &mut self.stack, |leaf| {
                self.retests.push(leaf);
                stats.occluders += 1;
            });
        }
        self.retests.sort_unstable_by_key(|retest| (retest.nearness, retest.leaf));
        self.discard();
    }

    /// Draws the leaves of the smallest tests where there are more tests than queries.
    fn drop_tests(&mut self, walk: &Walk<'_>, budget: usize, stats: &mut PlanStats) {
        let excess = self.frontier().count().saturating_sub(budget);
        if excess == 0 {
            return;
        }
        self.by_size.clear();
        let frontier = (0_u32..).zip(&self.tests).filter(|(_, test)| test.kind == QueryKind::Proxy);
        self.by_size.extend(frontier.map(|(position, _)| position));
        // Among equals the nearest are drawn: they are the likeliest to be seen.
        let tests = &self.tests;
        self.by_size
            .sort_unstable_by_key(|position| (tests[*position as usize].leaf_count, *position));
        for position in &self.by_size[..excess] {
            self.is_dropped[*position as usize] = true;
            let node = self.tests[*position as usize].node;
            walk.leaves_in_frustum(node, &mut self.stack, |leaf| {
                self.draws.push(Draw { nearness: leaf.nearness, leaf: leaf.leaf });
                stats.over_budget += 1;
            });
        }
        self.discard();
        self.sort_draws();
    }

    /// Leaves out probes and own-draw tests that no queries are left for.
    fn drop_optional(&mut self, policy: &Policy, budget: usize, stats: &mut PlanStats) {
        let frontier = self.frontier().count();
        let left = budget.saturating_sub(frontier);
        let wished = self.tests.iter().filter(|test| test.kind == QueryKind::Probe).count();
        let share = frontier / (policy.tests_per_probe.max(1) as usize);
        let probes = wished
            .min(share.max(policy.probes_min as usize))
            .min((left / 2).max(left.saturating_sub(self.retests.len())));
        let mut remaining = probes;
        for (test, is_dropped) in self.tests.iter().zip(&mut self.is_dropped) {
            if test.kind == QueryKind::Probe {
                *is_dropped = remaining == 0;
                remaining = remaining.saturating_sub(1);
            }
        }
        self.discard();
        stats.probes = probes as u32;
        let retests = left - probes;
        if self.retests.len() > retests {
            let excess = self.retests.drain(retests..);
            self.draws
                .extend(excess.map(|retest| Draw { nearness: retest.nearness, leaf: retest.leaf }));
            self.sort_draws();
        }
    }

    /// Removes the tests that are marked, and all marks.
    pub(super) fn discard(&mut self) {
        let mut marks = self.is_dropped.iter();
        self.tests.retain(|_| !marks.next().copied().unwrap_or(false));
        self.is_dropped.clear();
        self.is_dropped.resize(self.tests.len(), false);
    }

    pub(super) fn sort_draws(&mut self) {
        self.draws.sort_unstable_by_key(|draw| (draw.nearness, draw.leaf));
    }

    fn count(&self, stats: &mut PlanStats) {
        let own_boxes = self.tests.iter().filter(|test| test.kind == QueryKind::OwnBox);
        stats.own_boxes = own_boxes.count() as u32;
        for test in self.frontier() {
            stats.frontier += 1;
            stats.tested_leaves = stats.tested_leaves.saturating_add(test.leaf_count);
            stats.unknown += u32::from(test.is_unknown());
        }
    }
}
