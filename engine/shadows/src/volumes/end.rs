//! The far end of shadow volumes: at infinity, or at a plane beyond all receivers.
//!
//! A volume is rasterised over its whole length, so most of an infinite volume is filled for
//! nothing: under the ground. Under a sun, the distance from a corner to a plane along the light is
//! a linear function of the corner. Under a lamp, the same holds for the ratio of the distances
//! from the lamp to the corner and to the plane. So corners that are moved to the plane by this
//! function span flat caps, and sides that share a corner share its end.

use cull::{Aabb, CullView, ProjectionKind, Rays};
use glam::{DVec3, DVec4, Vec2, Vec3, Vec4};

use super::counting::NearSpan;

/// The distance of the end from the last receiver: at least this many metres, plus this share of
/// the size of the surroundings. It is more than the rounding of vertices.
const MARGIN: [f32; 2] = [0.01, 1.0e-4];

/// The least steps per pixel of the sub-pixel grid at which a sun's volumes end at a plane. On a
/// coarser grid, a thin triangle that is not long may get a depth that lies nowhere on it.
/// SwiftShader has 16 steps: of 100 images of seeded meshes, two had a wrong pixel, one of them
/// away from any edge.
const LEAST_STEPS: f32 = 256.0;

/// The length of a sun's volumes in a parallel view, in multiples of the size of the view volume.
const SUN_LENGTH: f32 = 10.0;

/// The least distance of casters from a lamp for which volumes are right in a parallel view
/// (metres).
const NEAREST_CASTER_M: f32 = 1e-3;

/// The least ratio of a caster's distance from a lamp to the distance of the plane at which its
/// volumes end: rounding grows as this ratio shrinks.
const LEAST_SHARE: f64 = 0.05;

/// The far end of shadow volumes: a function from each corner to the point behind it.
///
/// The point behind `v` is `max(l.w, w) v - max(along · (v, 1), 0) l`, where `l` is the light in
/// homogeneous coordinates and `w` is the field of this type. Under a lamp, the result's fourth
/// coordinate is 1 minus the factor of `l`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeEnd {
    /// The factor by which the light is subtracted, as a linear function of the corner. Far from
    /// the origin of the world its terms are large and cancel.
    pub along: DVec4,
    /// The fourth coordinate of points behind a sun's corners: 0 for infinity.
    pub w: f32,
}

impl VolumeEnd {
    /// Infinity.
    pub const INFINITY: Self = Self { along: DVec4::W, w: 0.0 };

    /// Returns the ends that volumes under a light may have in a view of `receivers`. All ends lie
    /// beyond the receivers. Each caster uses its [nearest](VolumeEnd::nearest) end.
    ///
    /// A sun's volumes end at the nearest plane beyond the receivers, a lamp's volumes at any side
    /// of the receivers' box or at infinity. A plane is not used if the eye is beyond it, since
    /// z-pass would then count from outside of the volumes. Planes are not used on a coarse
    /// sub-pixel grid either.
    ///
    /// In a parallel view, no ray meets a far cap at infinity, and drivers round clipped sides the
    /// worse the farther away it is. So volumes in such a view always end at a finite distance
    /// beyond the view volume. For a sun, this is ten times the size of the view volume. For a
    /// lamp, it suffices for casters at least a millimetre away from the lamp.
    #[must_use]
    pub fn of(view: &CullView, light: Vec4, receivers: &Aabb) -> Vec<Self> {
        if view.rays.kind == ProjectionKind::Orthographic {
            return vec![Self::of_parallel(&view.rays, light)];
        }
        let steps = 2.0 * view.snap_steps[0] / view.size[0] as f32;
        if receivers.is_empty() || steps < LEAST_STEPS {
            return vec![Self::INFINITY];
        }
        let span = NearSpan::points_of(&view.rays);
        let is_before = |end: &Self| span.iter().all(|point| end.factor(*point) > 0.0);
        let around = Self::around(receivers, view.anchor);
        if light.w > 0.0 {
            let sides = Self::beside(&around, light.truncate()).filter(is_before);
            return sides.chain([Self::INFINITY]).collect();
        }
        let end = Self::beyond(&around, light.truncate());
        vec![if is_before(&end) { end } else { Self::INFINITY }]
    }

    /// Returns the index of the end at which volumes of casters in a box are shortest.
    #[must_use]
    pub fn nearest(ends: &[Self], bounds: &Aabb) -> usize {
        let least_share = |end: &Self| {
            let half_extent = bounds.half_extent().as_dvec3();
            let most = end.factor(bounds.centre()) + end.along.truncate().abs().dot(half_extent);
            let share = 1.0 - most;
            if share >= LEAST_SHARE { share } else { 0.0 }
        };
        let shares = ends.iter().map(least_share).enumerate();
        // Of equal shares, `max_by` takes the last: infinity.
        shares.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(place, _)| place)
    }

    /// Returns the point behind a corner, in homogeneous coordinates.
    #[must_use]
    pub fn behind(&self, corner: Vec3, light: Vec4) -> Vec4 {
        let factor = self.factor(corner).max(0.0);
        let kept = f64::from(light.w.max(self.w)) * corner.as_dvec3();
        let w = if light.w > 0.0 { 1.0 - factor } else { f64::from(self.w) };
        (kept - factor * light.truncate().as_dvec3()).extend(w).as_vec4()
    }

    /// Returns the factor as a function of corners relative to a point (metres).
    #[must_use]
    pub fn along_from(&self, anchor: Vec3) -> Vec4 {
        let of_anchor = self.along.dot(anchor.as_dvec3().extend(1.0));
        self.along.truncate().extend(of_anchor).as_vec4()
    }

    /// Returns the factor by which the light is subtracted from a corner; under a sun in metres.
    fn factor(&self, corner: Vec3) -> f64 {
        self.along.dot(corner.as_dvec3().extend(1.0))
    }

    /// Returns the box at whose sides volumes may end, with a margin for vertices that are relative
    /// to the anchor.
    fn around(receivers: &Aabb, anchor: Vec3) -> Aabb {
        let [least, share] = MARGIN;
        let from_anchor = Aabb::new(receivers.min - anchor, receivers.max - anchor);
        let size_m = receivers.half_extent().length() + from_anchor.largest_coordinate();
        receivers.enlarged(least + share * size_m)
    }

    /// Returns the ends at those sides of a box that face away from a lamp beyond them.
    fn beside(around: &Aabb, position: Vec3) -> impl Iterator<Item = Self> {
        let sides = [around.min, around.max].into_iter().flat_map(move |corner| {
            [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| (axis, axis.dot(corner.as_dvec3())))
        });
        let centre = around.centre().as_dvec3();
        let position = position.as_dvec3();
        sides.filter_map(move |(axis, side)| {
            let way = side - axis.dot(position);
            let outwards = side - axis.dot(centre);
            // The ratio of distances grows from 0 at the lamp to 1 at the side.
            let share = (axis / way).extend(-axis.dot(position) / way);
            (way * outwards > 0.0).then_some(Self { along: DVec4::W - share, w: 1.0 })
        })
    }

    /// Returns the end at the side of a box that rays of a sun from anywhere in the box reach
    /// first.
    fn beyond(around: &Aabb, towards: Vec3) -> Self {
        let extent = around.half_extent().as_dvec3();
        let towards = towards.as_dvec3();
        let slope = towards.abs();
        let steps = extent / slope;
        let axis = match steps.min_element() {
            least if steps.x == least => DVec3::X,
            least if steps.y == least => DVec3::Y,
            _ => DVec3::Z,
        };
        let speed = axis.dot(towards);
        let last = axis.dot(around.centre().as_dvec3()) - speed.signum() * axis.dot(extent);
        Self { along: (axis / speed).extend(-last / speed), w: 1.0 }
    }

    fn of_parallel(rays: &Rays, light: Vec4) -> Self {
        let [near_depth, slope] = rays.depth;
        let length_m = if slope == 0.0 { 0.0 } else { (near_depth / slope).abs() };
        let middle = rays.point(Vec2::ZERO, 0.5 * length_m);
        let size_m = length_m + rays.right.length() + rays.down.length();
        if light.w > 0.0 {
            let reach_m = size_m + middle.distance(light.truncate());
            let w = f64::from(NEAREST_CASTER_M / reach_m.max(NEAREST_CASTER_M));
            return Self { along: (1.0 - w) * DVec4::W, w: 1.0 };
        }
        Self { along: f64::from(SUN_LENGTH * size_m) * DVec4::W, w: 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use cull::{Camera, Projection};
    use glam::vec3;

    use super::*;

    const RECEIVERS: Aabb = Aabb::new(vec3(-50.0, 0.0, -80.0), vec3(50.0, 30.0, 80.0));

    fn view(eye: Vec3, sub_pixel_bits: u32) -> CullView {
        let projection = Projection::perspective(1.0);
        let camera = Camera { eye, forward: Vec3::X, up: Vec3::Y, projection, near: 0.1 };
        CullView::new(&camera, [64, 48], sub_pixel_bits)
    }

    fn suns() -> impl Iterator<Item = Vec3> {
        let steps = || (-3..4).map(|step| step as f32 / 3.0);
        let all = steps().flat_map(move |x| steps().map(move |z| vec3(x, 0.2, z).normalize()));
        all.chain([Vec3::X, Vec3::Y, Vec3::NEG_Z, -vec3(0.1, 1.0, 0.3).normalize()])
    }

    fn end_of(view: &CullView, light: Vec4) -> VolumeEnd {
        let ends = VolumeEnd::of(view, light, &RECEIVERS);
        let [end] = ends[..] else { panic!("a sun has one end: {ends:?}") };
        end
    }

    #[test]
    fn all_receivers_lie_before_the_end() {
        let view = view(vec3(0.0, 2.0, 0.0), 8);
        for sun in suns() {
            let light = sun.extend(0.0);
            let end = end_of(&view, light);
            assert_eq!(end.w, 1.0, "{sun}");
            // The shadow of a corner on the receivers lies between the corner and the point behind
            // it.
            for corner in RECEIVERS.corners() {
                let behind = end.behind(corner, light).truncate();
                let way_m = (corner - behind).dot(sun);
                assert!(way_m > 0.0, "{sun}: {corner}");
                let just_beyond = RECEIVERS.enlarged(1e-3);
                assert!(!just_beyond.contains(&Aabb::new(behind, behind)), "{sun}: {behind}");
                let middle = end.behind(RECEIVERS.centre(), light).truncate();
                assert!(
                    (middle - behind).dot(end.along.truncate().as_vec3()).abs() < 1e-3,
                    "a plane"
                );
            }
            assert!((end.behind(RECEIVERS.centre(), light).truncate()).length() < 400.0);
        }
    }

    #[test]
    fn a_high_suns_volumes_end_below_the_ground() {
        let view = view(vec3(0.0, 2.0, 0.0), 8);
        let sun = vec3(0.6, 0.8, 0.0);
        let end = end_of(&view, sun.extend(0.0));
        let behind = end.behind(vec3(1.0, 8.0, 3.0), sun.extend(0.0));
        assert!((behind - vec3(-5.0, 0.0, 3.0).extend(1.0)).length() < 0.1, "{behind}");
        let below = end.behind(vec3(1.0, -8.0, 3.0), sun.extend(0.0));
        assert_eq!(below, vec3(1.0, -8.0, 3.0).extend(1.0), "beyond it already");
    }

    #[test]
    fn a_lamps_volumes_end_at_the_side_that_their_casters_are_nearest_to() {
        let view = view(vec3(0.0, 2.0, 0.0), 8);
        let position = vec3(1.0, 5.0, 0.0);
        let light = position.extend(1.0);
        let ends = VolumeEnd::of(&view, light, &RECEIVERS);
        assert_eq!((ends.len(), ends.last()), (7, Some(&VolumeEnd::INFINITY)));
        let end_of = |low: Vec3, high: Vec3| ends[VolumeEnd::nearest(&ends, &Aabb::new(low, high))];
        let place = |end: VolumeEnd, corner: Vec3| {
            let behind = end.behind(corner, light);
            behind.truncate() / behind.w
        };
        let car = end_of(vec3(3.0, 0.0, -1.0), vec3(7.0, 1.5, 1.0));
        let behind = place(car, vec3(3.0, 1.0, 1.0));
        assert!((behind - vec3(3.5, 0.0, 1.25)).length() < 0.1, "on the ground: {behind}");
        let tower = end_of(vec3(20.0, 0.0, -5.0), vec3(30.0, 30.0, 5.0));
        let behind = place(tower, vec3(20.0, 8.0, 0.0));
        assert!((behind.x - 50.0).abs() < 0.2 && behind.y > 12.0, "on a wall: {behind}");
        let around = end_of(vec3(0.0, 0.0, -5.0), vec3(2.0, 9.0, 5.0));
        assert_eq!(around, VolumeEnd::INFINITY, "the light is in it");
        let outside = VolumeEnd::of(&view, vec3(0.0, 40.0, 0.0).extend(1.0), &RECEIVERS);
        assert_eq!(outside.len(), 6, "above all that it lights");
    }

    #[test]
    fn eyes_beyond_empty_scenes_and_coarse_grids_leave_them_endless() {
        let below = view(vec3(0.0, -2.0, 0.0), 8);
        let endless = vec![VolumeEnd::INFINITY];
        assert_eq!(VolumeEnd::of(&below, Vec4::Y, &RECEIVERS), endless);
        let above = view(vec3(0.0, 2.0, 0.0), 8);
        let lamp = vec3(1.0, 5.0, 0.0).extend(1.0);
        assert_eq!(VolumeEnd::of(&below, lamp, &RECEIVERS).len(), 6, "not at the ground");
        let coarse = view(vec3(0.0, 2.0, 0.0), 4);
        for light in [Vec4::Y, lamp] {
            assert_eq!(VolumeEnd::of(&above, light, &Aabb::EMPTY), endless);
            assert_eq!(VolumeEnd::of(&coarse, light, &RECEIVERS), endless);
        }
        let corner = vec3(1.0, 2.0, 3.0);
        assert_eq!(VolumeEnd::INFINITY.behind(corner, Vec4::Y), -Vec4::Y);
        assert_eq!(VolumeEnd::INFINITY.behind(corner, lamp), vec3(0.0, -3.0, 3.0).extend(0.0));
    }
}
