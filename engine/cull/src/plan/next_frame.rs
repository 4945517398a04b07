//! A query per object, read in a later frame to decide about that one (GPU Gems, 29.4).
//!
//! An object that was visible at its last test is drawn, under a query of its own draw; one that
//! was hidden is tested by its box, every frame, and not drawn, with any result. So an object that
//! comes into view is missing until its result is read back: the image is not exact. An object that
//! comes into the frustum counts as visible.

use crate::geom::view::CullView;
use crate::hierarchy::Hierarchy;
use crate::hierarchy::front_to_back::{InSight, ViewedHierarchy};
use crate::ids::{FrameId, Generation, NodeId};
use crate::plan::frame_plan::{FramePlan, ProxyTest, QueryKind, QueryTag, VisibilityTest};

/// The interval of the tests of a visible object: it is expected to be still visible, and an error
/// costs little. Objects take turns.
const VISIBLE_INTERVAL_FRAMES: u64 = 4;

/// The frames out of the frustum after which an object counts as visible when it comes back.
const STALE_FRAMES: u64 = 2;

/// The record of an object; frame 0 stands for never.
#[derive(Clone, Copy, Debug)]
struct NodeRecord {
    is_visible: bool,
    /// The youngest frame that is known to have answered.
    answered: FrameId,
    /// The last frame that had it in the frustum.
    in_sight: FrameId,
    /// The generation in which it was about the object of this id; an object that was inserted
    /// later has a new record.
    since: Generation,
}

impl NodeRecord {
    const NEW: Self =
        Self { is_visible: true, answered: FrameId(0), in_sight: FrameId(0), since: Generation(0) };
}

/// The history of one view, by object.
#[derive(Debug, Default)]
pub(crate) struct NextFrame {
    records: Vec<NodeRecord>,
    leaves: Vec<InSight>,
}

impl NextFrame {
    /// Takes an answer about a node of `hierarchy`; only those about leaves count.
    pub(crate) fn take(&mut self, hierarchy: &Hierarchy, tag: &QueryTag, samples: u32) {
        if hierarchy.leaves(tag.node).count != 1 {
            return;
        }
        let Some(record) = self.record(hierarchy, tag.node) else { return };
        if record.answered < tag.frame {
            record.answered = tag.frame;
            record.is_visible = samples > 0;
        }
    }

    /// Forgets all results: each leaf counts as visible again.
    pub(crate) fn reset(&mut self) {
        self.records.clear();
    }

    /// Plans a frame into `plan`, which is empty.
    pub(crate) fn plan(&mut self, hierarchy: &Hierarchy, view: &CullView, plan: &mut FramePlan) {
        let viewed = ViewedHierarchy { hierarchy, view };
        let mut leaves = std::mem::take(&mut self.leaves);
        plan.stats.nodes_visited = viewed.leaves(&mut leaves);
        for leaf in &leaves {
            self.plan_leaf(&viewed, leaf.node, plan);
        }
        self.leaves = leaves;
        plan.rounds.extend((!plan.tests.is_empty()).then_some(0..plan.tests.len()));
    }

    fn plan_leaf(&mut self, viewed: &ViewedHierarchy<'_>, node: NodeId, plan: &mut FramePlan) {
        let frame = plan.frame;
        let generation = viewed.hierarchy.generation();
        let tag = |kind| QueryTag { node, generation, frame, kind, sample_threshold: 0 };
        let leaf = viewed.leaf(node);
        let Some(record) = self.record(viewed.hierarchy, node) else {
            return plan.draws.push(leaf);
        };
        let is_new = record.in_sight.0 + STALE_FRAMES < frame.0;
        record.in_sight = frame;
        if is_new {
            record.is_visible = true;
            // Tests from before it went away say nothing about it now.
            record.answered = FrameId(frame.0 - 1);
        }
        let Some(bounds) = viewed.proxy(node) else {
            plan.stats.too_near += 1;
            record.is_visible = true;
            return plan.draws.push(leaf);
        };
        if !record.is_visible {
            plan.stats.pull_up_queries += 1;
            let mut leaves = viewed.hierarchy.leaves(node);
            leaves.count = 0;
            return plan.tests.push(ProxyTest {
                tag: tag(QueryKind::PullUpQuery),
                bounds,
                leaves,
                level: viewed.hierarchy.level(node),
                tester: VisibilityTest::Query,
            });
        }
        plan.stats.visible += 1;
        let is_turn = (frame.0 + u64::from(leaf.0)).is_multiple_of(VISIBLE_INTERVAL_FRAMES);
        if is_new || is_turn || frame.0 - record.answered.0 > 2 * VISIBLE_INTERVAL_FRAMES {
            plan.queried_after.push(plan.draws.len() as u32);
            plan.queried_draws.push((leaf, tag(QueryKind::VisibleDrawQuery)));
        } else {
            plan.draws.push(leaf);
        }
    }

    /// Returns the record of a leaf's object in any generation of the hierarchy: a new one for an
    /// object that was inserted since, under any id.
    fn record(&mut self, hierarchy: &Hierarchy, leaf: NodeId) -> Option<&mut NodeRecord> {
        let objects = hierarchy.leaf_objects();
        if self.records.len() < objects.len() {
            self.records.resize(objects.len(), NodeRecord::NEW);
        }
        let object = objects.get(hierarchy.leaves(leaf).first.0 as usize)?;
        let record = self.records.get_mut(object.0 as usize)?;
        if !hierarchy.is_same_object_since(*object, record.since) {
            *record = NodeRecord { since: hierarchy.generation(), ..NodeRecord::NEW };
        }
        Some(record)
    }
}
