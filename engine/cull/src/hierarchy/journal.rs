//! The changes of nodes, for cullers that keep a history of them. Each culler continues where it
//! stopped, so several views can share one hierarchy.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::ids::Generation;

/// Marks a leaf of a [`Restructured`] subtree that had no position before: its object has no
/// history.
pub(crate) const NEW_LEAF: u32 = u32::MAX;

/// Marks a leaf without an object.
pub(crate) const FREE_LEAF: u32 = u32::MAX - 1;

/// One change in the meaning of nodes.
#[derive(Clone, Debug)]
pub(crate) enum Change {
    /// The leaf with this node index holds another object from now on.
    Recycled(u32),
    /// The nodes of a subtree were rebuilt.
    Restructured(Box<Restructured>),
}

/// A subtree before and after a rebuild. A subtree whose number of leaves changes is the last one.
/// The leaf counts of the nodes alone describe a tree in depth-first pre-order: the left child of
/// node `i` is `i + 1`, and the right child is `i` plus twice the leaf count of the left child.
#[derive(Clone, Debug)]
pub(crate) struct Restructured {
    /// The topmost node; the other nodes of the subtree follow it.
    pub(crate) root: u32,
    pub(crate) before: Vec<u32>,
    pub(crate) after: Vec<u32>,
    /// For each leaf of the subtree, the index of its object's leaf before, counted from the
    /// subtree's first leaf; [`NEW_LEAF`] or [`FREE_LEAF`] if there was none.
    pub(crate) moved_from: Vec<u32>,
}

/// The latest changes, each with the generation that it began. The journal is bounded: a culler
/// that reads too seldom has to start without history.
#[derive(Clone, Debug, Default)]
pub(crate) struct Journal {
    /// The identity of the hierarchy.
    identity: Arc<()>,
    changes: VecDeque<(Generation, Change)>,
    /// The number of entries in `changes`.
    entries: usize,
    /// The newest generation whose change was dropped.
    dropped: Option<Generation>,
}

impl Journal {
    /// Returns the identity of the journal's hierarchy, to compare with [`Arc::ptr_eq`].
    pub(crate) fn identity(&self) -> &Arc<()> {
        &self.identity
    }

    /// Notes a change, and drops the oldest until at most `most_entries` entries or one change are
    /// left.
    pub(super) fn push(&mut self, generation: Generation, change: Change, most_entries: usize) {
        self.entries += entries(&change);
        self.changes.push_back((generation, change));
        while self.entries > most_entries && self.changes.len() > 1 {
            let Some((oldest, change)) = self.changes.pop_front() else {
                return;
            };
            self.entries -= entries(&change);
            self.dropped = Some(oldest);
        }
    }

    /// Clears all changes: every reader has to start without history.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Returns the changes after `generation`, the oldest first; `None` if some of them were
    /// dropped.
    pub(crate) fn since(&self, generation: Generation) -> Option<impl Iterator<Item = &Change>> {
        if self.dropped.is_some_and(|dropped| dropped > generation) {
            return None;
        }
        let first = self.changes.partition_point(|(began, _)| *began <= generation);
        Some(self.changes.range(first..).map(|(_, change)| change))
    }
}

fn entries(change: &Change) -> usize {
    const CHANGE_ENTRIES: usize = 6;
    match change {
        Change::Recycled(_) => CHANGE_ENTRIES,
        Change::Restructured(change) => {
            CHANGE_ENTRIES + change.before.len() + change.after.len() + change.moved_from.len()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nodes(journal: &Journal, generation: u32) -> Option<Vec<u32>> {
        let changes = journal.since(Generation(generation))?;
        Some(
            changes
                .map(|change| match change {
                    Change::Recycled(node) => *node,
                    Change::Restructured(change) => change.root,
                })
                .collect(),
        )
    }

    #[test]
    fn readers_go_on_where_they_stopped_or_are_told_that_they_cannot() {
        let mut journal = Journal::default();
        for generation in 1..=6 {
            journal.push(Generation(generation), Change::Recycled(10 * generation), 24);
        }
        assert_eq!(nodes(&journal, 6), Some(vec![]));
        assert_eq!(nodes(&journal, 4), Some(vec![50, 60]));
        assert_eq!(nodes(&journal, 2), Some(vec![30, 40, 50, 60]));
        assert_eq!(nodes(&journal, 1), None, "generation 2 was dropped");
    }
}
