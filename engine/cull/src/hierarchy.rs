//! The bounding-volume hierarchy: nodes in depth-first pre-order, one object a leaf, every subtree
//! one contiguous range of leaves.

mod build;
mod refit;
mod topology;

use std::sync::Arc;

use thiserror::Error;

use crate::bounds::Aabb;
use crate::ids::{Generation, LeafIndex, LeafRange, NodeId, ObjectId};
pub(crate) use topology::{NO_NODE, Topology};

/// Largest coordinate that a box may have (metres), so that squares of distances stay finite.
pub const MAX_COORDINATE: f32 = 1.0e15;

/// Objects that one hierarchy can hold: its node ids stay below 2^31.
pub const MAX_OBJECTS: usize = 1 << 30;

/// Why a hierarchy cannot be built or refitted.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum HierarchyError {
    /// A box has a coordinate that is infinite, no number, or beyond [`MAX_COORDINATE`], or its
    /// minimum lies above its maximum.
    #[error(
        "object {} has no usable bounding box ({} to {}): \
         check its mesh and its transform for infinities and NaN", object.0, bounds.min, bounds.max
    )]
    BadBox {
        /// The object.
        object: ObjectId,
        /// Its box as it was given.
        bounds: Aabb,
    },
    /// More objects than [`MAX_OBJECTS`].
    #[error("{count} objects are more than one hierarchy holds ({MAX_OBJECTS}): split the scene")]
    TooMany {
        /// How many there were.
        count: usize,
    },
    /// An object that the hierarchy was not built with.
    #[error("object {} is not in the hierarchy: rebuild it when objects are added", object.0)]
    UnknownObject {
        /// The object.
        object: ObjectId,
    },
}

/// A bounding-volume hierarchy over the boxes of objects.
///
/// Ids of nodes that are not in the hierarchy are answered as if the node were empty; no accessor
/// panics.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    /// Shared with the cullers, which carry their history across a rebuild with it.
    pub(crate) topology: Arc<Topology>,
    bounds: Vec<Aabb>,
    generation: Generation,
    revision: u64,
    refit_scratch: refit::Scratch,
}

impl Hierarchy {
    /// Builds the hierarchy of `boxes`; the position of a box is its object's id.
    ///
    /// # Errors
    /// [`HierarchyError::BadBox`] names the first object whose box is unusable;
    /// [`HierarchyError::TooMany`].
    pub fn build(boxes: &[Aabb]) -> Result<Self, HierarchyError> {
        let topology = build::topology(boxes)?;
        let bounds = build::node_bounds(&topology, boxes);
        Ok(Self {
            topology: Arc::new(topology),
            bounds,
            generation: Generation(0),
            revision: 0,
            refit_scratch: refit::Scratch::default(),
        })
    }

    /// Builds anew, for instance after objects were added, removed, or moved so far that the old
    /// shape is a bad one. Cullers notice by themselves and carry their history over by object:
    /// an object keeps its id, or its history is that of the object that had the id before.
    ///
    /// # Errors
    /// As [`Hierarchy::build`]; the hierarchy is then unchanged.
    pub fn rebuild(&mut self, boxes: &[Aabb]) -> Result<Generation, HierarchyError> {
        let generation = Generation(self.generation.0.wrapping_add(1));
        let revision = self.revision.wrapping_add(1);
        *self = Self { generation, revision, ..Self::build(boxes)? };
        Ok(generation)
    }

    /// Moves objects: sets their boxes and updates the boxes of their ancestors and no others.
    ///
    /// # Errors
    /// [`HierarchyError::BadBox`] or [`HierarchyError::UnknownObject`] for the first object that
    /// cannot be moved; those before it have been, and the hierarchy is consistent.
    pub fn refit(
        &mut self,
        moved: impl IntoIterator<Item = (ObjectId, Aabb)>,
    ) -> Result<(), HierarchyError> {
        self.revision = self.revision.wrapping_add(1);
        refit::refit(&self.topology, &mut self.bounds, &mut self.refit_scratch, moved)
    }

    /// How often it was rebuilt.
    #[must_use]
    pub fn generation(&self) -> Generation {
        self.generation
    }

    /// Counts the calls that may have changed a box: for copies of the boxes kept elsewhere.
    #[must_use]
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The node above all others; `None` if there are no objects.
    #[must_use]
    pub fn root(&self) -> Option<NodeId> {
        (!self.bounds.is_empty()).then_some(NodeId(0))
    }

    /// How many nodes there are: twice the objects less one.
    #[must_use]
    pub fn node_count(&self) -> usize {
        self.bounds.len()
    }

    /// The object of each leaf, in depth-first order.
    #[must_use]
    pub fn leaf_objects(&self) -> &[ObjectId] {
        &self.topology.leaf_objects
    }

    /// Where an object's leaf stands in depth-first order.
    #[must_use]
    pub fn leaf_of(&self, object: ObjectId) -> Option<LeafIndex> {
        let node = *self.topology.object_nodes.get(object.0 as usize)?;
        Some(self.leaves(NodeId(node)).first)
    }

    /// The node of an object's leaf.
    #[must_use]
    pub fn node_of(&self, object: ObjectId) -> Option<NodeId> {
        self.topology.object_nodes.get(object.0 as usize).map(|node| NodeId(*node))
    }

    /// The box around everything under a node; [`Aabb::EMPTY`] for a foreign id.
    #[must_use]
    pub fn bounds(&self, node: NodeId) -> Aabb {
        self.bounds.get(node.0 as usize).copied().unwrap_or(Aabb::EMPTY)
    }

    /// The leaves under a node; none for a foreign id.
    #[must_use]
    pub fn leaves(&self, node: NodeId) -> LeafRange {
        match self.topology.nodes.get(node.0 as usize) {
            Some(links) => {
                LeafRange { first: LeafIndex(links.first_leaf), count: links.leaf_count }
            }
            None => LeafRange { first: LeafIndex(0), count: 0 },
        }
    }

    /// The two children of an inner node; `None` for a leaf or a foreign id.
    #[must_use]
    pub fn children(&self, node: NodeId) -> Option<[NodeId; 2]> {
        let links = self.topology.nodes.get(node.0 as usize)?;
        (links.leaf_count > 1).then(|| links.children(node.0).map(NodeId))
    }

    /// The node above; `None` for the root or a foreign id.
    #[must_use]
    pub fn parent(&self, node: NodeId) -> Option<NodeId> {
        let links = self.topology.nodes.get(node.0 as usize)?;
        (links.parent != NO_NODE).then_some(NodeId(links.parent))
    }

    /// How many nodes lie above; 0 for the root or a foreign id.
    #[must_use]
    pub fn level(&self, node: NodeId) -> u32 {
        self.topology.nodes.get(node.0 as usize).map_or(0, |links| links.level)
    }
}

/// Whether a box can be part of a hierarchy.
fn check(object: usize, bounds: &Aabb) -> Result<(), HierarchyError> {
    let usable = bounds.is_finite()
        && bounds.largest_coordinate() <= MAX_COORDINATE
        && bounds.min.cmple(bounds.max).all();
    if usable {
        return Ok(());
    }
    Err(HierarchyError::BadBox {
        object: ObjectId(u32::try_from(object).unwrap_or(u32::MAX)),
        bounds: *bounds,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn whatever_may_change_a_box_is_another_revision() {
        let unit = Aabb::new(Vec3::ZERO, Vec3::ONE);
        let mut hierarchy = Hierarchy::build(&[unit, unit]).unwrap();
        let mut revisions = vec![hierarchy.revision()];
        hierarchy.refit([(ObjectId(1), unit.enlarged(1.0))]).unwrap();
        revisions.push(hierarchy.revision());
        // The object before the bad one has been moved.
        let moves = [(ObjectId(0), unit.enlarged(2.0)), (ObjectId(2), unit)];
        assert!(hierarchy.refit(moves).is_err());
        revisions.push(hierarchy.revision());
        hierarchy.rebuild(&[unit]).unwrap();
        revisions.push(hierarchy.revision());
        revisions.dedup();
        assert_eq!(revisions.len(), 4);
        assert!(hierarchy.rebuild(&[Aabb::EMPTY]).is_err());
        assert_eq!(revisions.last(), Some(&hierarchy.revision()), "nothing has changed");
    }
}
