//! The traversal of the hierarchy, shared by all strategies.
//!
//! "Hardware Occlusion Queries Made Useful", 6.5.7, visits the nodes front to back by a priority
//! queue, because its answers arrive during the traversal. Here no decision about a node depends on
//! another node in front, so the nodes are visited in any order, and the lists are sorted.

use crate::geom::bounds::Aabb;
use crate::geom::frustum::Containment;
use crate::geom::multi_view::{MultiView, ViewMasks};
use crate::hierarchy::Hierarchy;
use crate::history::record::{FrameStamp, NodeRecord, NodeState};
use crate::history::records::History;
use crate::ids::{LeafIndex, NodeId};
use crate::plan::candidates::{Above, Candidate, Draw, Nearness, Retest, Scratch, Waiting};
use crate::plan::config::{CullConfig, CullTuning};
use crate::plan::frame_plan::{PlanStats, QueryKind};
use crate::plan::strategy::Strategy;

// Halving or doubling these changes no count of a walk by more than 1 % (docs/lab/cull_config.md).

/// The most leaves of a node that is tested as one, for any time hidden: if it shows, each leaf is
/// tested in that frame and recorded when the results are read back.
const MAX_SHARED_LEAVES: u64 = 16_384;
/// The most times that the allowed sizes are raised fourfold because there are too many tests.
/// After that, leaves are drawn without a test.
const MAX_COARSENESS: u32 = 4;

/// The use of history by a traversal.
#[derive(Clone, Copy)]
pub(crate) enum Knowledge<'a> {
    /// Everything in the frustum is drawn.
    Ignored,
    Used(&'a History),
}

impl<'a> Knowledge<'a> {
    /// Returns the knowledge of a strategy: strategies that decide elsewhere ignore the history.
    pub(crate) fn of(history: &'a History, strategy: Strategy) -> Self {
        if strategy.uses_cost_model() { Self::Used(history) } else { Self::Ignored }
    }
}

/// The inputs of one traversal.
#[derive(Clone, Copy)]
pub(crate) struct Walk<'a> {
    pub(crate) hierarchy: &'a Hierarchy,
    pub(crate) views: MultiView<'a>,
    pub(crate) config: &'a CullConfig,
    pub(crate) knowledge: Knowledge<'a>,
    pub(crate) now: FrameStamp,
    pub(crate) is_turning: bool,
    /// True if boxes can be tested by flags.
    pub(crate) can_flag: bool,
    /// True if leaves can be tested individually below a node that shows.
    pub(crate) has_leaf_tests: bool,
    /// The number of times that the allowed size of tested nodes was raised fourfold.
    pub(crate) coarseness: u32,
}

/// The decision about a node.
enum NodeDecision {
    Draw,
    Retest,
    /// Draw, and test the box.
    TestVisibleBox(Aabb),
    Test(Aabb),
    /// Continue with the children.
    Open,
}

/// A visited node.
struct Visit {
    nearness: Nearness,
    node: u32,
    masks: ViewMasks,
    leaf_count: u32,
    bounds: Aabb,
    record: NodeRecord,
    /// The frame since which a node above has been hidden, if the node inherits its state.
    inherited: Option<FrameStamp>,
}

impl Walk<'_> {
    /// Fills `scratch` with draws and tests according to the history. As long as there are more
    /// tests than wished, or than `budget`, allows larger nodes and repeats the traversal.
    pub(crate) fn traverse(&mut self, scratch: &mut Scratch, budget: usize, stats: &mut PlanStats) {
        let wished = budget.min(self.config.tests_wished as usize);
        loop {
            let is_last = budget == 0 || self.coarseness >= MAX_COARSENESS;
            let most = if is_last { usize::MAX } else { wished };
            if self.run(scratch, most, stats) {
                break;
            }
            self.coarseness += 1;
        }
        scratch.sort_draws();
        scratch.sort_retests();
        scratch.sort_tests();
        stats.coarsened = self.coarseness;
        scratch.keep_all();
    }

    /// Visits the nodes in the frustum and lists what becomes of them in `scratch`, which is
    /// cleared first. Returns false as soon as there are more than `most` tests that decide about
    /// draws: the lists are then incomplete.
    fn run(&self, scratch: &mut Scratch, most: usize, stats: &mut PlanStats) -> bool {
        scratch.clear();
        let mut deciding = 0;
        stats.visible = 0;
        stats.too_near = 0;
        if let Some(root) = self.hierarchy.root() {
            let above = Above { masks: ViewMasks::ALL, hidden_since: None };
            self.push(root.0, above, scratch);
        }
        while let Some(Waiting { node, nearness, above }) = scratch.waiting.pop() {
            let Above { masks, hidden_since } = above;
            stats.nodes_visited += 1;
            let (record, inherited) = self.record_below(node, hidden_since);
            let visit = Visit {
                nearness,
                node,
                masks,
                leaf_count: self.hierarchy.leaves(NodeId(node)).count,
                bounds: self.hierarchy.bounds(NodeId(node)),
                record,
                inherited,
            };
            if matches!(self.knowledge, Knowledge::Used(_)) {
                scratch.visited.push(node);
            }
            let decision = self.decide(&visit, stats);
            deciding += usize::from(matches!(decision, NodeDecision::Test(_)));
            if deciding > most {
                return false;
            }
            self.settle(&visit, decision, scratch);
        }
        true
    }

    fn settle(&self, visit: &Visit, decision: NodeDecision, scratch: &mut Scratch) {
        let leaf = self.leaf(visit.node);
        match decision {
            NodeDecision::Draw => scratch.draws.push(Draw { nearness: visit.nearness, leaf }),
            NodeDecision::Retest => scratch.retests.push(Retest {
                nearness: visit.nearness,
                leaf,
                node: visit.node,
                after: 0,
            }),
            NodeDecision::TestVisibleBox(proxy) => {
                scratch.draws.push(Draw { nearness: visit.nearness, leaf });
                scratch.tests.push(Candidate {
                    nearness: visit.nearness,
                    node: visit.node,
                    kind: QueryKind::VisibleBoxQuery,
                    proxy,
                    leaf_count: 1,
                    inherited: None,
                    hidden_frames: Some(0),
                });
            }
            NodeDecision::Test(proxy) => scratch.tests.push(Candidate {
                nearness: visit.nearness,
                node: visit.node,
                kind: QueryKind::Proxy,
                proxy,
                leaf_count: visit.leaf_count,
                inherited: visit.inherited,
                hidden_frames: self.hidden_frames(&visit.record),
            }),
            NodeDecision::Open => self.open(visit, scratch),
        }
    }

    fn decide(&self, visit: &Visit, stats: &mut PlanStats) -> NodeDecision {
        let is_leaf = visit.leaf_count == 1;
        if matches!(self.knowledge, Knowledge::Ignored) {
            stats.visible += u32::from(is_leaf);
            return if is_leaf { NodeDecision::Draw } else { NodeDecision::Open };
        }
        let record = &visit.record;
        let is_visible = record.state == NodeState::Visible
            && record.is_fresh(self.now, self.config.tuning.stale_frames);
        if !is_leaf && !self.is_closed(visit, is_visible) {
            return NodeDecision::Open;
        }
        let Some(proxy) = self.views.proxy(&visit.bounds, visit.masks) else {
            stats.too_near += u32::from(is_leaf);
            return if is_leaf { NodeDecision::Draw } else { NodeDecision::Open };
        };
        if !is_leaf || !is_visible {
            return NodeDecision::Test(proxy);
        }
        stats.visible += 1;
        let is_box_enough = self.is_visible_box_enough(visit);
        if is_box_enough && self.is_visible_box_due(visit) {
            NodeDecision::TestVisibleBox(proxy)
        } else if !is_box_enough && self.is_visible_draw_due(visit) {
            NodeDecision::Retest
        } else {
            NodeDecision::Draw
        }
    }

    /// Returns true if an inner node is to be tested as one.
    fn is_closed(&self, visit: &Visit, is_visible: bool) -> bool {
        let record = &visit.record;
        if is_visible {
            // Where leaves are tested individually below a node that shows, a test of the node in
            // place of its children needs no pull-up query beforehand.
            let needs_no_query = self.has_leaf_tests || self.coarseness > 0;
            // A node whose pull-up query failed would show again.
            let may_hide = record.stable_queries == 0 || record.due <= self.now;
            return needs_no_query && may_hide && self.may_close(visit);
        }
        let is_hidden = record.state == NodeState::Hidden;
        is_hidden && self.may_share(visit, record.hidden_frames()) || self.is_small(visit)
    }

    /// Returns true if the next test of a visible leaf is a test of its box rather than of its own
    /// draw.
    ///
    /// The box is tested once more first, because now all visible objects can hide it, while it
    /// showed against fewer. Then the draw itself is tested, and from then on the box again for a
    /// while if it looks small.
    fn is_visible_box_enough(&self, visit: &Visit) -> bool {
        let record = &visit.record;
        if !self.can_flag || record.stable_queries == 0 {
            return self.can_flag;
        }
        let diagonal = 2.0 * visit.bounds.half_extent().length();
        let is_turn_of_draw = u32::from(record.stable_queries)
            % self.config.tuning.visible_box_tests.saturating_add(1)
            == 1;
        // If the box showed in vain before, it would again.
        record.flicker_count == 0
            && !is_turn_of_draw
            && diagonal < self.config.tuning.visible_box_angle * self.metres_per_radian(visit)
    }

    fn is_visible_draw_due(&self, visit: &Visit) -> bool {
        let CullTuning { retest_spread, retest_gate, .. } = self.config.tuning;
        visit.record.is_due(visit.node, self.now, retest_spread, retest_gate)
    }

    /// Returns true if it is a leaf's turn to be tested again.
    pub(crate) fn is_turn_to_retest(&self, node: u32) -> bool {
        self.now.is_turn_of(node, self.config.tuning.retest_spread, self.config.tuning.retest_gate)
    }

    /// Returns true if a test of a leaf's own box is due. Neighbours take turns. A test may be
    /// repeated before its result arrives, which costs little.
    fn is_visible_box_due(&self, visit: &Visit) -> bool {
        let interval = self.config.visible_box_frames.saturating_add(visit.node & 1);
        visit.record.stable_queries == 0 || self.now.since(visit.record.answered) >= interval
    }

    /// Adds the children in the frustum to the waiting nodes, and requests a pull-up query of the
    /// node if all of them are hidden.
    fn open(&self, visit: &Visit, scratch: &mut Scratch) {
        let Some(children) = self.hierarchy.children(NodeId(visit.node)) else {
            return;
        };
        let record = &visit.record;
        let is_hidden = record.state == NodeState::Hidden
            && record.is_fresh(self.now, self.config.tuning.stale_frames);
        let above = Above { masks: visit.masks, hidden_since: is_hidden.then_some(record.since) };
        for child in children {
            self.push(child.0, above, scratch);
        }
        let is_due = matches!(self.knowledge, Knowledge::Used(_))
            && visit.record.state != NodeState::Hidden
            && visit.record.due <= self.now;
        if is_due
            && self.may_close(visit)
            && let Some(proxy) = self.views.proxy(&visit.bounds, visit.masks)
        {
            scratch.tests.push(Candidate {
                nearness: visit.nearness,
                node: visit.node,
                kind: QueryKind::PullUpQuery,
                proxy,
                leaf_count: visit.leaf_count,
                inherited: None,
                hidden_frames: Some(0),
            });
        }
    }

    /// Returns true if all children of a node have been hidden long enough to test it as one.
    fn may_close(&self, visit: &Visit) -> bool {
        let hidden = self.children_hidden_since(visit);
        hidden.is_some_and(|since| self.may_share(visit, self.now.since(since)))
    }

    /// Returns the frame since which all children of a node within the frustum have been hidden;
    /// `None` if a child is not hidden, or if no child is in the frustum.
    fn children_hidden_since(&self, visit: &Visit) -> Option<FrameStamp> {
        let mut since = None;
        for child in self.hierarchy.children(NodeId(visit.node))? {
            let record = self.record(child.0);
            let is_hidden = record.state == NodeState::Hidden
                && record.is_fresh(self.now, self.config.tuning.stale_frames);
            if is_hidden {
                since = since.max(Some(record.since));
            } else if self.is_in_frustum(child, visit.masks) {
                return None;
            }
        }
        since
    }

    fn is_in_frustum(&self, node: NodeId, masks: ViewMasks) -> bool {
        self.classify(node, masks).0 != Containment::Outside
    }

    /// Tests a node against the frustums by `masks`, which belong to a node above it, and against
    /// section planes. Returns its containment and the masks for its children.
    pub(crate) fn classify(&self, node: NodeId, masks: ViewMasks) -> (Containment, ViewMasks) {
        let bounds = self.hierarchy.bounds(node);
        self.views.classify(&bounds, masks, |view| self.hierarchy.is_cut_away(node, view))
    }

    /// Returns the record of a node. If the record is stale and a node above was hidden, the state
    /// is hidden, since nothing below a hidden node is kept up to date.
    fn record_below(
        &self,
        node: u32,
        hidden_since: Option<FrameStamp>,
    ) -> (NodeRecord, Option<FrameStamp>) {
        let record = self.record(node);
        let is_stale = !record.is_fresh(self.now, self.config.tuning.stale_frames);
        let inherited = hidden_since.filter(|_| is_stale);
        let record = match inherited {
            Some(since) => {
                NodeRecord { state: NodeState::Hidden, since, visited: self.now, ..record }
            }
            None => record,
        };
        (record, inherited)
    }

    /// Adds a node to the waiting nodes unless it is outside of the frustum.
    fn push(&self, node: u32, above: Above, scratch: &mut Scratch) {
        let (containment, masks) = self.classify(NodeId(node), above.masks);
        if containment != Containment::Outside {
            let bounds = self.hierarchy.bounds(NodeId(node));
            let nearness = Nearness::of(&bounds, self.views);
            let above = Above { masks, ..above };
            scratch.waiting.push(Waiting { node, nearness, above });
        }
    }

    /// Returns the number of frames for which a node has been hidden; `None` if it is not known to
    /// be hidden.
    fn hidden_frames(&self, record: &NodeRecord) -> Option<u32> {
        let is_fresh = record.is_fresh(self.now, self.config.tuning.stale_frames);
        (is_fresh && record.state == NodeState::Hidden).then(|| record.hidden_frames())
    }

    /// Returns true if a node that has been hidden for `hidden_frames` may be tested as one.
    fn may_share(&self, visit: &Visit, hidden_frames: u32) -> bool {
        let growth_frames = if self.has_leaf_tests {
            self.config.tuning.growth_frames_per_leaf
        } else {
            self.config.tuning.growth_frames
        };
        let doublings = hidden_frames / growth_frames.max(1);
        let mut allowed = u64::from(self.config.unknown_leaves) << doublings.min(32);
        if self.is_turning && !visit.masks.is_inside() {
            allowed = allowed.min(self.config.tuning.edge_leaves.into());
        }
        allowed = allowed.min(MAX_SHARED_LEAVES);
        u64::from(visit.leaf_count) <= self.coarse(allowed) || self.is_small(visit)
    }

    /// Returns true if an unknown node may be tested as one.
    fn is_small(&self, visit: &Visit) -> bool {
        let leaves = u64::from(visit.leaf_count);
        if leaves <= self.coarse(self.config.unknown_leaves.into()) {
            return true;
        }
        let diagonal = 2.0 * visit.bounds.half_extent().length();
        let angle = self.config.tuning.unknown_angle * (1 << self.coarseness) as f32;
        leaves <= self.coarse(self.config.tuning.unknown_leaves_far.into())
            && diagonal < angle * self.metres_per_radian(visit)
    }

    /// Returns the length (metres) that is seen under an angle of 1 radian at the distance of a
    /// node.
    fn metres_per_radian(&self, visit: &Visit) -> f32 {
        self.views.metres_per_radian(visit.nearness.distance())
    }

    fn coarse(&self, leaves: u64) -> u64 {
        leaves.saturating_mul(1 << (2 * self.coarseness))
    }

    fn record(&self, node: u32) -> NodeRecord {
        match self.knowledge {
            Knowledge::Ignored => NodeRecord::default(),
            Knowledge::Used(history) => history.record(node),
        }
    }

    fn leaf(&self, node: u32) -> LeafIndex {
        self.hierarchy.leaves(NodeId(node)).first
    }

    /// Calls `each` for the leaves under a node that are in the frustum.
    pub(crate) fn leaves_in_frustum(
        &self,
        node: u32,
        stack: &mut Vec<(u32, ViewMasks)>,
        mut each: impl FnMut(Retest),
    ) {
        stack.clear();
        stack.push((node, ViewMasks::ALL));
        while let Some((node, masks)) = stack.pop() {
            let bounds = self.hierarchy.bounds(NodeId(node));
            let (containment, masks) = self.classify(NodeId(node), masks);
            if containment == Containment::Outside {
                continue;
            }
            match self.hierarchy.children(NodeId(node)) {
                Some(children) => {
                    stack.extend(children.map(|child| (child.0, masks)));
                }
                None => each(Retest {
                    nearness: Nearness::of(&bounds, self.views),
                    leaf: self.leaf(node),
                    node,
                    after: 0,
                }),
            }
        }
    }
}
