//! One query per object, whose result is read in a later frame and decides about this object only
//! (GPU Gems, 29.4).
//!
//! An object that was visible at its last test is drawn, now and then under a query of its draw. An
//! object that was hidden is tested by its box in every frame; it is not drawn in the same frame
//! even if the box shows. So an object that comes into view is missing until its result is read
//! back: the image is not exact. An object that comes into the frustum counts as visible.

use crate::geom::view::CullView;
use crate::hierarchy::Hierarchy;
use crate::hierarchy::front_to_back::{InSight, ViewedHierarchy};
use crate::ids::{FrameId, Generation, NodeId};
use crate::plan::frame_plan::{FramePlan, ProxyTest, QueryKind, QueryTag, VisibilityTest};

/// The interval of the tests of a visible object: it is expected to be visible still, and an error
/// is cheap. Objects take turns.
const VISIBLE_INTERVAL_FRAMES: u64 = 4;

/// The number of frames outside of the frustum after which an object counts as visible on its
/// return.
const STALE_FRAMES: u64 = 2;

/// The record of an object. Frame 0 stands for never.
#[derive(Clone, Copy, Debug)]
struct NodeRecord {
    is_visible: bool,
    /// The newest frame whose answer was taken.
    answered: FrameId,
    /// The last frame in which it was in the frustum.
    in_sight: FrameId,
    /// The generation in which the record was made. It is replaced if another object has the id
    /// since.
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
    /// Takes an answer about a node of `hierarchy`. Ignores answers about inner nodes, and all
    /// answers before the first plan.
    pub(crate) fn take(&mut self, hierarchy: &Hierarchy, tag: &QueryTag, samples: u32) {
        if self.records.is_empty() || hierarchy.leaves(tag.node).count != 1 {
            return;
        }
        let Some(record) = self.record(hierarchy, tag.node) else { return };
        if record.answered < tag.frame {
            record.answered = tag.frame;
            record.is_visible = samples > 0;
        }
    }

    /// Clears all results: each leaf counts as visible again.
    pub(crate) fn reset(&mut self) {
        self.records.clear();
    }

    /// Plans a frame into `plan`, which must be empty.
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
            // Tests from before it left the frustum say nothing about it now.
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

    /// Returns the record of the object at a leaf, in any generation of the hierarchy. An object
    /// that was inserted later gets a new record, also if it reuses an id.
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
