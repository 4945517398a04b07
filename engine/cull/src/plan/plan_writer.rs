//! Writes the chosen draws and tests into the plan, and the tests into the history.

use crate::geom::frustum::Containment;
use crate::geom::multi_view::{MultiView, ViewMasks};
use crate::geom::view::CullView;
use crate::hierarchy::Hierarchy;
use crate::history::record::FrameStamp;
use crate::history::records::History;
use crate::ids::NodeId;
use crate::plan::candidates::{Candidate, Scratch};
use crate::plan::config::CullConfig;
use crate::plan::cost_filter::CostFilter;
use crate::plan::frame_plan::{FramePlan, ProxyTest, QueryKind, QueryTag, VisibilityTest};
use crate::rng::SplitMix64;

/// The inputs on which the tests of one frame depend.
pub(crate) struct PlanWriter<'a> {
    pub(crate) hierarchy: &'a Hierarchy,
    pub(crate) views: MultiView<'a>,
    pub(crate) config: &'a CullConfig,
    pub(crate) history: &'a mut History,
    pub(crate) rng: &'a mut SplitMix64,
    pub(crate) now: FrameStamp,
    /// True if leaves can be tested individually below a node that shows.
    pub(crate) has_leaf_tests: bool,
    /// The tester of all tests without a cost model.
    pub(crate) tester: VisibilityTest,
    pub(crate) costs: Option<&'a CostFilter<'a>>,
}

impl PlanWriter<'_> {
    /// Fills `plan` with the draws and tests of `scratch`.
    pub(crate) fn write(&mut self, scratch: &mut Scratch, plan: &mut FramePlan) {
        plan.draws.extend(scratch.draws.iter().map(|draw| draw.leaf));
        scratch.place_retests();
        for retest in &scratch.retests {
            plan.queried_after.push(retest.after);
            let tag = self.tag(plan, retest.node, QueryKind::VisibleDrawQuery);
            plan.queried_draws.push((retest.leaf, tag));
            self.history.mark_for_retest(retest.node, self.containment(retest.node));
            self.note_visible_draw_query(retest.node);
        }
        for [leaf, top] in &scratch.assumed {
            let due = self.now.plus(self.rng.between(1, self.config.retest_max));
            let topology = &self.hierarchy.topology;
            self.history.assume_visible(topology, *leaf, *top, self.now, due, self.config);
        }
        for test in &scratch.tests {
            let test = self.test(test, plan);
            plan.tests.push(test);
        }
        for node in &scratch.visited {
            self.history.visit(*node, self.now);
        }
    }

    fn test(&mut self, test: &Candidate, plan: &mut FramePlan) -> ProxyTest {
        let node = NodeId(test.node);
        let estimate = self.costs.map(|_| CostFilter::estimate(self.views, test));
        plan.stats.proxy_pixels += estimate.map_or(0, |estimate| estimate.pixels as u64);
        let mut leaves = self.hierarchy.leaves(node);
        let mut kind = test.kind;
        if kind == QueryKind::PullUpQuery {
            leaves.count = 0;
            self.history.note_pull_up_query(test.node, self.now);
        } else if matches!(kind, QueryKind::VisibleBoxQuery | QueryKind::VisibleDrawQuery) {
            leaves.count = 0;
            self.history.mark_for_retest(test.node, self.containment(test.node));
            if kind == QueryKind::VisibleDrawQuery {
                self.note_visible_draw_query(test.node);
            }
        } else {
            match test.inherited {
                Some(since) => self.history.inherit(test.node, since),
                None => self.history.closed(&self.hierarchy.topology, test.node),
            }
            if self.has_leaf_tests && leaves.count >= self.config.tuning.per_leaf_min {
                kind = QueryKind::PerLeaf;
            }
        }
        ProxyTest {
            tag: self.tag(plan, test.node, kind),
            bounds: test.proxy,
            leaves,
            level: self.hierarchy.level(node),
            tester: match self.costs.zip(estimate) {
                // Boxes of visible leaves are not counted as queries and must not become queries.
                Some((costs, estimate)) if kind != QueryKind::VisibleBoxQuery => {
                    costs.tester(&estimate)
                }
                _ => self.tester,
            },
        }
    }

    fn note_visible_draw_query(&mut self, node: u32) {
        self.history.note_visible_draw_query(node, self.now, self.config, self.rng);
    }

    fn tag(&self, plan: &FramePlan, node: u32, kind: QueryKind) -> QueryTag {
        let generation = self.hierarchy.generation();
        let FramePlan { frame, sample_threshold, .. } = *plan;
        QueryTag { node: NodeId(node), generation, frame, kind, sample_threshold }
    }

    fn containment(&self, node: u32) -> Containment {
        let hierarchy = self.hierarchy;
        let node = NodeId(node);
        let is_cut_away = |view: &CullView| hierarchy.is_cut_away(node, view);
        self.views.classify(&hierarchy.bounds(node), ViewMasks::ALL, is_cut_away).0
    }
}
