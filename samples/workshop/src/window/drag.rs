//! Dragging: the object that a press holds, and its place when the pointer has moved.

use antumbra::cull::{Aabb, CullView};
use antumbra::glam::{Vec2, Vec3};
use antumbra::render::PointedSurface;

use super::context::InteractionContext;
use super::tools::{AxisPlane, MM, Tools, handle_of};
use crate::document::Lid;
use crate::hinge::rotation;

/// The largest angle by which the lid follows the pointer in one frame, in either direction, in
/// radians.
const REACH_RAD: f32 = 0.7;

/// The number of angles that are tried in this range.
const STEPS: u16 = 24;

/// The number of times that the search is refined.
const REFINEMENTS: u32 = 4;

/// The least length of a plane's axis in the image, relative to its length seen from the side. A
/// shorter axis is seen end on.
const LEAST_SHARE: f32 = 0.05;

/// The object that the pointer holds while a button is pressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drag {
    /// The model turns about the pressed point.
    Turn,
    /// The model moves in the image plane.
    Move,
    /// The lid turns about its hinge.
    Lid(LidGrab),
    /// A section plane moves along its axis.
    Plane(PlaneGrab),
}

impl Drag {
    /// Returns the drag that a press begins, by the surface that a frame showed at its place.
    pub fn on(
        surface: &Option<PointedSurface>,
        tools: &Tools,
        seen: &InteractionContext<'_>,
    ) -> Self {
        // The lid does not turn while parts are apart.
        let lid = seen.document.lid.filter(|_| tools.gap_mm == 0.0);
        let (Some(surface), Some(lid)) = (surface, lid) else { return Self::Turn };
        let objects = seen.document.parts.objects_of(lid.group);
        if objects.binary_search(&surface.object).is_err() {
            return Self::Turn;
        }
        Self::Lid(LidGrab::new(lid, seen.document.lid_rad(), surface.point.as_vec3()))
    }
}

/// A held point of the lid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LidGrab {
    lid: Lid,
    /// The point at the hinge's angle 0.
    point: Vec3,
}

impl LidGrab {
    /// Holds a point of a lid that is at an angle.
    pub fn new(lid: Lid, angle_rad: f32, point: Vec3) -> Self {
        Self { lid, point: rotation(&lid.hinge, angle_rad).inverse().transform_point3(point) }
    }

    /// Returns the angle near `angle_rad` at which the point is nearest to a place of the image, in
    /// radians.
    pub fn angle_at(&self, view: &CullView, angle_rad: f32, place: Vec2) -> f32 {
        let hinge = &self.lid.hinge;
        let apart = |angle_rad: f32| {
            let point = rotation(hinge, angle_rad).transform_point3(self.point);
            place_of(view, point).map_or(f32::INFINITY, |found| found.distance(place))
        };
        let mut best = angle_rad.clamp(hinge.shut_rad, hinge.open_rad);
        let mut reach_rad = REACH_RAD;
        for _ in 0..REFINEMENTS {
            let least = (best - reach_rad).max(hinge.shut_rad);
            let most = (best + reach_rad).min(hinge.open_rad);
            let step = (most - least) / f32::from(STEPS);
            let tried = (0..=STEPS).map(|index| least + f32::from(index) * step);
            let tried = std::iter::once(best).chain(tried);
            best = tried.min_by(|a, b| apart(*a).total_cmp(&apart(*b))).unwrap_or(best);
            reach_rad = step;
        }
        best
    }

    /// Returns an angle of the hinge in degrees from closed.
    pub fn degrees(&self, angle_rad: f32) -> f32 {
        (angle_rad - self.lid.hinge.closed_rad).to_degrees()
    }
}

/// A held section plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneGrab {
    /// The index of its axis.
    pub axis: usize,
    /// The plane's position at the press, in millimetres.
    from_mm: f32,
    /// The place of the press in the image.
    pressed_at: Vec2,
    /// The movement of its handle in the image per metre along the axis, in pixels.
    pixels_per_m: Vec2,
}

impl PlaneGrab {
    /// Holds a plane; `None` if its axis is seen end on.
    pub fn new(
        view: &CullView,
        bounds: &Aabb,
        axis: usize,
        plane: &AxisPlane,
        pressed_at: Vec2,
    ) -> Option<Self> {
        let handle = handle_of(bounds, axis, plane);
        let step_m = (bounds.max - bounds.min).length().max(1.0e-3) * 0.01;
        let moved = handle + Vec3::AXES[axis] * step_m;
        let pixels_per_m = (place_of(view, moved)? - place_of(view, handle)?) / step_m;
        let sideways = view.rays.along(Vec2::ZERO).normalize_or_zero().any_orthonormal_vector();
        let beside = handle + sideways * step_m;
        let usual = (place_of(view, beside)? - place_of(view, handle)?).length() / step_m;
        let is_seen = pixels_per_m.length() > usual * LEAST_SHARE;
        is_seen.then_some(Self { axis, from_mm: plane.place_mm, pressed_at, pixels_per_m })
    }

    /// Returns the position of the plane for a place of the pointer, within the model, in
    /// millimetres.
    pub fn place_mm(&self, bounds: &Aabb, pointer: Vec2) -> f32 {
        let along = (pointer - self.pressed_at).dot(self.pixels_per_m);
        let moved_m = along / self.pixels_per_m.length_squared();
        let least_mm = bounds.min[self.axis] * MM;
        let most_mm = bounds.max[self.axis] * MM;
        (self.from_mm + moved_m * MM).clamp(least_mm, most_mm.max(least_mm))
    }
}

/// Returns the place of a point in the image, in pixels from the upper left; `None` behind the eye.
pub fn place_of(view: &CullView, point: Vec3) -> Option<Vec2> {
    let clip = view.clip(point);
    let [width, height] = view.size.map(|side| side as f32);
    let place = (clip.truncate().truncate() / clip.w).as_vec2();
    (clip.w > 0.0).then(|| (place + 1.0) * 0.5 * Vec2::new(width, height))
}

#[cfg(test)]
mod tests {
    use scenes::{Hinge, PartId};

    use super::*;
    use crate::orbit::{CubeView, OrbitCamera};

    fn view(name: &str) -> CullView {
        let camera = OrbitCamera::around(Vec3::ZERO, 1.0);
        let camera = camera.turned_to(CubeView::named(name).unwrap(), 1.0);
        CullView::new(&camera.camera(2.0), [800, 600], 8)
    }

    #[test]
    fn the_lid_follows_the_point_that_is_held() {
        let hinge = Hinge {
            point: Vec3::ZERO,
            axis: Vec3::NEG_X,
            shut_rad: 0.0,
            closed_rad: 0.0,
            open_rad: 3.0,
        };
        let lid = Lid { group: PartId(0), hinge };
        let held = Vec3::new(0.1, 0.0, 0.5);
        // The point is in front of the hinge, and rises when the lid opens.
        let grab = LidGrab::new(lid, 0.5, rotation(&hinge, 0.5).transform_point3(held));
        for name in ["right", "iso", "top-left"] {
            let view = view(name);
            for angle_rad in [0.2_f32, 0.9] {
                let there = rotation(&hinge, angle_rad).transform_point3(held);
                let place = place_of(&view, there).unwrap();
                let found = grab.angle_at(&view, 0.5, place);
                assert!((found - angle_rad).abs() < 2e-3, "{name}: {found} for {angle_rad}");
            }
        }
        let below = place_of(&view("right"), Vec3::new(0.1, -0.5, 0.5)).unwrap();
        assert_eq!(grab.angle_at(&view("right"), 0.1, below), 0.0);
        assert!((grab.degrees(0.5) - 28.648).abs() < 1e-3);
    }

    #[test]
    fn a_plane_follows_the_pointer_along_its_axis() {
        let bounds = Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE };
        let plane = AxisPlane { is_on: true, place_mm: 200.0, ..AxisPlane::default() };
        let front = view("front");
        let pressed_at = place_of(&front, handle_of(&bounds, 0, &plane)).unwrap();
        let grab = PlaneGrab::new(&front, &bounds, 0, &plane, pressed_at).unwrap();
        assert_eq!(grab.place_mm(&bounds, pressed_at), 200.0);
        let there = place_of(&front, Vec3::new(0.6, 0.0, 0.0)).unwrap();
        assert!((grab.place_mm(&bounds, there) - 600.0).abs() < 2.0);
        assert_eq!(grab.place_mm(&bounds, pressed_at + Vec2::X * 9999.0), 1000.0);
        assert_eq!(PlaneGrab::new(&front, &bounds, 2, &plane, pressed_at), None, "end on");
    }
}
