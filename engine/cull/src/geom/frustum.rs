//! Tests of boxes against the view frustum. A mask of planes saves tests below a node that lies
//! completely inside of a plane.

use glam::{DVec4, Mat4, Vec3, Vec4};

use crate::geom::bounds::Aabb;
use crate::geom::margin::rounding;
use crate::geom::projection::{DEPTH_ROUNDING, DepthConvention, Rows};
use crate::geom::rays::Rays;

/// The position of a box with respect to the frustum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Containment {
    /// No point of the box is in the frustum.
    Outside,
    /// Some points of the box may be in the frustum.
    Intersects,
    /// All points of the box are in the frustum.
    Inside,
}

/// The planes that a box still has to be tested against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PlaneMask(u8);

impl PlaneMask {
    /// All six planes.
    pub const ALL: Self = Self(0b11_1111);

    /// The mark of a box outside of the frustum: nothing in it must be tested.
    pub(crate) const OUTSIDE: Self = Self(0b1000_0000);

    /// Returns true if the box that gave this mask is inside of every plane.
    #[must_use]
    pub fn is_inside(self) -> bool {
        self.0 == 0
    }
}

/// The volume that a view sees: near, left, right, top, bottom and, if there is one, far plane.
///
/// The planes are derived from the matrix that draws, so they fit off-centre and jittered
/// projections. All computations are relative to the eye. A box counts as outside only if it is
/// outside by more than the rounding errors of this test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    origin: Vec3,
    coordinate: f32,
    /// The planes: near, left, right, top; then bottom and far.
    planes: [FourPlanes; 2],
}

/// Four planes, a coordinate of all of them in one vector: a box is tested against four at once.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FourPlanes {
    /// The inward normals.
    x: Vec4,
    y: Vec4,
    z: Vec4,
    /// The distances of the planes from the origin along their normals.
    offset: Vec4,
}

impl FourPlanes {
    /// Four planes that cut off nothing.
    const NONE: Self =
        Self { x: Vec4::ZERO, y: Vec4::ZERO, z: Vec4::ZERO, offset: Vec4::NEG_INFINITY };

    /// Creates the planes of inward normals with the offsets as `w`.
    fn new(planes: [Vec4; 4]) -> Self {
        let Mat4 { x_axis, y_axis, z_axis, w_axis } =
            Mat4::from_cols_array_2d(&planes.map(|plane| plane.to_array())).transpose();
        Self { x: x_axis, y: y_axis, z: z_axis, offset: w_axis }
    }

    /// Returns the coordinates of a point along the normals (metres).
    fn along(&self, point: Vec3) -> Vec4 {
        self.x * point.x + self.y * point.y + self.z * point.z
    }

    /// Returns the distances by which a box of this half extent reaches along the normals (metres).
    fn reaches(&self, half: Vec3) -> Vec4 {
        self.x.abs() * half.x + self.y.abs() * half.y + self.z.abs() * half.z
    }
}

/// A plane that cuts off nothing.
const NO_PLANE: Vec4 = Vec4::new(0.0, 0.0, 0.0, f32::NEG_INFINITY);

impl Frustum {
    /// The frustum that contains everything.
    pub const EVERYTHING: Self =
        Self { origin: Vec3::ZERO, coordinate: 0.0, planes: [FourPlanes::NONE; 2] };

    /// Creates the frustum of a matrix (to clip space with y down) for points relative to `anchor`,
    /// from the depth convention and the rays of the matrix.
    #[must_use]
    pub fn new(from_anchor: &Mat4, anchor: Vec3, depth: DepthConvention, rays: &Rays) -> Self {
        let Rows { x, y, z, w } = Rows::of(from_anchor);
        let origin = (rays.origin.as_dvec3() - anchor.as_dvec3()).extend(1.0);
        let plane = |row: DVec4| {
            let length = row.truncate().length();
            let offset = -row.dot(origin) / length;
            (row.truncate() / length).extend(offset).as_vec4()
        };
        let (near, far, far_terms) = match depth {
            DepthConvention::Reversed => (w - z, z, 0.0),
            DepthConvention::Standard => (z, w - z, 1.0),
        };
        let far = far_plane(far, w, far_terms, rays).map_or(NO_PLANE, plane);
        let planes = [
            FourPlanes::new([plane(near), plane(w + x), plane(w - x), plane(w + y)]),
            FourPlanes::new([plane(w - y), far, NO_PLANE, NO_PLANE]),
        ];
        Self { origin: rays.origin, coordinate: rays.coordinate, planes }
    }

    /// Returns true if a convex body is completely outside of one plane. `most` returns the largest
    /// coordinate of its points along a normal (metres).
    pub(crate) fn is_outside(&self, most: impl Fn(Vec3) -> f32) -> bool {
        self.planes.iter().any(|planes| {
            let FourPlanes { x, y, z, .. } = planes;
            let most =
                Vec4::from_array(std::array::from_fn(|at| most(Vec3::new(x[at], y[at], z[at]))));
            // The difference of two coordinates of the world first, so that little is lost.
            (most - planes.along(self.origin)).cmplt(planes.offset).any()
        })
    }

    /// Tests a box against the planes in `mask`. Also returns the planes that parts of the box must
    /// be tested against. An [empty](Aabb::is_empty) box is outside of every frustum.
    #[must_use]
    pub fn classify(&self, bounds: &Aabb, mask: PlaneMask) -> (Containment, PlaneMask) {
        if bounds.is_empty() {
            return (Containment::Outside, PlaneMask(0));
        }
        if mask.is_inside() {
            return (Containment::Inside, mask);
        }
        let centre = bounds.centre() - self.origin;
        let half = bounds.half_extent();
        let slack = rounding(bounds, self.coordinate);
        let mut outside = 0;
        let mut inside = 0;
        for (planes, first) in self.planes.iter().zip([0, 4]) {
            if mask.0 >> first & 0b1111 == 0 {
                continue;
            }
            let distances = planes.along(centre) - planes.offset;
            let reaches = planes.reaches(half) + slack;
            outside |= distances.cmplt(-reaches).bitmask() << first;
            // A NaN keeps the plane.
            inside |= distances.cmpgt(reaches).bitmask() << first;
        }
        if outside & u32::from(mask.0) != 0 {
            return (Containment::Outside, PlaneMask(0));
        }
        let remaining = mask.0 & !(inside as u8);
        let containment =
            if remaining == 0 { Containment::Inside } else { Containment::Intersects };
        (containment, PlaneMask(remaining))
    }
}

/// Returns the row of the far plane, moved away by a bound on the rounding with which a rasteriser
/// computes its sides; `None` if it is infinitely far away or lost in this rounding. For a depth
/// that is not reversed, the row is a small difference of `w` and z that contains `w` `terms`
/// times.
fn far_plane(row: DVec4, w: DVec4, terms: f64, rays: &Rays) -> Option<DVec4> {
    let [constant, scaled] = rays.depth.map(|depth| f64::from(depth.abs()));
    let coordinate = f64::from(rays.coordinate);
    let terms = terms + constant;
    let fixed = terms * coordinate + scaled * (1.0 + coordinate);
    let row = row + (w * terms + DVec4::W * fixed) * f64::from(DEPTH_ROUNDING);
    (row.truncate().dot(rays.forward.as_dvec3()) < 0.0).then_some(row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::camera::{Camera, Projection};
    use crate::geom::view::CullView;

    fn looking_down_z() -> Frustum {
        let camera = Camera {
            eye: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(std::f32::consts::FRAC_PI_2),
            near: 0.1,
        };
        CullView::new(&camera, [64, 64], 8).frustum
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
    fn rounding_far_from_the_origin_leaves_no_box_out() {
        let eye = Vec3::new(1.0e6, 0.0, 0.0);
        let camera = Camera {
            eye,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(std::f32::consts::FRAC_PI_2),
            near: 0.1,
        };
        let frustum = CullView::new(&camera, [64, 64], 8).frustum;
        // The numbers beside a million are sixteenths, so that the middle of a box between two of
        // them is none. One corner of each box is a centimetre within the frustum.
        for step in 0..8 {
            let aside = 20.0 + step as f32 / 16.0;
            let low = Vec3::new(eye.x + aside, -1.0, -aside - 0.01);
            let bounds = Aabb::new(low, Vec3::new(low.x + 1.0 / 16.0, 1.0, -1.0));
            let (containment, _) = frustum.classify(&bounds, PlaneMask::ALL);
            assert_eq!(containment, Containment::Intersects, "{bounds:?}");
        }
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
