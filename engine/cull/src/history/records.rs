//! The records of all nodes, which follow the changes of the hierarchy.

use std::sync::Arc;

use crate::geom::frustum::Containment;
use crate::hierarchy::{Change, FREE_LEAF, Hierarchy, NEW_LEAF, Restructured, Topology};
use crate::history::record::{FrameStamp, NodeRecord, NodeState, RetestReason};
use crate::ids::Generation;
use crate::plan::config::CullConfig;
use crate::rng::SplitMix64;

/// The time after which a pull-up query may be repeated if its result does not arrive. Halving or
/// doubling it changes no count of a walk by more than 1 % (docs/lab/cull_config.md).
const PULL_UP_RETRY_FRAMES: u32 = 6;

/// A record per node of one generation of the hierarchy.
#[derive(Debug)]
pub(crate) struct History {
    records: Vec<NodeRecord>,
    generation: Generation,
    /// The identity of the hierarchy that the records belong to.
    identity: Option<Arc<()>>,
    /// The records of the leaves of a subtree that is carried over.
    leaves: Vec<NodeRecord>,
    /// The records of the nodes of this subtree; `None` above free leaves only.
    carried: Vec<Option<NodeRecord>>,
}

impl Default for History {
    fn default() -> Self {
        Self {
            records: Vec::new(),
            generation: Generation(0),
            identity: None,
            leaves: Vec::new(),
            carried: Vec::new(),
        }
    }
}

impl History {
    /// Returns the record of a node; an empty one for a foreign id.
    pub(crate) fn record(&self, node: u32) -> NodeRecord {
        self.records.get(node as usize).copied().unwrap_or_default()
    }

    pub(crate) fn record_mut(&mut self, node: u32) -> Option<&mut NodeRecord> {
        self.records.get_mut(node as usize)
    }

    pub(crate) fn reset(&mut self) {
        self.records.fill(NodeRecord::default());
    }

    pub(crate) fn visit(&mut self, node: u32, now: FrameStamp) {
        if let Some(record) = self.record_mut(node) {
            record.visited = now;
        }
    }

    /// Notes that a leaf is drawn under a query. The next such query is due after an interval, even
    /// if no answer arrives.
    pub(crate) fn note_visible_draw_query(
        &mut self,
        node: u32,
        now: FrameStamp,
        config: &CullConfig,
        rng: &mut SplitMix64,
    ) {
        if let Some(record) = self.record_mut(node) {
            record.due = now.plus(retest_interval(record, config, rng));
        }
    }

    /// Notes that a leaf below `top` is drawn without a test although it is unknown. The leaf
    /// counts as visible until its own draw is tested, and the nodes above it up to `top` count as
    /// open.
    pub(crate) fn assume_visible(
        &mut self,
        topology: &Topology,
        leaf: u32,
        top: u32,
        now: FrameStamp,
        due: FrameStamp,
        config: &CullConfig,
    ) {
        // This number of successes gives a long interval, and makes the next test a test of its own
        // draw.
        let stable_queries =
            config.tuning.visible_box_tests.saturating_add(1).min(u8::MAX.into()) as u8;
        if let Some(record) = self.record_mut(leaf) {
            if record.state != NodeState::Hidden {
                record.state = NodeState::Visible;
                record.retest_reason = RetestReason::Assumed;
                record.since = now;
                record.stable_queries = stable_queries;
                record.due = due;
            }
            record.visited = now;
        }
        let mut node = leaf;
        while node != top {
            let Some(links) = topology.nodes.get(node as usize) else { return };
            node = links.parent;
            let Some(record) = self.record_mut(node) else { return };
            if record.state == NodeState::Visible && record.visited == now {
                return;
            }
            record.state = NodeState::Visible;
            record.since = now;
            record.visited = now;
            record.stable_queries = 0;
            record.due = due;
        }
    }

    /// Notes the meaning of the next answer about a leaf for the cost model.
    pub(crate) fn mark_for_retest(&mut self, node: u32, containment: Containment) {
        if let Some(record) = self.record_mut(node) {
            record.retest_reason = match (containment, record.retest_reason) {
                (Containment::Inside, RetestReason::Assumed) => RetestReason::Assumed,
                (Containment::Inside, _) => RetestReason::None,
                _ => RetestReason::Edge,
            };
        }
    }

    /// Notes that an answer arrived for a leaf that was drawn without a test.
    pub(crate) fn answered_assumed(&mut self, node: u32) {
        if let Some(record) = self.record_mut(node) {
            record.retest_reason = RetestReason::None;
        }
    }

    /// Notes that a node has a pull-up query, so that it gets no other before the answer can
    /// arrive.
    pub(crate) fn note_pull_up_query(&mut self, node: u32, now: FrameStamp) {
        if let Some(record) = self.record_mut(node) {
            record.due = now.plus(PULL_UP_RETRY_FRAMES);
        }
    }

    /// Closes an open node, which is tested as one from now on. Until the answer arrives, it counts
    /// as hidden since the frame in which the last of its children became hidden.
    pub(crate) fn closed(&mut self, topology: &Topology, node: u32) {
        let Some(links) = topology.nodes.get(node as usize) else {
            return;
        };
        if links.is_leaf() || self.record(node).state != NodeState::Visible {
            return;
        }
        let parts = links.children(node).map(|child| self.record(child).since);
        let since = parts.into_iter().max().unwrap_or(FrameStamp::NEVER);
        if let Some(record) = self.record_mut(node) {
            record.state = NodeState::Hidden;
            record.since = since;
        }
    }

    /// Gives a node the state of a hidden node above it, with which it was tested until now.
    pub(crate) fn inherit(&mut self, node: u32, since: FrameStamp) {
        if let Some(record) = self.record_mut(node) {
            record.state = NodeState::Hidden;
            record.since = since;
            record.stable_queries = 0;
        }
    }

    /// Reserves the memory for the records of `nodes` nodes, because a failed allocation during a
    /// frame would abort the program. On failure returns the requested number of bytes.
    pub(crate) fn reserve(&mut self, nodes: usize) -> Result<(), usize> {
        let more = nodes.saturating_sub(self.records.len());
        let reserved = self.records.try_reserve_exact(more);
        reserved.map_err(|_| nodes.saturating_mul(size_of::<NodeRecord>()))
    }

    /// Updates the records to the present generation of the hierarchy. Objects keep their records.
    /// A new inner node is hidden if everything below it is hidden, and visible if something below
    /// it is visible. For another hierarchy, or if too many changes were missed, all records are
    /// cleared.
    pub(crate) fn adopt(&mut self, hierarchy: &Hierarchy) {
        let journal = hierarchy.journal();
        let generation = hierarchy.generation();
        let is_same = self.identity.as_ref().is_some_and(|i| Arc::ptr_eq(i, journal.identity()));
        if is_same && self.generation == generation {
            return;
        }
        let is_ahead = self.generation > generation;
        match journal.since(self.generation).filter(|_| is_same && !is_ahead) {
            Some(changes) => changes.for_each(|change| self.follow(change)),
            None => self.records.clear(),
        }
        if self.records.len() != hierarchy.node_count() {
            self.records.clear();
            self.records.resize(hierarchy.node_count(), NodeRecord::default());
        }
        self.generation = generation;
        if !is_same {
            self.identity = Some(Arc::clone(journal.identity()));
        }
    }

    fn follow(&mut self, change: &Change) {
        match change {
            Change::Recycled(node) => {
                if let Some(record) = self.record_mut(*node) {
                    *record = NodeRecord::default();
                }
            }
            Change::Restructured(change) => self.carry_over(change),
        }
    }

    /// Distributes the records of a subtree to the nodes that replace it.
    fn carry_over(&mut self, change: &Restructured) {
        self.collect_leaves(change);
        let Self { records, leaves, carried, .. } = self;
        carried.clear();
        carried.resize(change.after.len(), None);
        // Children follow their parents.
        let mut moved_from = change.moved_from.iter().rev();
        for (node, leaf_count) in change.after.iter().enumerate().rev() {
            carried[node] = if *leaf_count == 1 {
                match moved_from.next() {
                    Some(&FREE_LEAF) => None,
                    Some(&NEW_LEAF) | None => Some(NodeRecord::default()),
                    Some(&leaf) => Some(leaves.get(leaf as usize).copied().unwrap_or_default()),
                }
            } else {
                let left = carried.get(node + 1).copied().flatten();
                let beside = change.after.get(node + 1).map_or(0, |leaves| 2 * *leaves as usize);
                let right = carried.get(node + beside).copied().flatten();
                match (left, right) {
                    (Some(left), Some(right)) => Some(above(&left, &right)),
                    (one, other) => one.or(other),
                }
            };
        }
        let carried = carried.iter().map(|record| record.unwrap_or_default());
        let first = change.root as usize;
        if change.before.len() == change.after.len() {
            let places = records.iter_mut().skip(first);
            places.zip(carried).for_each(|(place, record)| *place = record);
        } else {
            records.truncate(first);
            records.extend(carried);
        }
    }

    /// Collects the record of each leaf of a subtree before the change. This is the record of the
    /// topmost hidden node above the leaf, since nothing below such a node is kept up to date, or
    /// else its own.
    fn collect_leaves(&mut self, change: &Restructured) {
        self.leaves.clear();
        let mut node = 0;
        while let Some(leaf_count) = change.before.get(node) {
            let record = self.record(change.root + node as u32);
            if *leaf_count > 1 && record.state != NodeState::Hidden {
                node += 1;
                continue;
            }
            let leaves = *leaf_count as usize;
            self.leaves.resize(self.leaves.len() + leaves, record);
            node += 2 * leaves - 1;
        }
    }
}

/// Returns the record of a new node above two others.
fn above(left: &NodeRecord, right: &NodeRecord) -> NodeRecord {
    let state = match (left.state, right.state) {
        (NodeState::Hidden, NodeState::Hidden) => NodeState::Hidden,
        (NodeState::Visible, _) | (_, NodeState::Visible) => NodeState::Visible,
        _ => NodeState::Unknown,
    };
    NodeRecord {
        state,
        stable_queries: 0,
        flicker_count: 0,
        retest_reason: RetestReason::None,
        since: left.since.max(right.since),
        visited: match state {
            NodeState::Visible => left.visited.max(right.visited),
            NodeState::Hidden | NodeState::Unknown => left.visited.min(right.visited),
        },
        answered: left.answered.max(right.answered),
        due: left.due.max(right.due),
    }
}

/// Returns the number of frames until a visible leaf's own draw is tested again. The interval grows
/// with the time for which the leaf has been visible, and more if its proxy showed in vain. The
/// result is a random number between half the interval and the interval.
pub(crate) fn retest_interval(
    record: &NodeRecord,
    config: &CullConfig,
    rng: &mut SplitMix64,
) -> u32 {
    let doubled = |exponent: u8| {
        config
            .tuning
            .retest_first
            .saturating_mul(1_u32.checked_shl(exponent.into()).unwrap_or(u32::MAX))
    };
    let calm = doubled(record.stable_queries).min(config.retest_max);
    let flipping = doubled(record.flicker_count).min(config.tuning.flicker_retest_max);
    let interval = calm.max(flipping).max(1);
    rng.between(interval.div_ceil(2), interval)
}
