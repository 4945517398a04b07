//! The wear of subtrees: finds the subtrees that were refitted so much that a rebuild pays off.
//!
//! The measure is the surface-area cost (Goldsmith and Salmon 1987, "Automatic Creation of Object
//! Hierarchies for Ray Tracing"): the summed areas of all inner nodes over the area of the topmost.
//! The cost does not change when a subtree moves or grows as a whole. It grows when the parts of
//! the subtree drift apart or a part leaves. A subtree is worn when its cost is well above the cost
//! after its last build.

use std::collections::TryReserveError;

use super::node::Node;

/// The factor by which a cost may grow before the subtree counts as worn. Boxes of moving objects
/// grow and shrink: with a smaller factor a rebuild would recur frame after frame without a gain.
const GROWTH: f32 = 1.4;

/// The least cost to compare with: the cost of a single node. A subtree that was built without
/// objects has no cost.
const LEAST_COST: f32 = 1.0;

/// The least leaves of a worn subtree: fewer leaves can hardly be arranged better.
pub(super) const LEAVES_MIN: u32 = 4;

/// The number of leaves that one update may rebuild: a fraction of a millisecond of work.
pub(super) const LEAVES_PER_UPDATE: u32 = 1024;

/// The most leaves of a hierarchy that an update may rebuild as a whole: tens of milliseconds at
/// worst, and seldom, because a rebuild resets the wear.
pub(super) const LEAVES_OF_WHOLE: u32 = 1 << 15;

/// The cost of each subtree after its last build.
#[derive(Clone, Debug, Default)]
pub(super) struct Wear {
    built: Vec<f32>,
}

impl Wear {
    /// Creates the wear of a number of nodes, which must be [reset](Wear::reset).
    pub(super) fn new(nodes: usize) -> Self {
        Self { built: vec![0.0; nodes] }
    }

    /// The memory per node (bytes).
    pub(super) const BYTES: usize = size_of::<f32>();

    /// Reserves memory for [`Wear::add`].
    pub(super) fn try_reserve(&mut self, nodes: usize) -> Result<(), TryReserveError> {
        self.built.try_reserve_exact(nodes)
    }

    /// Adds nodes, which must be reset as in [`Wear::new`].
    pub(super) fn add(&mut self, nodes: usize) {
        self.built.resize(self.built.len() + nodes, 0.0);
    }

    /// Records the present cost of a node's subtree as the cost after a build.
    pub(super) fn reset(&mut self, node: u32, data: &Node) {
        let area = data.half_area();
        self.built[node as usize] = if area > 0.0 { data.areas() / area } else { 0.0 };
    }

    /// Returns the area (square metres) that a rebuild of the subtree is expected to save; `None`
    /// if the subtree is not worn.
    #[inline]
    pub(super) fn excess(&self, node: u32, data: &Node) -> Option<f32> {
        let built = self.built[node as usize].max(LEAST_COST) * data.half_area();
        (data.areas() > GROWTH * built).then(|| data.areas() - built)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geom::bounds::Aabb;

    /// Returns node 0 above two nodes that hold two leaves each, and the area that a rebuild of
    /// these four leaves saves.
    fn worn(left: Aabb, right: Aabb, wear: &Wear) -> (Node, Option<f32>) {
        let node = |bounds: Aabb| Node::above(&Node::leaf(bounds), &Node::leaf(bounds));
        let both = Node::above(&node(left), &node(right));
        (both, wear.excess(0, &both))
    }

    fn cube(x: f32, size: f32) -> Aabb {
        Aabb::new(Vec3::X * x, Vec3::X * x + size)
    }

    #[test]
    fn moving_and_growing_as_a_whole_is_no_wear() {
        let mut wear = Wear::new(1);
        let (both, _) = worn(cube(0.0, 1.0), cube(2.0, 1.0), &wear);
        wear.reset(0, &both);
        assert_eq!(worn(cube(50.0, 1.0), cube(52.0, 1.0), &wear).1, None);
        assert_eq!(worn(cube(0.0, 10.0), cube(20.0, 10.0), &wear).1, None);
    }

    #[test]
    fn parts_that_mingle_are_wear_until_the_next_build() {
        let mut wear = Wear::new(1);
        let (both, _) = worn(cube(0.0, 1.0), cube(20.0, 1.0), &wear);
        wear.reset(0, &both);
        let mingled = cube(0.0, 1.0).union(&cube(20.0, 1.0));
        let (both, excess) = worn(mingled, mingled, &wear);
        assert!(excess.is_some_and(|area| area > both.half_area()), "{excess:?}");
        wear.reset(0, &both);
        assert_eq!(wear.excess(0, &both), None);
    }

    #[test]
    fn what_has_no_objects_is_not_worn() {
        let (both, excess) = worn(Aabb::EMPTY, Aabb::EMPTY, &Wear::new(1));
        assert_eq!((both.bounds(), excess), (Aabb::EMPTY, None));
    }
}
