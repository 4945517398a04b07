//! The far end of shadow volumes: infinity, or a plane beyond all that receives shadows.
//!
//! A volume is filled pixel by pixel as far as it goes, so most of one that goes to infinity is
//! filled for nothing: under the ground. Under a sun the way from a corner to a plane is a linear
//! function of the corner, so corners that are moved to the plane by it span flat caps, and sides
//! that share a corner share its end.

use cull::{Aabb, ProjectionKind, Rays, View};
use glam::{Vec2, Vec3, Vec4};

use super::counting::NearSpan;

/// The least distance in metres of the end from the last receiver, and its share of the size of
/// what is around: more than what vertices are rounded by.
const MARGIN: [f32; 2] = [0.01, 1.0e-4];

/// The least steps per pixel of a sub-pixel grid on which a sun's volumes end. On a coarser one a
/// thin triangle that is not long may get a depth that is nowhere on it: SwiftShader has 16 steps,
/// and of 100 images of seeded meshes two had a wrong pixel, one away from any edge.
const LEAST_STEPS: f32 = 256.0;

/// The length of a sun's volumes in a parallel view, in sizes of what is in view.
const SUN_LENGTH: f32 = 10.0;

/// The nearest that casters come to a lamp where volumes end in a parallel view (metres).
const NEAREST_CASTER_M: f32 = 1e-3;

/// The far end of the shadow volumes of a light: the place of the point behind each corner.
///
/// The point behind `v` is `max(l.w, w) v - max(along · (v, 1), 0) l`, with this `w`, where `l` is
/// the light in homogeneous coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeEnd {
    /// The factor by which the light is taken off, as a linear function of the corner.
    pub along: Vec4,
    /// The points' own w: 0 for infinity.
    pub w: f32,
}

impl VolumeEnd {
    /// Infinity.
    pub const INFINITY: Self = Self { along: Vec4::W, w: 0.0 };

    /// Returns the end of the volumes of a light for a view of `receivers`, which lie before it.
    ///
    /// A sun's volumes end at the plane beyond the receivers that is met first. With an eye beyond
    /// that plane they have no end: z-pass would count from outside of it. Nor have they on a
    /// coarse sub-pixel grid. A lamp's have none either, since pixels that it does not reach are
    /// left out anyway.
    ///
    /// In a parallel view no ray meets a far cap that is all at infinity, and the farther away it
    /// is, the worse drivers round what they clip of the sides. So volumes always end there, beyond
    /// all that is in view: a sun's ten times as far away as that is large, a lamp's where a caster
    /// that is a millimetre from it shades what is in view.
    #[must_use]
    pub fn of(view: &View, light: Vec4, receivers: &Aabb) -> Self {
        if view.rays.kind == ProjectionKind::Orthographic {
            return Self::of_parallel(&view.rays, light);
        }
        let steps = 2.0 * view.snap_steps[0] / view.size[0] as f32;
        if light.w > 0.0 || receivers.is_empty() || steps < LEAST_STEPS {
            return Self::INFINITY;
        }
        let end = Self::beyond(receivers, light.truncate());
        let is_before = |point: &Vec3| end.length_m(*point) > 0.0;
        match NearSpan::points_of(&view.rays).iter().all(is_before) {
            true => end,
            false => Self::INFINITY,
        }
    }

    /// Returns the point behind a corner, in homogeneous coordinates.
    #[must_use]
    pub fn behind(&self, corner: Vec3, light: Vec4) -> Vec4 {
        let kept = light.w.max(self.w) * corner;
        (kept - self.length_m(corner).max(0.0) * light.truncate()).extend(self.w)
    }

    /// Returns the way from a corner to the end; under a sun in metres.
    fn length_m(&self, corner: Vec3) -> f32 {
        self.along.dot(corner.extend(1.0))
    }

    /// Returns the side of a box, and beyond, that rays of a sun from anywhere in it meet first.
    fn beyond(receivers: &Aabb, towards: Vec3) -> Self {
        let [least, share] = MARGIN;
        let size_m = receivers.half_extent().length() + receivers.largest_coordinate();
        let around = receivers.enlarged(least + share * size_m);
        let (extent, slope) = (around.half_extent(), towards.abs());
        let steps = extent / slope;
        let axis = match steps.min_element() {
            least if steps.x == least => Vec3::X,
            least if steps.y == least => Vec3::Y,
            _ => Vec3::Z,
        };
        let speed = axis.dot(towards);
        let last = axis.dot(around.centre()) - speed.signum() * axis.dot(extent);
        Self { along: (axis / speed).extend(-last / speed), w: 1.0 }
    }

    fn of_parallel(rays: &Rays, light: Vec4) -> Self {
        let [near_depth, slope] = rays.depth;
        let length_m = if slope == 0.0 { 0.0 } else { (near_depth / slope).abs() };
        let middle = rays.point(Vec2::ZERO, 0.5 * length_m);
        let size_m = length_m + rays.right.length() + rays.down.length();
        if light.w > 0.0 {
            let reach_m = size_m + middle.distance(light.truncate());
            let w = NEAREST_CASTER_M / reach_m.max(NEAREST_CASTER_M);
            return Self { along: (1.0 - w) * Vec4::W, w };
        }
        Self { along: SUN_LENGTH * size_m * Vec4::W, w: 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use cull::{Camera, Projection};
    use glam::vec3;

    use super::*;

    const RECEIVERS: Aabb = Aabb::new(vec3(-50.0, 0.0, -80.0), vec3(50.0, 30.0, 80.0));

    fn view(eye: Vec3, sub_pixel_bits: u32) -> View {
        let projection = Projection::perspective(1.0);
        let camera = Camera { eye, forward: Vec3::X, up: Vec3::Y, projection, near: 0.1 };
        View::new(&camera, [64, 48], sub_pixel_bits)
    }

    fn suns() -> impl Iterator<Item = Vec3> {
        let steps = || (-3..4).map(|step| step as f32 / 3.0);
        let all = steps().flat_map(move |x| steps().map(move |z| vec3(x, 0.2, z).normalize()));
        all.chain([Vec3::X, Vec3::Y, Vec3::NEG_Z, -vec3(0.1, 1.0, 0.3).normalize()])
    }

    #[test]
    fn all_receivers_lie_before_the_end() {
        let view = view(vec3(0.0, 2.0, 0.0), 8);
        for sun in suns() {
            let light = sun.extend(0.0);
            let end = VolumeEnd::of(&view, light, &RECEIVERS);
            assert_eq!(end.w, 1.0, "{sun}");
            // What a corner shades of the receivers lies between it and the point behind it.
            for corner in RECEIVERS.corners() {
                let behind = end.behind(corner, light).truncate();
                let way_m = (corner - behind).dot(sun);
                assert!(way_m > 0.0, "{sun}: {corner}");
                let just_beyond = RECEIVERS.enlarged(1e-3);
                assert!(!just_beyond.contains(&Aabb::new(behind, behind)), "{sun}: {behind}");
                let middle = end.behind(RECEIVERS.centre(), light).truncate();
                assert!((middle - behind).dot(end.along.truncate()).abs() < 1e-3, "a plane");
            }
            assert!((end.behind(RECEIVERS.centre(), light).truncate()).length() < 400.0);
        }
    }

    #[test]
    fn a_high_suns_volumes_end_below_the_ground() {
        let view = view(vec3(0.0, 2.0, 0.0), 8);
        let sun = vec3(0.6, 0.8, 0.0);
        let end = VolumeEnd::of(&view, sun.extend(0.0), &RECEIVERS);
        let behind = end.behind(vec3(1.0, 8.0, 3.0), sun.extend(0.0));
        assert!((behind - vec3(-5.0, 0.0, 3.0).extend(1.0)).length() < 0.1, "{behind}");
        let below = end.behind(vec3(1.0, -8.0, 3.0), sun.extend(0.0));
        assert_eq!(below, vec3(1.0, -8.0, 3.0).extend(1.0), "beyond it already");
    }

    #[test]
    fn eyes_beyond_lamps_empty_scenes_and_coarse_grids_leave_them_endless() {
        let below = view(vec3(0.0, -2.0, 0.0), 8);
        assert_eq!(VolumeEnd::of(&below, Vec4::Y, &RECEIVERS), VolumeEnd::INFINITY);
        let above = view(vec3(0.0, 2.0, 0.0), 8);
        let lamp = vec3(1.0, 5.0, 0.0).extend(1.0);
        assert_eq!(VolumeEnd::of(&above, lamp, &RECEIVERS), VolumeEnd::INFINITY);
        assert_eq!(VolumeEnd::of(&above, Vec4::Y, &Aabb::EMPTY), VolumeEnd::INFINITY);
        let coarse = view(vec3(0.0, 2.0, 0.0), 4);
        assert_eq!(VolumeEnd::of(&coarse, Vec4::Y, &RECEIVERS), VolumeEnd::INFINITY);
        let corner = vec3(1.0, 2.0, 3.0);
        assert_eq!(VolumeEnd::INFINITY.behind(corner, Vec4::Y), -Vec4::Y);
        assert_eq!(VolumeEnd::INFINITY.behind(corner, lamp), vec3(0.0, -3.0, 3.0).extend(0.0));
    }
}
