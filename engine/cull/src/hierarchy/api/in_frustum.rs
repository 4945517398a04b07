//! The objects of a hierarchy whose boxes are in a view's frustum and not removed by section
//! planes: their number, for statistics, and their leaves.

use super::super::Hierarchy;
use crate::geom::frustum::{Containment, Frustum, PlaneMask};
use crate::geom::view::CullView;
use crate::ids::{LeafIndex, LeafRange, NodeId};

impl Hierarchy {
    /// Returns the number of objects, without free leaves.
    #[must_use]
    pub fn object_count(&self) -> u32 {
        self.topology.nodes.first().map_or(0, |root| root.leaf_count) - self.free_below(0)
    }

    /// Returns true if the section planes of a view remove everything under a node.
    #[must_use]
    pub fn is_cut_away(&self, node: NodeId, view: &CullView) -> bool {
        view.cuts_away(&self.bounds(node)) && !self.has_whole(node)
    }

    /// Counts the objects whose box meets the view's frustum and is not removed by section planes:
    /// exactly the objects that [`Strategy::FRUSTUM`](crate::Strategy::FRUSTUM) draws.
    ///
    /// Descends only into nodes that cross a plane of the frustum, so the cost grows with the
    /// frustum's surface and not with its contents or its surroundings. With section planes the
    /// cost grows with the contents. Does not allocate.
    #[must_use]
    pub fn objects_in_frustum(&self, view: &CullView) -> u32 {
        let mut count = 0;
        self.visit_in(&view.frustum, view, |node, leaves| {
            count += leaves.count - self.free_below(node);
        });
        count
    }

    /// Adds the leaves to `found` whose box meets a frustum and is not removed by the section
    /// planes of a view. Ranges are ascending and do not touch; they may include free leaves. The
    /// cost grows as in [`Hierarchy::objects_in_frustum`].
    pub fn leaves_in(&self, frustum: &Frustum, view: &CullView, found: &mut Vec<LeafRange>) {
        let first = found.len();
        self.visit_in(frustum, view, |_, leaves| {
            match found.get_mut(first..).and_then(<[_]>::last_mut) {
                Some(last) if last.first.0 + last.count == leaves.first.0 => {
                    last.count += leaves.count
                }
                _ => found.push(leaves),
            }
        });
    }

    /// Calls `visit` with the topmost nodes that are inside of a frustum and not cut, and with
    /// leaves that meet it.
    fn visit_in(&self, frustum: &Frustum, view: &CullView, mut visit: impl FnMut(u32, LeafRange)) {
        let is_cut = !view.section.is_empty();
        let mut node = 0;
        // In pre-order, the node after a subtree is the next node that is not below it.
        while let Some((links, data)) =
            self.topology.nodes.get(node as usize).zip(self.nodes.all.get(node as usize))
        {
            let (containment, _) = frustum.classify(&data.bounds(), PlaneMask::ALL);
            let containment = match containment {
                _ if is_cut && self.is_cut_away(NodeId(node), view) => Containment::Outside,
                Containment::Inside if is_cut => Containment::Intersects,
                containment => containment,
            };
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
        self.nodes.all.get(node as usize).map_or(0, |data| data.free())
    }
}
