//! The records of all nodes, and how they survive a rebuild of the hierarchy.

use std::sync::Arc;

use super::record::{Doubt, NodeState, Record, Stamp};
use crate::frustum::Containment;
use crate::hierarchy::{Hierarchy, Topology};
use crate::policy::Policy;
use crate::rng::SplitMix64;

/// One record a node, of the generation whose topology is kept here.
#[derive(Debug, Default)]
pub(super) struct History {
    records: Vec<Record>,
    topology: Arc<Topology>,
}

impl History {
    /// What is remembered of a node; nothing of a foreign one.
    pub(super) fn record(&self, node: u32) -> Record {
        self.records.get(node as usize).copied().unwrap_or_default()
    }

    pub(super) fn record_mut(&mut self, node: u32) -> Option<&mut Record> {
        self.records.get_mut(node as usize)
    }

    pub(super) fn forget(&mut self) {
        self.records.fill(Record::default());
    }

    pub(super) fn visit(&mut self, node: u32, now: Stamp) {
        if let Some(record) = self.record_mut(node) {
            record.visited = now;
        }
    }

    /// A leaf is drawn under a query: the next is due after its interval, even if no answer comes.
    pub(super) fn asked_own_draw(
        &mut self,
        node: u32,
        now: Stamp,
        policy: &Policy,
        rng: &mut SplitMix64,
    ) {
        if let Some(record) = self.record_mut(node) {
            record.due = now.plus(retest_interval(record, policy, rng));
        }
    }

    /// A leaf below `top` is drawn without a test although nothing is known of it: it counts as
    /// visible until its own draw is tested, and what is above it up to `top` as open.
    pub(super) fn assume_visible(
        &mut self,
        leaf: u32,
        top: u32,
        now: Stamp,
        due: Stamp,
        policy: &Policy,
    ) {
        // Long streaks make for long intervals, and this one makes the next test one of its own draw.
        let streak = (policy.own_box_streak + 1).min(u8::MAX.into()) as u8;
        if let Some(record) = self.record_mut(leaf) {
            if record.state != NodeState::Hidden {
                record.state = NodeState::Visible;
                record.doubt = Doubt::Assumed;
                record.since = now;
                record.streak = streak;
                record.due = due;
            }
            record.visited = now;
        }
        let mut node = leaf;
        while node != top {
            let Some(links) = self.topology.nodes.get(node as usize) else { return };
            node = links.parent;
            let Some(record) = self.record_mut(node) else { return };
            if record.state == NodeState::Visible && record.visited == now {
                return;
            }
            record.state = NodeState::Visible;
            record.since = now;
            record.visited = now;
            record.streak = 0;
            record.due = due;
        }
    }

    /// Notes what the answer to the test of a leaf by itself will say.
    pub(super) fn doubt(&mut self, node: u32, containment: Containment) {
        if let Some(record) = self.record_mut(node) {
            record.doubt = match (containment, record.doubt) {
                (Containment::Inside, Doubt::Assumed) => Doubt::Assumed,
                (Containment::Inside, _) => Doubt::None,
                _ => Doubt::Edge,
            };
        }
    }

    /// An answer came for a leaf that had been drawn without a test.
    pub(super) fn answered_assumed(&mut self, node: u32) {
        if let Some(record) = self.record_mut(node) {
            record.doubt = Doubt::None;
        }
    }

    /// A node is probed: not again before the answer had time to come.
    pub(super) fn asked_probe(&mut self, node: u32, now: Stamp, policy: &Policy) {
        if let Some(record) = self.record_mut(node) {
            record.due = now.plus(policy.probe_retry);
        }
    }

    /// An open node is tested as one from now on: it counts as hidden for as long as its parts, until
    /// the answer comes.
    pub(super) fn closed(&mut self, node: u32) {
        let Some(links) = self.topology.nodes.get(node as usize) else {
            return;
        };
        if links.is_leaf() || self.record(node).state != NodeState::Visible {
            return;
        }
        let parts = links.children(node).map(|child| self.record(child).since);
        let since = parts.into_iter().max().unwrap_or(Stamp::NEVER);
        if let Some(record) = self.record_mut(node) {
            record.state = NodeState::Hidden;
            record.since = since;
            record.streak = 0;
        }
    }

    /// Follows the hierarchy to its present generation. Objects keep what was known of them; a new
    /// inner node is hidden if all below it is, and visible if something is.
    pub(super) fn adopt(&mut self, hierarchy: &Hierarchy) {
        if Arc::ptr_eq(&self.topology, &hierarchy.topology) {
            return;
        }
        let new = &hierarchy.topology;
        let mut records = vec![Record::default(); new.nodes.len()];
        self.copy_leaves(new, &mut records);
        // Children follow their parents.
        for (node, links) in new.nodes.iter().enumerate().rev() {
            if !links.is_leaf() {
                let [left, right] = links.children(node as u32);
                records[node] = above(&records[left as usize], &records[right as usize]);
            }
        }
        self.records = records;
        self.topology = Arc::clone(new);
    }

    /// Gives every object's new leaf its record: that of the topmost hidden node that it was
    /// under, since nothing below such a node is kept up to date, or else its own.
    fn copy_leaves(&self, new: &Topology, records: &mut [Record]) {
        let old = &self.topology;
        let mut node = 0;
        while let Some(links) = old.nodes.get(node as usize) {
            let record = self.record(node);
            let is_hidden = record.state == NodeState::Hidden;
            if !links.is_leaf() && !is_hidden {
                node += 1;
                continue;
            }
            let first = links.first_leaf as usize;
            for object in &old.leaf_objects[first..first + links.leaf_count as usize] {
                if let Some(leaf) = new.object_nodes.get(object.0 as usize) {
                    records[*leaf as usize] = record;
                }
            }
            node = links.end(node);
        }
    }
}

/// The record of a node that is new above two others.
fn above(left: &Record, right: &Record) -> Record {
    let state = match (left.state, right.state) {
        (NodeState::Hidden, NodeState::Hidden) => NodeState::Hidden,
        (NodeState::Visible, _) | (_, NodeState::Visible) => NodeState::Visible,
        _ => NodeState::Unknown,
    };
    Record {
        state,
        streak: 0,
        flips: 0,
        doubt: Doubt::None,
        since: left.since.max(right.since),
        visited: match state {
            NodeState::Visible => left.visited.max(right.visited),
            NodeState::Hidden | NodeState::Unknown => left.visited.min(right.visited),
        },
        answered: left.answered.max(right.answered),
        due: left.due.max(right.due),
    }
}

/// Frames until a visible leaf's own draw is tested again: longer the longer it has been visible,
/// and much longer where its proxy promised too much; the upper half of the range at random.
pub(super) fn retest_interval(record: &Record, policy: &Policy, rng: &mut SplitMix64) -> u32 {
    let doubled = |exponent: u8| {
        policy.retest_first.saturating_mul(1_u32.checked_shl(exponent.into()).unwrap_or(u32::MAX))
    };
    let calm = doubled(record.streak).min(policy.retest_max);
    let flipping = doubled(record.flips).min(policy.flip_retest_max);
    let interval = calm.max(flipping).max(1);
    rng.between(interval.div_ceil(2), interval)
}
