//! The part of a view that a light can reach: its shadows matter nowhere else.

use cull::{Aabb, View};
use glam::Vec3;

use crate::light::LightShape;

/// Pixels around a light's reach, against the rounding of what is drawn there.
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
    /// Returns a whole view.
    #[must_use]
    pub fn whole(view: &View) -> Self {
        Self { origin: [0, 0], size: view.size.map(|side| side.max(1)) }
    }

    /// Returns the part of a view in which all lies that a light reaches and the view shows: the
    /// whole view for a sun, and where the light reaches behind the near plane.
    #[must_use]
    pub fn of(view: &View, shape: &LightShape) -> Self {
        let around = shape.reach().map(|(centre, reach_m)| {
            Aabb::new(centre - Vec3::splat(reach_m), centre + Vec3::splat(reach_m))
        });
        around.and_then(|around| Self::around(view, &around)).unwrap_or(Self::whole(view))
    }

    fn around(view: &View, bounds: &Aabb) -> Option<Self> {
        let matrix = view.view_proj.as_dmat4();
        let nearest = f64::from(view.rays.kind.w(view.rays.near));
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in bounds.corners() {
            let clip = matrix * corner.as_dvec3().extend(1.0);
            // Numbers that are none are not in front of anything.
            if !(clip.w >= nearest && clip.w > 0.0) {
                return None;
            }
            for (side, place) in [clip.x, clip.y].into_iter().enumerate() {
                let pixels = f64::from(*view.size.get(side)?);
                let pixel = (place / clip.w + 1.0) * 0.5 * pixels;
                if let (Some(low), Some(high)) = (low.get_mut(side), high.get_mut(side)) {
                    (*low, *high) = (low.min(pixel), high.max(pixel));
                }
            }
        }
        let mut area = Self::whole(view);
        let sides = area.origin.iter_mut().zip(&mut area.size).zip(low.into_iter().zip(high));
        for ((origin, size), (low, high)) in sides {
            let pixels = f64::from(*size);
            let low = (low - MARGIN_PIXELS).floor().clamp(0.0, pixels - 1.0);
            let high = (high + MARGIN_PIXELS).ceil().clamp(low + 1.0, pixels);
            (*origin, *size) = (low as u32, (high - low) as u32);
        }
        Some(area)
    }
}

#[cfg(test)]
mod tests {
    use cull::{Camera, Projection};
    use glam::{Vec4Swizzles, vec3};

    use super::*;

    fn view() -> View {
        let projection = Projection::perspective(1.0);
        let (eye, up) = (vec3(0.0, 2.0, 10.0), Vec3::Y);
        let camera = Camera { eye, forward: vec3(0.1, -0.2, -1.0), up, projection, near: 0.1 };
        View::new(&camera, [160, 90], 8)
    }

    #[test]
    fn all_that_a_lamp_reaches_lies_in_its_area() {
        let view = view();
        let mut smaller = 0;
        for number in 0..200 {
            let [x, y, z] = [7, 11, 13].map(|step| (number * step % 29) as f32 - 14.0);
            let (position, reach_m) = (vec3(x, 0.3 * y, z), 0.5 + (number % 5) as f32);
            let area = LitArea::of(&view, &LightShape::Point { position, reach_m });
            assert!((0..2).all(|side| area.size[side] > 0
                && area.origin[side] + area.size[side] <= view.size[side]));
            smaller += u32::from(area != LitArea::whole(&view));
            for step in 0..300 {
                let turn = glam::Quat::from_euler(
                    glam::EulerRot::XYZ,
                    step as f32,
                    step as f32 * 0.7,
                    0.0,
                );
                let point = position + turn * Vec3::X * reach_m;
                let clip = view.view_proj * point.extend(1.0);
                let pixel = (clip.xy() / clip.w + 1.0) * 0.5 * glam::vec2(160.0, 90.0);
                let is_shown = clip.w > 0.1
                    && pixel.cmpge(glam::Vec2::ZERO).all()
                    && pixel.cmplt(glam::vec2(160.0, 90.0)).all();
                let is_in = |side: usize| {
                    let place = pixel[side] as u32;
                    (area.origin[side]..area.origin[side] + area.size[side]).contains(&place)
                };
                assert!(!is_shown || (is_in(0) && is_in(1)), "{number}: {pixel} not in {area:?}");
            }
        }
        assert!(smaller > 50, "{smaller} are smaller than the view");
    }

    #[test]
    fn suns_lamps_around_the_eye_and_odd_numbers_have_the_whole_view() {
        let view = view();
        let eye = view.rays.origin;
        for shape in [
            LightShape::Sun { towards: Vec3::Y },
            LightShape::Point { position: eye, reach_m: 1.0 },
            LightShape::Point { position: Vec3::NAN, reach_m: 1.0 },
        ] {
            assert_eq!(LitArea::of(&view, &shape), LitArea::whole(&view), "{shape:?}");
        }
    }
}
