//! The nodes in the frustum from front to back, for methods with their own traversal.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::geom::bounds::Aabb;
use crate::geom::frustum::{Containment, PlaneMask};
#[cfg(doc)]
use crate::geom::rays::Rays;
use crate::geom::view::CullView;
use crate::hierarchy::Hierarchy;
use crate::ids::{LeafIndex, NodeId};

/// A scene as one view sees it.
#[derive(Clone, Copy)]
pub(crate) struct ViewedHierarchy<'a> {
    pub(crate) hierarchy: &'a Hierarchy,
    pub(crate) view: &'a CullView,
}

/// A node in the frustum, ordered by distance, then by id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct InSight {
    /// The squared distance as bits: non-negative floats sort like their bits.
    distance_bits: u32,
    pub(crate) node: NodeId,
    pub(crate) mask: PlaneMask,
}

impl InSight {
    /// Returns the distance from the eye to the node's box, as [`Rays::distance`] does (metres).
    pub(crate) fn distance(&self) -> f32 {
        f32::from_bits(self.distance_bits).sqrt()
    }
}

impl<'a> ViewedHierarchy<'a> {
    /// Returns the node if a part of it may be in the frustum; `mask` comes from the node above.
    pub(crate) fn look(&self, node: NodeId, mask: PlaneMask) -> Option<InSight> {
        let bounds = self.hierarchy.bounds(node);
        let (containment, mask) = self.view.frustum.classify(&bounds, mask);
        if self.hierarchy.is_cut_away(node, self.view) {
            return None;
        }
        let distance_bits = self.view.rays.distance_squared(&bounds).to_bits();
        (containment != Containment::Outside).then_some(InSight { distance_bits, node, mask })
    }

    pub(crate) fn root(&self) -> Option<InSight> {
        self.look(self.hierarchy.root()?, PlaneMask::ALL)
    }

    /// Returns the children that are in sight, the nearer first; `None` for a leaf.
    pub(crate) fn children(
        &self,
        above: &InSight,
    ) -> Option<impl Iterator<Item = InSight> + use<'a>> {
        let children = self.hierarchy.children(above.node)?;
        let mut seen = children.map(|child| self.look(child, above.mask));
        if let [Some(left), Some(right)] = &seen
            && right < left
        {
            seen.reverse();
        }
        Some(seen.into_iter().flatten())
    }

    /// Returns the box to test in place of a node; `None` if the node must count as visible.
    pub(crate) fn proxy(&self, node: NodeId) -> Option<Aabb> {
        self.view.margin.proxy(&self.hierarchy.bounds(node))
    }

    pub(crate) fn is_leaf(&self, node: NodeId) -> bool {
        self.hierarchy.children(node).is_none()
    }

    /// Returns the leaf of a leaf's node.
    pub(crate) fn leaf(&self, node: NodeId) -> LeafIndex {
        self.hierarchy.leaves(node).first
    }

    /// Fills `leaves` with the nodes of all leaves in sight, the nearest first. Returns the number
    /// of nodes visited.
    pub(crate) fn leaves(&self, leaves: &mut Vec<InSight>) -> u32 {
        leaves.clear();
        let mut visited = 0;
        let mut stack: Vec<InSight> = self.root().into_iter().collect();
        while let Some(node) = stack.pop() {
            visited += 1;
            match self.children(&node) {
                Some(children) => stack.extend(children),
                None => leaves.push(node),
            }
        }
        leaves.sort_unstable();
        visited
    }
}

/// A queue of nodes, the nearest first ("Hardware Occlusion Queries Made Useful", 6.5.7).
#[derive(Debug, Default)]
pub(crate) struct NearestFirst(BinaryHeap<Reverse<InSight>>);

impl NearestFirst {
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    pub(crate) fn extend(&mut self, nodes: impl IntoIterator<Item = InSight>) {
        self.0.extend(nodes.into_iter().map(Reverse));
    }

    pub(crate) fn pop(&mut self) -> Option<InSight> {
        self.0.pop().map(|Reverse(node)| node)
    }
}
