//! Axis-aligned boxes: union, overlap, distance, in metres.

use glam::Vec3;

/// Largest coordinate that a box may have (metres), so that squares of distances stay finite.
pub const MAX_COORDINATE: f32 = 1.0e15;

/// An axis-aligned bounding box in world space (metres).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The corner with the smallest coordinates.
    pub min: Vec3,
    /// The corner with the largest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The empty box: the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// Creates a box from its two extreme corners.
    #[must_use]
    pub const fn new(min: Vec3, max: Vec3) -> Self {
        Self { min, max }
    }

    /// Returns the smallest box around both boxes.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns the box grown by `distance` in all six directions.
    #[must_use]
    pub fn enlarged(&self, distance: f32) -> Self {
        Self { min: self.min - distance, max: self.max + distance }
    }

    /// Returns the centre of the box.
    #[must_use]
    pub fn centre(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Returns half of the size along each axis.
    #[must_use]
    pub fn half_extent(&self) -> Vec3 {
        self.max * 0.5 - self.min * 0.5
    }

    /// Returns the squared distance from `point` to the nearest point of the box; 0 inside.
    #[must_use]
    pub fn distance_squared(&self, point: Vec3) -> f32 {
        (self.min - point).max(point - self.max).max(Vec3::ZERO).length_squared()
    }

    /// Returns true if `point` is inside of the box or on its surface.
    #[must_use]
    pub fn contains_point(&self, point: Vec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Returns true if no point of `other` is outside of the box.
    #[must_use]
    pub fn contains(&self, other: &Self) -> bool {
        other.min.cmpge(self.min).all() && other.max.cmple(self.max).all()
    }

    /// Returns true if some point is in both boxes.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Returns true if the box contains nothing, not even a point. Free leaves, and nodes with only
    /// free leaves, have such a box.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Returns half of the surface area (square metres); 0 for [`Aabb::EMPTY`].
    #[must_use]
    pub fn half_area(&self) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        let size = self.max - self.min;
        size.dot(Vec3::new(size.y, size.z, size.x))
    }

    /// Returns true if all six coordinates are finite numbers.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// Returns true if an object may have this box: it is finite and not [empty](Aabb::is_empty),
    /// and no coordinate is beyond [`MAX_COORDINATE`].
    #[must_use]
    #[inline]
    pub fn is_usable(&self) -> bool {
        let limit = Vec3::splat(MAX_COORDINATE);
        // Refits check every box, so in few instructions: a NaN fails each comparison.
        (self.min.cmpge(-limit) & self.max.cmple(limit) & self.min.cmple(self.max)).all()
    }

    /// Returns the largest absolute coordinate, to which single-precision rounding is relative.
    #[must_use]
    pub fn largest_coordinate(&self) -> f32 {
        self.min.abs().max(self.max.abs()).max_element()
    }

    /// Returns the eight corners.
    #[must_use]
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|corner| {
            let upper = glam::BVec3::new(corner & 1 != 0, corner & 2 != 0, corner & 4 != 0);
            Vec3::select(upper, self.max, self.min)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_is_neutral_and_distance_is_to_the_surface() {
        let unit = Aabb::new(Vec3::ZERO, Vec3::ONE);
        assert_eq!(Aabb::EMPTY.union(&unit), unit);
        assert!(!Aabb::EMPTY.is_finite());
        assert!(Aabb::EMPTY.is_empty() && !unit.is_empty());
        assert!(!Aabb::new(Vec3::ONE, Vec3::ONE).is_empty(), "a point is something");
        assert_eq!((Aabb::EMPTY.half_area(), unit.half_area()), (0.0, 3.0));
        assert_eq!(unit.distance_squared(Vec3::splat(0.5)), 0.0);
        assert_eq!(unit.distance_squared(Vec3::new(3.0, 0.5, 0.5)), 4.0);
        assert_eq!(unit.enlarged(1.0).half_extent(), Vec3::splat(1.5));
    }

    #[test]
    fn corners_span_the_box() {
        let bounds = Aabb::new(Vec3::new(-1.0, 2.0, 3.0), Vec3::new(4.0, 5.0, 6.0));
        let spanned = bounds
            .corners()
            .iter()
            .fold(Aabb::EMPTY, |sum, corner| sum.union(&Aabb::new(*corner, *corner)));
        assert_eq!(spanned, bounds);
    }
}
