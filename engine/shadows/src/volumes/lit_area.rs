//! The part of a view that a light can reach: shadow volumes need to be counted only in it.

use cull::{Aabb, CullView};
use glam::{DVec2, DVec4, Vec4Swizzles};

use super::mesh::rounding;
use crate::light::LightShape;

/// Pixels around a light's reach, against rounding when it is drawn.
const MARGIN_PIXELS: f64 = 2.0;

/// A rectangle of pixels of a view, from its upper left corner on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LitArea {
    /// The upper left pixel.
    pub origin: [u32; 2],
    /// The width and height, at least 1.
    pub size: [u32; 2],
}

impl LitArea {
    /// Returns the area of a whole view.
    #[must_use]
    pub fn whole(view: &CullView) -> Self {
        Self { origin: [0, 0], size: view.size.map(|side| side.max(1)) }
    }

    /// Returns an area of a view that holds all visible points of `receivers` that a light reaches;
    /// `None` if there are none.
    #[must_use]
    pub fn of(view: &CullView, shape: &LightShape, receivers: &Aabb) -> Option<Self> {
        let lit = shape.reached(receivers);
        if lit.is_empty() {
            return None;
        }
        Self::around(view, &lit.enlarged(rounding(&lit, view.rays.origin)))
    }

    /// Returns the part of a view that shows a box.
    fn around(view: &CullView, bounds: &Aabb) -> Option<Self> {
        let corners = bounds.corners().map(|corner| view.clip(corner));
        if !corners.iter().all(|corner| corner.is_finite()) {
            return Some(Self::whole(view));
        }
        let nearest = f64::from(view.rays.kind.w(view.rays.near));
        let mut low = DVec2::INFINITY;
        let mut high = DVec2::NEG_INFINITY;
        let pixels = DVec2::from(view.size.map(f64::from));
        for point in before(&corners, nearest.max(f64::MIN_POSITIVE)) {
            let pixel = (point.xy() / point.w + 1.0) * 0.5 * pixels;
            (low, high) = (low.min(pixel), high.max(pixel));
        }
        (low, high) = ((low - MARGIN_PIXELS).floor(), (high + MARGIN_PIXELS).ceil());
        // Also true if no point is beyond the near plane.
        if low.cmpge(pixels).any() || high.cmple(DVec2::ZERO).any() {
            return None;
        }
        let low = low.max(DVec2::ZERO);
        let high = high.min(pixels);
        let size = high - low;
        let [origin, size] = [low, size].map(|corner| corner.to_array().map(|side| side as u32));
        Some(Self { origin, size })
    }
}

/// Returns the corners of the part of a box whose clip coordinate w is at least `nearest`, in clip
/// space.
fn before(corners: &[DVec4; 8], nearest: f64) -> impl Iterator<Item = DVec4> {
    let edges = (0..8_usize).flat_map(|from| [1, 2, 4].map(|axis| (from, from ^ axis)));
    edges.filter_map(move |(from, to)| {
        let from = corners.get(from)?;
        let to = corners.get(to)?;
        let beyond = from.w - nearest;
        if beyond >= 0.0 {
            return Some(*from);
        }
        (to.w > nearest).then(|| from.lerp(*to, beyond / (from.w - to.w)))
    })
}

#[cfg(test)]
mod tests {
    use cull::{Camera, Projection};
    use glam::{EulerRot, Quat, Vec2, Vec3, vec2, vec3};

    use super::*;

    const SIZE: [u32; 2] = [160, 90];
    const EVERYTHING: Aabb = Aabb::new(Vec3::splat(-1e3), Vec3::splat(1e3));

    fn view() -> CullView {
        let projection = Projection::perspective(1.0);
        let eye = vec3(0.0, 2.0, 10.0);
        let up = Vec3::Y;
        let camera = Camera { eye, forward: vec3(0.1, -0.2, -1.0), up, projection, near: 0.1 };
        CullView::new(&camera, SIZE, 8)
    }

    /// Counts the points that are lit and visible, and checks that each of them is in the area.
    fn shown(view: &CullView, shape: &LightShape, receivers: &Aabb) -> usize {
        let (position, reach_m) = shape.reach().unwrap();
        let area = LitArea::of(view, shape, receivers);
        let mut count = 0;
        for step in 0..900 {
            let [x, y, z] = [0.0, 0.7, 0.37].map(|turns| turns * step as f32);
            let turn = Quat::from_euler(EulerRot::XYZ, step as f32, y, z + x);
            let away = turn * Vec3::X * (step % 3 + 1) as f32 / 3.0;
            let point = position + away * reach_m;
            let is_lit = match *shape {
                LightShape::Spot { direction, outer_rad, .. } => {
                    away.angle_between(direction) < outer_rad
                }
                _ => true,
            };
            let clip = view.view_proj * point.extend(1.0);
            let pixel = (clip.xy() / clip.w + 1.0) * 0.5 * vec2(160.0, 90.0);
            let is_shown = clip.w > view.rays.near
                && pixel.cmpge(Vec2::ZERO).all()
                && pixel.cmplt(vec2(160.0, 90.0)).all();
            if !is_lit || !is_shown || !receivers.contains_point(point) {
                continue;
            }
            count += 1;
            let area = area.unwrap_or_else(|| panic!("{shape:?}: {pixel} is shown"));
            let is_in = |side: usize| {
                let place = pixel[side] as u32;
                (area.origin[side]..area.origin[side] + area.size[side]).contains(&place)
            };
            assert!(is_in(0) && is_in(1), "{shape:?}: {pixel} not in {area:?}");
        }
        count
    }

    #[test]
    fn all_that_lamps_reach_lies_in_their_areas() {
        let view = view();
        let mut smaller = 0;
        let mut none = 0;
        let mut points = 0;
        for number in 0..400 {
            let [x, y, z] = [7, 11, 13].map(|step| (number * step % 29) as f32 - 14.0);
            let position = vec3(x, 0.3 * y, z);
            let reach_m = 0.5 + (number % 7) as f32;
            let direction = vec3(y, -4.0, x).normalize();
            let outer_rad = 0.2 + 0.4 * (number % 5) as f32;
            let shape = match number % 2 {
                0 => LightShape::Point { position, reach_m },
                _ => LightShape::Spot { position, direction, outer_rad, reach_m },
            };
            for receivers in [EVERYTHING, Aabb::new(vec3(-9.0, 0.0, -9.0), vec3(9.0, 2.0, 14.0))] {
                points += shown(&view, &shape, &receivers);
                let area = LitArea::of(&view, &shape, &receivers);
                none += u32::from(area.is_none());
                let Some(LitArea { origin, size }) = area else { continue };
                let is_inside = |side| size[side] > 0 && origin[side] + size[side] <= SIZE[side];
                assert!((0..2).all(is_inside), "{area:?}");
                smaller += u32::from(size != SIZE);
            }
        }
        assert!(smaller > 300 && none > 100 && points > 10_000, "{smaller}, {none}, {points}");
    }

    #[test]
    fn a_street_lamp_right_before_the_eye_has_the_pavement_under_it() {
        let view = view();
        let position = vec3(0.5, 6.0, 2.0);
        let direction = Vec3::NEG_Y;
        let shape = LightShape::Spot { position, direction, outer_rad: 0.5, reach_m: 24.0 };
        let street = Aabb::new(vec3(-50.0, 0.0, -50.0), vec3(50.0, 3.0, 50.0));
        let pixels = |area: Option<LitArea>| area.map_or(0, |area| area.size[0] * area.size[1]);
        let of_cone = pixels(LitArea::of(&view, &shape, &street));
        let ball = LightShape::Point { position, reach_m: 24.0 };
        let of_ball = pixels(LitArea::of(&view, &ball, &EVERYTHING));
        assert_eq!(of_ball, 160 * 90);
        assert!((1..of_ball * 3 / 5).contains(&of_cone), "{of_cone}");
    }

    #[test]
    fn a_spot_wider_than_a_half_lights_what_is_behind_it() {
        let view = view();
        let receivers = Aabb::new(vec3(-9.0, 0.0, -9.0), vec3(9.0, 2.0, 9.0));
        for outer_rad in [1.58, 2.0, 3.0] {
            let position = vec3(0.0, 4.0, 0.0);
            let direction = Vec3::Y;
            let shape = LightShape::Spot { position, direction, outer_rad, reach_m: 20.0 };
            assert!(LitArea::of(&view, &shape, &receivers).is_some(), "{outer_rad}");
            shown(&view, &shape, &receivers);
        }
        let position = vec3(0.0, 4.0, 0.0);
        let direction = Vec3::Y;
        let narrow = LightShape::Spot { position, direction, outer_rad: 1.5, reach_m: 20.0 };
        assert_eq!(LitArea::of(&view, &narrow, &receivers), None, "all is behind it");
    }

    #[test]
    fn suns_lamps_around_the_eye_and_odd_boxes_have_the_whole_view() {
        let view = view();
        let at_eye = LightShape::Point { position: view.rays.origin, reach_m: 1.0 };
        let sun = LightShape::Sun { towards: Vec3::Y };
        for (shape, receivers) in [
            (sun, EVERYTHING),
            (at_eye, EVERYTHING),
            (sun, Aabb::new(Vec3::NEG_INFINITY, Vec3::INFINITY)),
        ] {
            let area = LitArea::of(&view, &shape, &receivers);
            assert_eq!(area, Some(LitArea::whole(&view)), "{shape:?}");
        }
        let behind = Aabb::new(vec3(-5.0, 0.0, 12.0), vec3(5.0, 5.0, 50.0));
        for receivers in [Aabb::EMPTY, behind] {
            assert_eq!(LitArea::of(&view, &sun, &receivers), None);
        }
    }
}
