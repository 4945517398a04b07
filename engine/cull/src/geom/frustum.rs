//! Boxes against the view frustum: the bounding sphere first, then the box. A mask per plane saves
//! tests below a node that lies wholly inside of it.

use glam::Vec3;

use crate::geom::bounds::Aabb;
use crate::geom::margin::rounding;

/// The position of a box with respect to the frustum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Containment {
    /// No point of the box is in the frustum.
    Outside,
    /// Some of it may be.
    Intersects,
    /// All of it is.
    Inside,
}

/// The planes that a box still has to be tested against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PlaneMask(u8);

impl PlaneMask {
    /// All five planes.
    pub const ALL: Self = Self(0b1_1111);

    /// Returns true if the box that this mask came from is inside of every plane.
    #[must_use]
    pub fn is_inside(self) -> bool {
        self.0 == 0
    }
}

/// The infinite pyramid that a camera sees: near, left, right, bottom and top plane, no far plane.
///
/// The side planes go through the eye, so everything is computed relative to the eye; a box is
/// only called outside when it is so by more than the rounding errors of this test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    eye: Vec3,
    /// Inward normals, and the distance of the plane from the eye along them.
    planes: [(Vec3, f32); 5],
}

impl Frustum {
    /// Creates a frustum from an orthonormal basis at the eye and the tangents of the half angles.
    #[must_use]
    pub fn new(
        eye: Vec3,
        [right, up, forward]: [Vec3; 3],
        [tan_half_x, tan_half_y]: [f32; 2],
        near: f32,
    ) -> Self {
        let side = |across: Vec3, tangent: f32| {
            let normal = (across + forward * tangent).normalize_or(forward);
            (normal, 0.0)
        };
        Self {
            eye,
            planes: [
                (forward, near),
                side(right, tan_half_x),
                side(-right, tan_half_x),
                side(up, tan_half_y),
                side(-up, tan_half_y),
            ],
        }
    }

    /// Tests a box against the planes in `mask`; also returns the planes that its parts have to be
    /// tested against. An [empty](Aabb::is_empty) box is outside of everything.
    #[must_use]
    pub fn classify(&self, bounds: &Aabb, mask: PlaneMask) -> (Containment, PlaneMask) {
        if bounds.is_empty() {
            return (Containment::Outside, PlaneMask(0));
        }
        if mask.is_inside() {
            return (Containment::Inside, mask);
        }
        let centre = bounds.centre() - self.eye;
        let half = bounds.half_extent();
        let radius = half.length();
        let slack = rounding(bounds, self.eye);
        let mut remaining = 0;
        for (number, (normal, offset)) in self.planes.iter().enumerate() {
            let bit = 1 << number;
            if mask.0 & bit == 0 {
                continue;
            }
            let distance = normal.dot(centre) - offset;
            if distance > radius + slack {
                continue;
            }
            if distance < -(radius + slack) {
                return (Containment::Outside, PlaneMask(0));
            }
            let reach = normal.abs().dot(half) + slack;
            if distance < -reach {
                return (Containment::Outside, PlaneMask(0));
            }
            // Written so that a NaN keeps the plane.
            if !matches!(distance.partial_cmp(&reach), Some(std::cmp::Ordering::Greater)) {
                remaining |= bit;
            }
        }
        let containment =
            if remaining == 0 { Containment::Inside } else { Containment::Intersects };
        (containment, PlaneMask(remaining))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looking_down_z() -> Frustum {
        Frustum::new(Vec3::ZERO, [Vec3::X, Vec3::Y, Vec3::NEG_Z], [1.0, 1.0], 0.1)
    }

    fn cube(centre: Vec3, half: f32) -> Aabb {
        Aabb::new(centre - half, centre + half)
    }

    #[test]
    fn boxes_ahead_beside_and_behind() {
        let frustum = looking_down_z();
        let at = |x, y, z| frustum.classify(&cube(Vec3::new(x, y, z), 1.0), PlaneMask::ALL).0;
        assert_eq!(at(0.0, 0.0, -10.0), Containment::Inside);
        assert_eq!(at(10.0, 0.0, -10.0), Containment::Intersects);
        assert_eq!(at(13.0, 0.0, -10.0), Containment::Outside);
        assert_eq!(at(0.0, -13.0, -10.0), Containment::Outside);
        assert_eq!(at(0.0, 0.0, 3.0), Containment::Outside);
        assert_eq!(at(0.0, 0.0, 0.0), Containment::Intersects);
        assert_eq!(at(0.0, 0.0, -1.0e9), Containment::Inside);
    }

    #[test]
    fn the_box_test_is_sharper_than_the_sphere() {
        // A long thin box beside the frustum: its sphere reaches in, the box does not.
        let wall = Aabb::new(Vec3::new(21.0, -1.0, -20.0), Vec3::new(22.0, 1.0, -1.0));
        let (containment, _) = looking_down_z().classify(&wall, PlaneMask::ALL);
        assert_eq!(containment, Containment::Outside);
    }

    #[test]
    fn nothing_is_never_inside() {
        for mask in [PlaneMask::ALL, PlaneMask(0)] {
            let (containment, _) = looking_down_z().classify(&Aabb::EMPTY, mask);
            assert_eq!(containment, Containment::Outside);
        }
    }

    #[test]
    fn planes_that_are_passed_are_not_asked_again() {
        let frustum = looking_down_z();
        let (_, mask) = frustum.classify(&cube(Vec3::new(10.0, 0.0, -10.0), 1.0), PlaneMask::ALL);
        assert_eq!(mask.0.count_ones(), 1);
        let (containment, mask) = frustum.classify(&cube(Vec3::new(9.5, 0.0, -10.5), 0.4), mask);
        assert_eq!((containment, mask.is_inside()), (Containment::Inside, true));
    }
}
