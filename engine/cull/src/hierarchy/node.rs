//! The data of a node that depends on the objects under it.

use glam::{Vec3, Vec4};

use crate::geom::bounds::Aabb;

/// The box of a node and two sums, in two vectors: a refit unites millions of boxes, and a vector
/// that was just stored can be loaded again without a stall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// The least corner, and the sum of the half areas of all inner nodes of the subtree (square
    /// metres).
    min_and_areas: Vec4,
    /// The greatest corner, and the bits of the number of leaves without an object.
    max_and_free: Vec4,
}

impl Node {
    /// The data of a node without leaves.
    pub(super) const EMPTY: Self = Self::new(Aabb::EMPTY, 0.0, 0);

    const fn new(bounds: Aabb, areas: f32, free: u32) -> Self {
        let Aabb { min, max } = bounds;
        Self {
            min_and_areas: Vec4::new(min.x, min.y, min.z, areas),
            max_and_free: Vec4::new(max.x, max.y, max.z, f32::from_bits(free)),
        }
    }

    /// Returns the data of a leaf, which is free if its box is empty.
    #[inline]
    pub(super) fn leaf(bounds: Aabb) -> Self {
        Self::new(bounds, 0.0, u32::from(bounds.is_empty()))
    }

    /// Returns the data of the parent of two nodes.
    #[inline]
    pub(super) fn above(left: &Self, right: &Self) -> Self {
        let mut above = Self {
            min_and_areas: left.min_and_areas.min(right.min_and_areas),
            max_and_free: left.max_and_free.max(right.max_and_free),
        };
        above.min_and_areas.w = above.half_area() + left.areas() + right.areas();
        above.max_and_free.w = f32::from_bits(left.free() + right.free());
        above
    }

    /// Returns the box around all objects under the node.
    #[inline]
    pub(super) fn bounds(&self) -> Aabb {
        Aabb::new(self.min_and_areas.truncate(), self.max_and_free.truncate())
    }

    /// Returns the number of leaves without an object under the node.
    #[inline]
    pub(super) const fn free(&self) -> u32 {
        self.max_and_free.to_array()[3].to_bits()
    }

    /// Returns the sum of the half areas of all inner nodes of the subtree (square metres).
    #[inline]
    pub(super) const fn areas(&self) -> f32 {
        self.min_and_areas.to_array()[3]
    }

    /// Returns half of the surface area of the box (square metres).
    #[inline]
    pub(super) fn half_area(&self) -> f32 {
        // The empty box has negative sizes.
        let size = (self.max_and_free - self.min_and_areas).max(Vec4::ZERO).truncate();
        size.dot(Vec3::new(size.y, size.z, size.x))
    }
}
