//! The camera of the viewer, which orbits a target in perspective or orthographic projection, and
//! the views of the cube that turns it.

use std::f32::consts::{FRAC_PI_2, PI};

use antumbra::cull::Aabb;
use antumbra::glam::Vec3;
use antumbra::{Camera, Projection};
use bench::options::FrameSize;

/// The vertical field of view in full perspective, in radians.
const FOV_Y_RAD: f32 = 40.0 * PI / 180.0;

/// The ratio of half the image's height to the distance below which a perspective is replaced by an
/// orthographic projection. At a depth of one image height behind the target, this moves a point by
/// half a pixel in an image of a thousand pixels. Farther eyes would lose as much to single
/// precision.
const LEAST_TANGENT: f32 = 1.0e-3;

/// The largest ratio of the near plane's distance to the target's.
const NEAR_SHARE: f32 = 1.0e-3;

/// The least height of an image at its target, in metres.
const LEAST_HEIGHT_M: f32 = 1.0e-5;

/// The largest height, in metres.
const MOST_HEIGHT_M: f32 = 1.0e6;

/// A camera that orbits a target.
///
/// Between perspective and orthographic projection, the image keeps its height at the target, while
/// the eye moves away and the field of view narrows (a dolly zoom). So the change is smooth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitCamera {
    /// The point in the middle of the image, in metres.
    pub target: Vec3,
    /// The angle about the vertical axis, in radians: 0 looks along -z, positive angles turn left.
    pub yaw_rad: f32,
    /// The elevation of the view direction, in radians, within a quarter turn.
    pub pitch_rad: f32,
    /// The height of the image at the target, in metres.
    pub height_m: f32,
    /// The position between perspective (0) and orthographic (1).
    pub flatness: f32,
}

impl OrbitCamera {
    /// Returns a camera in full perspective that sees a whole ball of `radius_m` around `target`,
    /// in images at least as wide as high.
    pub fn around(target: Vec3, radius_m: f32) -> Self {
        // The ball touches the view cone in front of its middle.
        let height_m = 2.0 * radius_m.max(1.0e-6) / (FOV_Y_RAD * 0.5).cos();
        let (yaw_rad, pitch_rad) = CubeView::ISOMETRIC.angles();
        Self { target, yaw_rad, pitch_rad, height_m, flatness: 0.0 }
    }

    /// Returns a camera that sees a whole box from a corner, in images of this size.
    pub fn fitted(bounds: &Aabb, size: FrameSize) -> Self {
        let middle = (bounds.min + bounds.max) * 0.5;
        let camera = Self::around(middle, (bounds.max - bounds.min).length() * 0.5);
        // In images that are higher than wide, the width decides.
        let narrow = (size.height as f32 / size.width as f32).max(1.0);
        Self { height_m: camera.height_m * narrow, ..camera }
    }

    /// Returns the view direction.
    pub fn forward(&self) -> Vec3 {
        let (sine, cosine) = self.yaw_rad.sin_cos();
        let (rise, level) = self.pitch_rad.sin_cos();
        Vec3::new(-sine * level, rise, -cosine * level)
    }

    /// Returns the direction to the right in the image.
    pub fn right(&self) -> Vec3 {
        Vec3::new(self.yaw_rad.cos(), 0.0, -self.yaw_rad.sin())
    }

    /// Returns the direction upwards in the image.
    pub fn up(&self) -> Vec3 {
        self.right().cross(self.forward())
    }

    /// Returns the ratio of half the image's height to the distance of the target.
    fn tangent(&self) -> f32 {
        (FOV_Y_RAD * 0.5).tan() * (1.0 - self.flatness.clamp(0.0, 1.0))
    }

    /// Returns the camera. It sees everything within `radius_m` of the target that is in front of
    /// the eye.
    pub fn camera(&self, radius_m: f32) -> Camera {
        let forward = self.forward();
        let up = self.up();
        let tangent = self.tangent();
        if tangent < LEAST_TANGENT {
            let eye = self.target - forward * radius_m;
            let projection =
                Projection::Orthographic { height: self.height_m, far: 2.0 * radius_m };
            return Camera { eye, forward, up, projection, near: 0.0 };
        }
        let distance_m = self.height_m / (2.0 * tangent);
        let eye = self.target - forward * distance_m;
        let near = (distance_m - radius_m).max(distance_m * NEAR_SHARE);
        let projection = Projection::perspective(2.0 * tangent.atan());
        Camera { eye, forward, up, projection, near }
    }

    /// Returns the orbit of a camera in full perspective, with the same eye and direction. The
    /// target is the point on its line of sight that is nearest to `near`.
    pub fn of_camera(camera: &Camera, near: Vec3) -> Self {
        let forward = camera.forward.normalize_or(Vec3::NEG_Z);
        let distance_m = (near - camera.eye).dot(forward).max(1.0e-3);
        Self {
            target: camera.eye + forward * distance_m,
            yaw_rad: (-forward.x).atan2(-forward.z),
            pitch_rad: forward.y.clamp(-1.0, 1.0).asin(),
            height_m: 2.0 * distance_m * (FOV_Y_RAD * 0.5).tan(),
            flatness: 0.0,
        }
    }

    /// Returns the camera turned about its target by angles in radians, so that the model follows
    /// the pointer to the right and down.
    #[must_use]
    pub fn turned_by(&self, right_rad: f32, down_rad: f32) -> Self {
        let pitch_rad = (self.pitch_rad - down_rad).clamp(-FRAC_PI_2, FRAC_PI_2);
        let yaw_rad = (self.yaw_rad - right_rad).rem_euclid(2.0 * PI);
        Self { yaw_rad, pitch_rad, ..*self }
    }

    /// Returns the camera moved so that the target's plane follows the pointer, in multiples of the
    /// image's height.
    #[must_use]
    pub fn panned(&self, right: f32, down: f32) -> Self {
        let by = (self.up() * down - self.right() * right) * self.height_m;
        Self { target: self.target + by, ..*self }
    }

    /// Returns the camera with the height of its image multiplied by `factor`. A place of the
    /// target's plane stays fixed; it is given relative to the middle, in multiples of the image's
    /// height.
    #[must_use]
    pub fn zoomed(&self, factor: f32, right: f32, down: f32) -> Self {
        let height_m = (self.height_m * factor).clamp(LEAST_HEIGHT_M, MOST_HEIGHT_M);
        let kept = 1.0 - height_m / self.height_m;
        Self { height_m, ..self.panned(-right * kept, -down * kept) }
    }

    /// Returns the camera with the same image whose target is at the depth of a point, if the point
    /// is in front of the eye.
    #[must_use]
    pub fn at_depth_of(&self, point: Vec3) -> Self {
        let forward = self.forward();
        let behind_m = (point - self.target).dot(forward);
        let tangent = self.tangent();
        if tangent < LEAST_TANGENT {
            return Self { target: self.target + forward * behind_m, ..*self };
        }
        let height_m = self.height_m + 2.0 * tangent * behind_m;
        if height_m < LEAST_HEIGHT_M {
            return *self;
        }
        Self { target: self.target + forward * behind_m, height_m, ..*self }
    }

    /// Returns the camera between this one (share 0) and another one (share 1).
    #[must_use]
    pub fn between(&self, to: &Self, share: f32) -> Self {
        let mix = |from: f32, to: f32| from + (to - from) * share;
        let turn_rad = (to.yaw_rad - self.yaw_rad + PI).rem_euclid(2.0 * PI) - PI;
        Self {
            target: self.target.lerp(to.target, share),
            yaw_rad: self.yaw_rad + turn_rad * share,
            pitch_rad: mix(self.pitch_rad, to.pitch_rad),
            height_m: mix(self.height_m, to.height_m),
            flatness: mix(self.flatness, to.flatness),
        }
    }

    /// Returns the camera between this one (share 0) and a view of the cube (share 1): along the
    /// shorter way, slow at both ends.
    pub fn turned_to(&self, view: CubeView, share: f32) -> Self {
        let share = share.clamp(0.0, 1.0);
        let eased = share * share * (3.0 - 2.0 * share);
        let (yaw_rad, pitch_rad) = view.angles();
        self.between(&Self { yaw_rad, pitch_rad, ..*self }, eased)
    }
}

/// One of the 26 views of the view cube: of a face, an edge or a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CubeView {
    /// The side of the eye along each axis: -1, 0 or 1. At least one is not 0.
    side: [i8; 3],
}

impl CubeView {
    /// The distance from the middle of a face beyond which a click selects the edge, in half edges.
    pub const EDGE: f32 = 0.7;

    /// The view from the corner of top, front and right.
    pub const ISOMETRIC: Self = Self { side: [1, 1, 1] };

    /// Returns the view with a name: `front`, `top-left`, `back-top-right`, or `iso`.
    pub fn named(name: &str) -> Option<Self> {
        if name == "iso" {
            return Some(Self::ISOMETRIC);
        }
        let mut side = [0_i8; 3];
        for word in name.split('-') {
            let (axis, sign) = match word {
                "right" => (0, 1),
                "left" => (0, -1),
                "top" => (1, 1),
                "bottom" => (1, -1),
                "front" => (2, 1),
                "back" => (2, -1),
                _ => return None,
            };
            if side[axis] != 0 {
                return None;
            }
            side[axis] = sign;
        }
        Some(Self { side })
    }

    /// Returns the view where a ray hits the cube from -1 to 1: the middle of a face gives the
    /// face, a band along an edge the edge, and a corner the corner.
    pub fn under(origin: Vec3, direction: Vec3) -> Option<Self> {
        let to_low = (Vec3::NEG_ONE - origin) / direction;
        let to_high = (Vec3::ONE - origin) / direction;
        let entry = to_low.min(to_high).max_element();
        let exit = to_low.max(to_high).min_element();
        if !entry.is_finite() || entry > exit || exit < 0.0 {
            return None;
        }
        let point = origin + direction * entry;
        let side = point
            .to_array()
            .map(|place| if place.abs() < Self::EDGE { 0 } else { place.signum() as i8 });
        (side != [0; 3]).then_some(Self { side })
    }

    /// Returns the view from a side, given along each axis as -1, 0 or 1; `None` for the middle.
    pub fn of_side(side: [i8; 3]) -> Option<Self> {
        (side != [0; 3]).then_some(Self { side: side.map(i8::signum) })
    }

    /// Returns the yaw and the pitch of an [`OrbitCamera`] on this side, in radians.
    fn angles(self) -> (f32, f32) {
        let [x, y, z] = self.side.map(f32::from);
        if x == 0.0 && z == 0.0 {
            return (0.0, -FRAC_PI_2 * y);
        }
        (x.atan2(z), -y.atan2((x * x + z * z).sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use antumbra::cull::CullView;

    use super::*;

    #[test]
    fn faces_edges_and_corners_are_seen_from_their_side() {
        for (name, from) in [
            ("front", Vec3::Z),
            ("back", Vec3::NEG_Z),
            ("right", Vec3::X),
            ("left", Vec3::NEG_X),
            ("top", Vec3::Y),
            ("bottom", Vec3::NEG_Y),
            ("top-left", Vec3::new(-1.0, 1.0, 0.0)),
            ("iso", Vec3::ONE),
        ] {
            let view = CubeView::named(name).unwrap();
            let camera = OrbitCamera::around(Vec3::ZERO, 1.0).turned_to(view, 1.0).camera(1.0);
            assert!(camera.forward.distance(-from.normalize()) < 1e-6, "{name}: {camera:?}");
            assert!(camera.up.is_normalized() && camera.up.dot(camera.forward).abs() < 1e-6);
            assert_eq!(CubeView::under(from * 9.0, -from), Some(view), "{name}");
        }
        for name in ["", "up", "front-back", "front-front", "iso-front"] {
            assert_eq!(CubeView::named(name), None, "{name}");
        }
        assert_eq!(CubeView::under(Vec3::Z * 9.0, Vec3::X), None);
        assert_eq!(CubeView::under(Vec3::Z * 9.0, Vec3::Z), None);
    }

    #[test]
    fn a_turn_takes_the_shorter_way() {
        let from = OrbitCamera { yaw_rad: 3.0, ..OrbitCamera::around(Vec3::ZERO, 1.0) };
        let half = from.turned_to(CubeView::named("left").unwrap(), 0.5);
        assert!(half.yaw_rad > 3.0 && half.yaw_rad < 3.0 + PI / 2.0, "{half:?}");
    }

    #[test]
    fn what_is_held_stays_under_the_pointer() {
        let flat = OrbitCamera { flatness: 1.0, ..OrbitCamera::around(Vec3::ZERO, 1.0) };
        for camera in [OrbitCamera::around(Vec3::ZERO, 1.0), flat] {
            let held = camera.right() * 0.3 + camera.up() * 0.2 + camera.forward() * 0.4;
            let before = place(&camera, held);
            let deeper = camera.at_depth_of(held);
            let offset = |camera: &OrbitCamera| (place(camera, held) - before).truncate().length();
            assert!(offset(&deeper) < 1e-5, "another target, the same image");
            // An image of height 1 spans 2 in normalised device coordinates.
            let right = before.x * 0.5;
            let down = before.y * 0.5;
            assert!(offset(&deeper.zoomed(0.1, right, down)) < 1e-4);
            let moved = place(&deeper.panned(0.1, 0.05), held) - before;
            assert!((moved.x - 0.2).abs() < 1e-4 && (moved.y - 0.1).abs() < 1e-4, "{moved}");
            let turned = deeper.turned_by(0.1, 0.1);
            assert!(turned.camera(2.0).eye.y > deeper.camera(2.0).eye.y, "the top comes down");
        }
        assert_eq!(flat.zoomed(0.0, 0.0, 0.0).height_m, LEAST_HEIGHT_M);
        let camera = flat.turned_to(CubeView::ISOMETRIC, 1.0).camera(2.0);
        let orbit = OrbitCamera::of_camera(&camera, Vec3::ZERO);
        assert!((orbit.camera(0.5).eye - camera.eye).length() < 1e-5);
        assert!((orbit.forward() - camera.forward).length() < 1e-6);
    }

    /// Returns the place of a point in the image, in normalised device coordinates.
    fn place(camera: &OrbitCamera, point: Vec3) -> Vec3 {
        CullView::new(&camera.camera(2.0), [1000, 1000], 8).view_proj.project_point3(point)
    }

    #[test]
    fn the_change_to_orthographic_is_smooth_and_keeps_the_target_plane() {
        let camera = OrbitCamera::around(Vec3::new(3.0, 1.0, -2.0), 1.0);
        let right = Vec3::new(camera.yaw_rad.cos(), 0.0, -camera.yaw_rad.sin());
        let in_plane = camera.target + right * 0.5;
        let behind = in_plane + camera.forward() * 0.8;
        let expected = place(&OrbitCamera { flatness: 1.0, ..camera }, in_plane);
        let mut last = place(&camera, behind);
        for step in 1..=1000 {
            let flatness = step as f32 / 1000.0;
            let now = OrbitCamera { flatness, ..camera };
            let kept = place(&now, in_plane);
            let moved = place(&now, behind);
            // Half a pixel in an image of a thousand pixels.
            assert!((kept - expected).truncate().length() < 1e-3, "{flatness}: {kept}");
            assert!((moved - last).truncate().length() < 2e-3, "{flatness}: {moved} after {last}");
            assert!(moved.z > 0.0 && moved.z < 1.0, "{flatness}: cut off at {moved}");
            last = moved;
        }
    }
}
