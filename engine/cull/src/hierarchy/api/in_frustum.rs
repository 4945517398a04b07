//! Finds what a view sees of a hierarchy by its boxes: the frustum, and what section planes leave.

use super::super::Hierarchy;
use crate::geom::frustum::{Containment, PlaneMask};
use crate::geom::view::View;
use crate::ids::NodeId;

impl Hierarchy {
    /// Returns the number of objects; free leaves are none.
    #[must_use]
    pub fn object_count(&self) -> u32 {
        self.topology.nodes.first().map_or(0, |root| root.leaf_count) - self.free_below(0)
    }

    /// Returns true if the section planes of a view leave nothing of what is under a node.
    #[must_use]
    pub fn is_cut_away(&self, node: NodeId, view: &View) -> bool {
        view.cuts_away(&self.bounds(node)) && !self.has_whole(node)
    }

    /// Counts the objects whose box meets the view's frustum and what section planes keep: exactly
    /// those that [`Strategy::FRUSTUM`](crate::Strategy::FRUSTUM) draws.
    ///
    /// Descends only into nodes that cross a plane of the frustum, so the cost grows with the
    /// frustum's surface and not with its contents or its surroundings; with section planes it
    /// grows with the contents. Allocates nothing.
    #[must_use]
    pub fn objects_in_frustum(&self, view: &View) -> u32 {
        let mut count = 0;
        let mut node = 0;
        // In pre-order the node after a subtree is the next that is not below it.
        while let Some((links, bounds)) =
            self.topology.nodes.get(node as usize).zip(self.nodes.bounds.get(node as usize))
        {
            let (containment, _) = view.frustum.classify(bounds, PlaneMask::ALL);
            let containment = match containment {
                _ if self.is_cut_away(NodeId(node), view) => Containment::Outside,
                Containment::Inside if !view.section.is_empty() => Containment::Intersects,
                containment => containment,
            };
            node = match containment {
                Containment::Intersects if !links.is_leaf() => node + 1,
                Containment::Outside => links.end(node),
                Containment::Intersects | Containment::Inside => {
                    count += links.leaf_count - self.free_below(node);
                    links.end(node)
                }
            };
        }
        count
    }

    fn free_below(&self, node: u32) -> u32 {
        self.nodes.free.get(node as usize).copied().unwrap_or(0)
    }
}
