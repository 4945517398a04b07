//! The bounding-volume hierarchy: nodes in depth-first pre-order, one object per leaf. Every
//! subtree is one contiguous range of leaves.

mod api;
mod box_log;
mod build;
mod chunks;
mod error;
pub(crate) mod front_to_back;
mod journal;
mod node;
mod node_set;
mod occupancy;
mod rebuild_subtrees;
mod refit;
mod topology;
mod wear;

use crate::geom::bounds::Aabb;
use crate::ids::{Generation, HierarchyId, LeafIndex, LeafRange, NodeId, ObjectId};
pub use api::changes::HierarchyWork;
pub use box_log::BoxChange;
pub use error::{BUILD_BYTES_PER_OBJECT, HierarchyError, MAX_OBJECTS};
pub(crate) use journal::{Change, FREE_LEAF, NEW_LEAF, Restructured};
pub(crate) use topology::{NO_NODE, Topology};

/// A bounding-volume hierarchy over the boxes of objects.
///
/// An [empty box](Aabb::EMPTY) is not an object but a free leaf, as room for an object that is
/// [inserted](Hierarchy::insert) later.
///
/// A node id that is not in the hierarchy counts as an empty node; no accessor panics.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    id: HierarchyId,
    pub(crate) topology: Topology,
    nodes: refit::Nodes,
    generation: Generation,
    /// The generation since which each node has had its meaning.
    births: Vec<Generation>,
    /// The generation since which each id has belonged to its object, by id.
    arrivals: Vec<Generation>,
    journal: journal::Journal,
    boxes: box_log::BoxLog,
    worn: rebuild_subtrees::Worn,
    /// The nodes that a refit must update; empty between refits.
    stale: node_set::NodeSet,
    search: occupancy::Search,
    /// Subtrees to rebuild; kept for its memory.
    chosen: Vec<u32>,
    work: HierarchyWork,
    whole: api::whole::WholeObjects,
}

impl Hierarchy {
    /// Builds the hierarchy of `boxes`; the index of a box is the id of its object.
    ///
    /// # Errors
    /// [`HierarchyError::BadBox`] names the first object whose box is unusable;
    /// [`HierarchyError::TooMany`]; [`HierarchyError::NoMemory`].
    pub fn build(boxes: &[Aabb]) -> Result<Self, HierarchyError> {
        let topology = build::topology(boxes)?;
        let nodes = refit::Nodes::new(&topology, boxes);
        let generation = Generation(0);
        Ok(Self {
            id: HierarchyId::default(),
            births: vec![generation; topology.nodes.len()],
            worn: rebuild_subtrees::Worn::new(topology.nodes.len()),
            arrivals: vec![generation; topology.leaf_objects.len()],
            topology,
            nodes,
            generation,
            journal: journal::Journal::default(),
            boxes: box_log::BoxLog::default(),
            stale: node_set::NodeSet::default(),
            search: occupancy::Search::default(),
            chosen: Vec::new(),
            work: HierarchyWork::default(),
            whole: api::whole::WholeObjects::default(),
        })
    }

    /// Checks a number of objects against the limit of a hierarchy and against the available
    /// memory, before their boxes are listed.
    ///
    /// # Errors
    /// [`HierarchyError::TooMany`]; [`HierarchyError::NoMemory`].
    pub fn check_capacity(count: usize) -> Result<(), HierarchyError> {
        build::check_capacity(count)
    }

    /// Returns the identity of the hierarchy, which clones share.
    #[must_use]
    pub fn id(&self) -> &HierarchyId {
        &self.id
    }

    /// Returns the number of changes so far that gave some node another meaning.
    #[must_use]
    pub fn generation(&self) -> Generation {
        self.generation
    }

    /// Returns the root; `None` if there are no leaves.
    #[must_use]
    pub fn root(&self) -> Option<NodeId> {
        (!self.nodes.all.is_empty()).then_some(NodeId(0))
    }

    /// Returns the number of nodes: twice the number of leaves minus one.
    #[must_use]
    pub fn node_count(&self) -> usize {
        self.nodes.all.len()
    }

    /// Returns the object of each leaf, in depth-first order; the free id for a free leaf.
    #[must_use]
    pub fn leaf_objects(&self) -> &[ObjectId] {
        &self.topology.leaf_objects
    }

    /// Returns the position of an object's leaf in depth-first order.
    #[must_use]
    #[inline]
    pub fn leaf_of(&self, object: ObjectId) -> Option<LeafIndex> {
        let node = *self.topology.object_nodes.get(object.0 as usize)?;
        Some(self.leaves(NodeId(node)).first)
    }

    /// Returns true if an object is in the hierarchy.
    #[must_use]
    #[inline]
    pub fn contains(&self, object: ObjectId) -> bool {
        refit::occupied(&self.topology, &self.nodes, object).is_ok()
    }

    /// Returns the node of an object's leaf.
    #[must_use]
    #[inline]
    pub fn node_of(&self, object: ObjectId) -> Option<NodeId> {
        self.topology.object_nodes.get(object.0 as usize).map(|node| NodeId(*node))
    }

    /// Returns the box around all objects under a node; [`Aabb::EMPTY`] if there are none, or for a
    /// foreign id.
    #[must_use]
    #[inline]
    pub fn bounds(&self, node: NodeId) -> Aabb {
        self.nodes.all.get(node.0 as usize).map_or(Aabb::EMPTY, |data| data.bounds())
    }

    /// Returns the leaves under a node; an empty range for a foreign id.
    #[must_use]
    #[inline]
    pub fn leaves(&self, node: NodeId) -> LeafRange {
        match self.topology.nodes.get(node.0 as usize) {
            Some(links) => {
                LeafRange { first: LeafIndex(links.first_leaf), count: links.leaf_count }
            }
            None => LeafRange { first: LeafIndex(0), count: 0 },
        }
    }

    /// Returns the two children of an inner node; `None` for a leaf or a foreign id.
    #[must_use]
    pub fn children(&self, node: NodeId) -> Option<[NodeId; 2]> {
        let links = self.topology.nodes.get(node.0 as usize)?;
        (links.leaf_count > 1).then(|| links.children(node.0).map(NodeId))
    }

    /// Returns the parent of a node; `None` for the root or a foreign id.
    #[must_use]
    pub fn parent(&self, node: NodeId) -> Option<NodeId> {
        let links = self.topology.nodes.get(node.0 as usize)?;
        (links.parent != NO_NODE).then_some(NodeId(links.parent))
    }

    /// Returns the number of ancestors of a node; 0 for the root or a foreign id.
    #[must_use]
    pub fn level(&self, node: NodeId) -> u32 {
        self.topology.nodes.get(node.0 as usize).map_or(0, |links| links.level)
    }
}
