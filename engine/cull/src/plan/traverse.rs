//! The walk through the hierarchy, front to back by a priority queue ("Hardware Occlusion Queries
//! Made Useful", 6.5.7), shared by all strategies.

use std::cmp::Reverse;

use crate::geom::bounds::Aabb;
use crate::geom::frustum::{Containment, PlaneMask};
use crate::geom::view::View;
use crate::hierarchy::Hierarchy;
use crate::history::record::{NodeState, Record, Stamp};
use crate::history::records::History;
use crate::ids::{LeafIndex, NodeId};
use crate::plan::candidates::{Above, Candidate, Draw, Nearness, Retest, Scratch};
use crate::plan::frame_plan::{PlanStats, QueryKind};
use crate::plan::policy::Policy;
use crate::plan::strategy::Strategy;

/// Whether a walk looks at the past.
#[derive(Clone, Copy)]
pub(crate) enum Knowledge<'a> {
    /// Everything in the frustum is drawn.
    Ignored,
    Used(&'a History),
}

impl<'a> Knowledge<'a> {
    /// Strategies that decide elsewhere get what they start from.
    pub(crate) fn of(history: &'a History, strategy: Strategy) -> Self {
        if strategy.is_governed() { Self::Used(history) } else { Self::Ignored }
    }
}

/// What one walk goes by.
#[derive(Clone, Copy)]
pub(crate) struct Walk<'a> {
    pub(crate) hierarchy: &'a Hierarchy,
    pub(crate) view: &'a View,
    pub(crate) policy: &'a Policy,
    pub(crate) knowledge: Knowledge<'a>,
    pub(crate) now: Stamp,
    pub(crate) is_turning: bool,
    /// Boxes can be tested by flags.
    pub(crate) can_flag: bool,
    /// Leaves can be tested one by one below a node that shows.
    pub(crate) has_parts: bool,
    /// How often the allowed size of tested nodes was raised fourfold.
    pub(crate) coarseness: u32,
}

/// What becomes of a node.
enum Verdict {
    Draw,
    Retest,
    /// Draw, and test the box.
    TestOwnBox(Aabb),
    Test(Aabb),
    /// Go on to the children; the proxy is there if the node could be probed.
    Open(Option<Aabb>),
}

/// A node at its turn.
struct Turn {
    nearness: Nearness,
    node: u32,
    mask: PlaneMask,
    leaf_count: u32,
    bounds: Aabb,
    record: Record,
    /// If what is known of it is what was known of a node above: since when that was hidden.
    inherited: Option<Stamp>,
}

impl Walk<'_> {
    /// Fills `scratch` with what the past wishes to draw and to test. While those are more tests than
    /// wished, or than `budget`, larger nodes are allowed and the walk is repeated.
    pub(crate) fn traverse(&mut self, scratch: &mut Scratch, budget: usize, stats: &mut PlanStats) {
        // Then everything there can be is small enough to be tested as one.
        const MOST_ATTEMPTS: u32 = 16;
        loop {
            self.run(scratch, stats);
            let is_last =
                budget == 0 || self.coarseness >= self.policy.coarsen_attempts.min(MOST_ATTEMPTS);
            let wished = budget.min(self.policy.tests_wished as usize);
            if is_last || scratch.frontier().count() <= wished {
                break;
            }
            self.coarseness += 1;
        }
        stats.coarsened = self.coarseness;
        scratch.keep_all();
    }

    /// Visits what is in the frustum and sorts it into `scratch`, which is cleared first.
    fn run(&self, scratch: &mut Scratch, stats: &mut PlanStats) {
        scratch.clear();
        stats.visible = 0;
        stats.too_near = 0;
        if let Some(root) = self.hierarchy.root() {
            let above = Above { mask: PlaneMask::ALL, hidden_since: None };
            self.push(root.0, above, scratch);
        }
        while let Some(Reverse((nearness, node, Above { mask, hidden_since }))) =
            scratch.queue.pop()
        {
            stats.nodes_visited += 1;
            let (record, inherited) = self.record_below(node, hidden_since);
            let turn = Turn {
                nearness,
                node,
                mask,
                leaf_count: self.hierarchy.leaves(NodeId(node)).count,
                bounds: self.hierarchy.bounds(NodeId(node)),
                record,
                inherited,
            };
            if matches!(self.knowledge, Knowledge::Used(_)) {
                scratch.visited.push(node);
            }
            self.settle(&turn, scratch, stats);
        }
    }

    fn settle(&self, turn: &Turn, scratch: &mut Scratch, stats: &mut PlanStats) {
        let leaf = self.leaf(turn.node);
        match self.verdict(turn, stats) {
            Verdict::Draw => scratch.draws.push(Draw { nearness: turn.nearness, leaf }),
            Verdict::Retest => scratch.retests.push(Retest {
                nearness: turn.nearness,
                leaf,
                node: turn.node,
                after: 0,
            }),
            Verdict::TestOwnBox(proxy) => {
                scratch.draws.push(Draw { nearness: turn.nearness, leaf });
                scratch.tests.push(Candidate {
                    node: turn.node,
                    kind: QueryKind::OwnBox,
                    proxy,
                    leaf_count: 1,
                    inherited: None,
                    hidden_frames: Some(0),
                });
            }
            Verdict::Test(proxy) => scratch.tests.push(Candidate {
                node: turn.node,
                kind: QueryKind::Proxy,
                proxy,
                leaf_count: turn.leaf_count,
                inherited: turn.inherited,
                hidden_frames: self.hidden_frames(&turn.record),
            }),
            Verdict::Open(proxy) => self.open(turn, proxy, scratch),
        }
    }

    fn verdict(&self, turn: &Turn, stats: &mut PlanStats) -> Verdict {
        let is_leaf = turn.leaf_count == 1;
        if matches!(self.knowledge, Knowledge::Ignored) {
            stats.visible += u32::from(is_leaf);
            return if is_leaf { Verdict::Draw } else { Verdict::Open(None) };
        }
        let Some(proxy) = self.view.margin.proxy(&turn.bounds) else {
            stats.too_near += u32::from(is_leaf);
            return if is_leaf { Verdict::Draw } else { Verdict::Open(None) };
        };
        let record = &turn.record;
        let is_fresh = record.is_fresh(self.now, self.policy.stale_frames);
        match record.state {
            NodeState::Visible if is_fresh && is_leaf => {
                stats.visible += 1;
                match self.is_own_box_enough(turn) {
                    true if self.is_own_box_due(turn) => Verdict::TestOwnBox(proxy),
                    false if self.is_own_draw_due(turn) => Verdict::Retest,
                    _ => Verdict::Draw,
                }
            }
            NodeState::Visible if is_fresh => {
                // Not where that was tried and showed: it would again.
                let is_worth_it =
                    self.coarseness > 0 && (record.streak == 0 || record.due <= self.now);
                let hidden = self.parts_hidden_since(turn).filter(|_| is_worth_it);
                let is_closed =
                    hidden.is_some_and(|since| self.may_share(turn, self.now.since(since)));
                if is_closed { Verdict::Test(proxy) } else { Verdict::Open(Some(proxy)) }
            }
            NodeState::Hidden if is_leaf || self.may_share(turn, record.hidden_frames()) => {
                Verdict::Test(proxy)
            }
            _ if is_leaf || self.is_small(turn) => Verdict::Test(proxy),
            _ => Verdict::Open(Some(proxy)),
        }
    }

    /// Whether the next test of a visible leaf is one of its box rather than of its own draw.
    ///
    /// First the box once more, now that all that is visible can hide it: it showed against less.
    /// Then the draw itself, and from then on the box again for a while if it looks small.
    fn is_own_box_enough(&self, turn: &Turn) -> bool {
        let record = &turn.record;
        if !self.can_flag || record.streak == 0 {
            return self.can_flag;
        }
        let diagonal = 2.0 * turn.bounds.half_extent().length();
        let is_turn_of_draw =
            u32::from(record.streak) % self.policy.own_box_streak.saturating_add(1) == 1;
        // Where the box promised too much before, it would again.
        record.flips == 0
            && !is_turn_of_draw
            && diagonal < self.policy.own_box_angle * turn.nearness.distance()
    }

    fn is_own_draw_due(&self, turn: &Turn) -> bool {
        let Policy { retest_spread, retest_gate, .. } = *self.policy;
        turn.record.is_due(turn.node, self.now, retest_spread, retest_gate)
    }

    /// Whether it is a leaf's turn where all take turns.
    pub(crate) fn is_turn_to_retest(&self, node: u32) -> bool {
        self.now.is_turn_of(node, self.policy.retest_spread, self.policy.retest_gate)
    }

    /// Neighbours take turns. What is on its way may be asked again: that costs little.
    fn is_own_box_due(&self, turn: &Turn) -> bool {
        let interval = self.policy.own_box_frames.saturating_add(turn.node & 1);
        turn.record.streak == 0 || self.now.since(turn.record.answered) >= interval
    }

    /// Puts the children that are in the frustum into the queue, and asks for a probe of the node
    /// if all of them are hidden.
    fn open(&self, turn: &Turn, proxy: Option<Aabb>, scratch: &mut Scratch) {
        let Some(children) = self.hierarchy.children(NodeId(turn.node)) else {
            return;
        };
        let record = &turn.record;
        let is_hidden = record.state == NodeState::Hidden
            && record.is_fresh(self.now, self.policy.stale_frames);
        let above = Above { mask: turn.mask, hidden_since: is_hidden.then_some(record.since) };
        for child in children {
            self.push(child.0, above, scratch);
        }
        let is_due = turn.record.state != NodeState::Hidden && turn.record.due <= self.now;
        let (Some(proxy), true) = (proxy, is_due) else {
            return;
        };
        let hidden = self.parts_hidden_since(turn);
        let is_probe = hidden.is_some_and(|since| self.may_share(turn, self.now.since(since)));
        if is_probe {
            scratch.tests.push(Candidate {
                node: turn.node,
                kind: QueryKind::Probe,
                proxy,
                leaf_count: turn.leaf_count,
                inherited: None,
                hidden_frames: Some(0),
            });
        }
    }

    /// Since when every part of a node that is in the frustum is hidden; `None` if one is not, or
    /// none is there.
    fn parts_hidden_since(&self, turn: &Turn) -> Option<Stamp> {
        let mut since = None;
        for child in self.hierarchy.children(NodeId(turn.node))? {
            let record = self.record(child.0);
            let is_hidden = record.state == NodeState::Hidden
                && record.is_fresh(self.now, self.policy.stale_frames);
            if is_hidden {
                since = since.max(Some(record.since));
            } else if self.is_in_frustum(child, turn.mask) {
                return None;
            }
        }
        since
    }

    fn is_in_frustum(&self, node: NodeId, mask: PlaneMask) -> bool {
        let bounds = self.hierarchy.bounds(node);
        self.view.frustum.classify(&bounds, mask).0 != Containment::Outside
    }

    /// What is known of a node, where one above it was hidden: nothing below that was kept up to date.
    fn record_below(&self, node: u32, hidden_since: Option<Stamp>) -> (Record, Option<Stamp>) {
        let record = self.record(node);
        let is_stale = !record.is_fresh(self.now, self.policy.stale_frames);
        let inherited = hidden_since.filter(|_| is_stale);
        let record = match inherited {
            Some(since) => Record { state: NodeState::Hidden, since, visited: self.now, ..record },
            None => record,
        };
        (record, inherited)
    }

    /// Queues a node unless it is outside of the frustum.
    fn push(&self, node: u32, above: Above, scratch: &mut Scratch) {
        let bounds = self.hierarchy.bounds(NodeId(node));
        let (containment, mask) = self.view.frustum.classify(&bounds, above.mask);
        if containment != Containment::Outside {
            let nearness = Nearness::of(&bounds, self.view.eye);
            scratch.queue.push(Reverse((nearness, node, Above { mask, ..above })));
        }
    }

    /// For how long a node has been hidden; `None` if it is not known to be.
    fn hidden_frames(&self, record: &Record) -> Option<u32> {
        let is_fresh = record.is_fresh(self.now, self.policy.stale_frames);
        (is_fresh && record.state == NodeState::Hidden).then(|| record.hidden_frames())
    }

    /// Whether a node that has been hidden for so long may be tested as one.
    fn may_share(&self, turn: &Turn, hidden_frames: u32) -> bool {
        let growth_frames = match self.has_parts {
            true => self.policy.growth_frames_parts,
            false => self.policy.growth_frames,
        };
        let doublings = hidden_frames / growth_frames.max(1);
        let mut allowed = u64::from(self.policy.unknown_leaves) << doublings.min(32);
        if self.is_turning && !turn.mask.is_inside() {
            allowed = allowed.min(self.policy.edge_leaves.into());
        }
        allowed = allowed.min(self.policy.shared_leaves.into());
        u64::from(turn.leaf_count) <= self.coarse(allowed) || self.is_small(turn)
    }

    /// Whether a node of which nothing is known may be tested as one.
    fn is_small(&self, turn: &Turn) -> bool {
        let leaves = u64::from(turn.leaf_count);
        if leaves <= self.coarse(self.policy.unknown_leaves.into()) {
            return true;
        }
        let diagonal = 2.0 * turn.bounds.half_extent().length();
        let angle = self.policy.unknown_angle * (1 << self.coarseness.min(16)) as f32;
        leaves <= self.coarse(self.policy.unknown_leaves_far.into())
            && diagonal < angle * turn.nearness.distance()
    }

    fn coarse(&self, leaves: u64) -> u64 {
        leaves.saturating_mul(1 << (2 * self.coarseness.min(16)))
    }

    fn record(&self, node: u32) -> Record {
        match self.knowledge {
            Knowledge::Ignored => Record::default(),
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
        stack: &mut Vec<(u32, PlaneMask)>,
        mut each: impl FnMut(Retest),
    ) {
        stack.clear();
        stack.push((node, PlaneMask::ALL));
        while let Some((node, mask)) = stack.pop() {
            let bounds = self.hierarchy.bounds(NodeId(node));
            let (containment, mask) = self.view.frustum.classify(&bounds, mask);
            if containment == Containment::Outside {
                continue;
            }
            match self.hierarchy.children(NodeId(node)) {
                Some(children) => {
                    stack.extend(children.map(|child| (child.0, mask)));
                }
                None => each(Retest {
                    nearness: Nearness::of(&bounds, self.view.eye),
                    leaf: self.leaf(node),
                    node,
                    after: 0,
                }),
            }
        }
    }
}
