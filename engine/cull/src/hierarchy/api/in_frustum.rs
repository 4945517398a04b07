//! The objects of a hierarchy in a frustum: their number, for statistics, and their leaves.

use super::super::Hierarchy;
use crate::geom::frustum::{Containment, Frustum, PlaneMask};
use crate::geom::view::View;
use crate::ids::{LeafIndex, LeafRange};

impl Hierarchy {
    /// Returns the number of objects; free leaves are none.
    #[must_use]
    pub fn object_count(&self) -> u32 {
        self.topology.nodes.first().map_or(0, |root| root.leaf_count) - self.free_below(0)
    }

    /// Counts the objects whose box meets the view's frustum: exactly those that
    /// [`Strategy::FRUSTUM`](crate::Strategy::FRUSTUM) draws.
    ///
    /// Descends only into nodes that cross a plane of the frustum, so the cost grows with the
    /// frustum's surface and not with its contents or its surroundings. Allocates nothing.
    #[must_use]
    pub fn objects_in_frustum(&self, view: &View) -> u32 {
        let mut count = 0;
        self.visit_in(&view.frustum, |node, leaves| count += leaves.count - self.free_below(node));
        count
    }

    /// Adds the leaves whose box meets a frustum to `found`, in ascending ranges that do not touch;
    /// free leaves may be among them. The cost grows as in [`Hierarchy::objects_in_frustum`].
    pub fn leaves_in(&self, frustum: &Frustum, found: &mut Vec<LeafRange>) {
        let first = found.len();
        self.visit_in(frustum, |_, leaves| {
            match found.get_mut(first..).and_then(<[_]>::last_mut) {
                Some(last) if last.first.0 + last.count == leaves.first.0 => {
                    last.count += leaves.count
                }
                _ => found.push(leaves),
            }
        });
    }

    /// Calls `visit` with the topmost nodes that meet a frustum wholly, or are leaves.
    fn visit_in(&self, frustum: &Frustum, mut visit: impl FnMut(u32, LeafRange)) {
        let mut node = 0;
        // In pre-order the node after a subtree is the next that is not below it.
        while let Some((links, bounds)) =
            self.topology.nodes.get(node as usize).zip(self.nodes.bounds.get(node as usize))
        {
            let (containment, _) = frustum.classify(bounds, PlaneMask::ALL);
            if containment == Containment::Intersects && !links.is_leaf() {
                node += 1;
                continue;
            }
            if containment != Containment::Outside {
                let first = LeafIndex(links.first_leaf);
                visit(node, LeafRange { first, count: links.leaf_count });
            }
            node = links.end(node);
        }
    }

    fn free_below(&self, node: u32) -> u32 {
        self.nodes.free.get(node as usize).copied().unwrap_or(0)
    }
}
