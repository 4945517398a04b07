//! Newtypes for everything that is counted, so that a leaf is never taken for a node.

use std::ops::Range;
use std::sync::Arc;

/// An object of the scene: its position in the slice of boxes that the hierarchy was built from.
/// The id of a removed object is reused for an object that is added later.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectId(pub u32);

/// A node of a hierarchy at one [generation](Generation), numbered in depth-first pre-order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub u32);

/// The position of a leaf in depth-first order: the order in which the renderer keeps instances
/// and indirect commands, so that a subtree is one contiguous slice of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LeafIndex(pub u32);

/// A range of contiguous leaves: those under one node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LeafRange {
    /// The first leaf.
    pub first: LeafIndex,
    /// The number of leaves; may be 0 (see
    /// [`QueryKind::PullUpQuery`](crate::QueryKind::PullUpQuery)).
    pub count: u32,
}

impl LeafRange {
    /// Returns the leaves as plain indices, to slice arrays with.
    #[must_use]
    pub fn indices(self) -> Range<usize> {
        let first = self.first.0 as usize;
        first..first + self.count as usize
    }

    /// Returns the leaves one by one.
    pub fn iter(self) -> impl Iterator<Item = LeafIndex> {
        (self.first.0..self.first.0.saturating_add(self.count)).map(LeafIndex)
    }

    /// Returns true if the range has no leaves.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.count == 0
    }

    /// Returns true if `leaf` is in the range.
    #[must_use]
    pub fn contains(self, leaf: LeafIndex) -> bool {
        leaf.0 >= self.first.0 && leaf.0 - self.first.0 < self.count
    }
}

/// The number of a frame of one [`Culler`](crate::Culler), counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameId(pub u64);

/// The identity of a hierarchy, to detect data made for another hierarchy. Clones share it.
#[derive(Clone, Debug, Default)]
pub struct HierarchyId(Arc<()>);

impl PartialEq for HierarchyId {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for HierarchyId {}

/// The number of changes so far after which some nodes of a hierarchy have another meaning than
/// before: rebuilds of the whole or a part, and leaves that another object moved into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Generation(pub u32);
