//! The block of a flare: the pixels whose samples are counted, at the depth of its light.

use cull::{CullView, ProjectionKind, trigonometry};
use glam::{Vec2, Vec4, Vec4Swizzles};
use occlusion::Rect;
use scene::{FlarePlace, LensFlare};

use crate::passes::FlareBlockRow;

/// A square of whole pixels around the middle of a light, at the light's depth.
///
/// Its sides lie on the edges of pixels, so it has the same samples on every device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlareBlock {
    /// The upper left corner in the image of the view (pixels). It may be outside of the image for
    /// a light at the edge.
    pub origin: [i32; 2],
    /// The length of a side (pixels), [`FlareBlock::LEAST_SIDE`] to [`FlareBlock::LARGEST_SIDE`].
    pub side: u32,
    /// The stored depth of the near side of the light: 0 for a sun.
    pub depth: f32,
    /// The middle of the light, in normalised device coordinates.
    pub middle: Vec2,
}

/// The middle of a light in clip space, the stored depth of its near side, and its radius (pixels).
struct SeenLight {
    clip: Vec4,
    depth: f32,
    radius_pixels: f32,
}

impl FlareBlock {
    /// The side of the block of a distant light: few samples, yet enough for a fraction between all
    /// and nothing.
    pub const LEAST_SIDE: u32 = 3;
    /// The side of the block of a near light, with enough samples for a smooth fraction.
    pub const LARGEST_SIDE: u32 = 24;

    /// Returns the block of a flare in a view with reversed depth. `None` if the block is outside
    /// of the image, and for a light that the near plane cuts or that is behind the eye.
    #[must_use]
    pub fn of(flare: &LensFlare, view: &CullView) -> Option<Self> {
        let light = match flare.place {
            FlarePlace::At(_) => SeenLight::lamp(flare, view),
            FlarePlace::Towards(_) => SeenLight::sun(flare, view),
        }?;
        let middle = light.clip.xy() / light.clip.w;
        let in_pixels = (middle + 1.0) * 0.5 * Vec2::from(view.size.map(|side| side as f32));
        if !middle.is_finite() || in_pixels.abs().max_element() > 1.0e6 {
            return None;
        }
        let least = Self::LEAST_SIDE;
        let largest = Self::LARGEST_SIDE;
        let side = (2.0 * light.radius_pixels).round().clamp(least as f32, largest as f32) as u32;
        let corner = (in_pixels - side as f32 * 0.5).round();
        let origin = [corner.x as i32, corner.y as i32];
        let block = Self { origin, side, depth: light.depth, middle };
        block.area(view.size).map(|_| block)
    }

    /// Returns the pixels of the block in an image of `size` pixels; `None` if there are none.
    #[must_use]
    pub fn area(&self, size: [u32; 2]) -> Option<Rect> {
        let sides = [0, 1].map(|axis| {
            let end = i64::from(self.origin[axis]) + i64::from(self.side);
            let start = self.origin[axis].max(0).cast_unsigned();
            let end = u32::try_from(end.clamp(0, i64::from(size[axis]))).unwrap_or_default();
            (start, end.saturating_sub(start))
        });
        let [(x, width), (y, height)] = sides;
        (width > 0 && height > 0).then_some(Rect { origin: [x, y], size: [width, height] })
    }

    /// Returns the block as the shaders read it, for an image at `place` in its target (pixels).
    /// The block's pixels follow `first_cell` pixels of other blocks.
    pub(super) fn row(&self, place: [u32; 2], first_cell: u32) -> FlareBlockRow {
        let Self { origin: low, side, depth, .. } = *self;
        let target_low = [0, 1].map(|axis| low[axis].saturating_add_unsigned(place[axis]));
        FlareBlockRow { low, target_low, side, depth, first_cell, unused: 0 }
    }

    /// Returns the number of pixels in the block, inside and outside of the image.
    #[must_use]
    pub fn pixels(&self) -> u32 {
        self.side * self.side
    }
}

impl SeenLight {
    /// Returns a light at a point, with the distance of its near side.
    fn lamp(flare: &LensFlare, view: &CullView) -> Option<Self> {
        let FlarePlace::At(point) = flare.place else { return None };
        let rays = &view.rays;
        let depth_m = rays.depth_m(point);
        let front_m = depth_m - flare.radius;
        if !(front_m > rays.near && front_m > 0.0) {
            return None;
        }
        let clip = view.clip(point).as_vec4();
        let [constant, scaled] = rays.depth;
        let depth = match rays.kind {
            ProjectionKind::Perspective => constant + scaled / front_m,
            ProjectionKind::Orthographic => constant + scaled * front_m,
        };
        let radius_pixels = flare.radius / (pixel_m(view) * rays.kind.w(depth_m));
        (0.0..=1.0).contains(&depth).then_some(Self { clip, depth, radius_pixels })
    }

    /// Returns a light that is infinitely far away. It is never seen by the parallel rays of an
    /// orthographic view.
    fn sun(flare: &LensFlare, view: &CullView) -> Option<Self> {
        let FlarePlace::Towards(direction) = flare.place else { return None };
        let clip = view.view_proj * direction.normalize_or_zero().extend(0.0);
        if view.rays.kind != ProjectionKind::Perspective || clip.w <= 1.0e-6 {
            return None;
        }
        let radius_pixels = trigonometry::tan(flare.radius.min(1.0)) / pixel_m(view);
        Some(Self { clip, depth: 0.0, radius_pixels })
    }
}

/// Returns the height of a pixel where w is 1 (metres).
fn pixel_m(view: &CullView) -> f32 {
    2.0 * view.rays.down.length() / view.size[1] as f32
}

#[cfg(test)]
mod tests {
    use cull::{Camera, Projection};
    use glam::Vec3;

    use super::*;

    fn camera() -> Camera {
        Camera {
            eye: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(std::f32::consts::FRAC_PI_2),
            near: 0.5,
        }
    }

    fn view() -> CullView {
        CullView::new(&camera(), [200, 100], 8)
    }

    fn flare(place: FlarePlace, radius: f32) -> LensFlare {
        LensFlare { place, radius, colour: [1.0; 3], glow: 0.2, ghosts: 1.0 }
    }

    fn lamp(point: Vec3) -> LensFlare {
        flare(FlarePlace::At(point), 0.5)
    }

    #[test]
    fn nearer_lights_have_larger_blocks_within_bounds() {
        // A metre covers 50 pixels at a distance of one metre.
        for (z, side) in [(-1.5, 24), (-5.0, 10), (-10.0, 5), (-100.0, 3), (-1.0e5, 3)] {
            let block = FlareBlock::of(&lamp(Vec3::Z * z), &view()).unwrap();
            assert_eq!(block.side, side, "{z}");
            let middle = [100 - side / 2, 50 - side / 2].map(|at| at as i32);
            let off = [0, 1].map(|axis| (block.origin[axis] - middle[axis]).abs());
            assert!(off[0] <= 1 && off[1] <= 1, "{z}: {block:?}");
            assert_eq!(block.pixels(), side * side);
            // The stored depth is the near plane divided by the view depth.
            let expected = 0.5 / (-z - 0.5);
            assert!((block.depth - expected).abs() <= expected * 1.0e-5, "{z}: {block:?}");
        }
    }

    #[test]
    fn suns_are_behind_all_things() {
        let sun = |direction| FlareBlock::of(&flare(FlarePlace::Towards(direction), 0.1), &view());
        let block = sun(Vec3::new(0.0, 0.0, -7.0)).unwrap();
        assert_eq!((block.depth, block.side), (0.0, 10));
        assert!(block.middle.length() < 1.0e-6);
        let aside = sun(Vec3::new(0.5, 0.0, -1.0)).unwrap();
        assert!((aside.middle - Vec2::new(0.25, 0.0)).length() < 1.0e-5, "{aside:?}");
        assert_eq!(sun(Vec3::Z), None);
        assert_eq!(sun(Vec3::X), None);
        let projection = Projection::Orthographic { height: 10.0, far: 100.0 };
        let parallel = CullView::new(&Camera { projection, ..camera() }, [200, 100], 8);
        let sun = flare(FlarePlace::Towards(Vec3::NEG_Z), 0.1);
        assert_eq!(FlareBlock::of(&sun, &parallel), None);
        let block = FlareBlock::of(&lamp(Vec3::new(0.0, 0.0, -50.5)), &parallel).unwrap();
        assert_eq!(block.side, 10);
        assert!((block.depth - 0.5).abs() < 0.01, "{block:?}");
    }

    #[test]
    fn blocks_are_cut_at_the_edge_and_end_there() {
        // The right edge of the image is at x = 2 z.
        let at = |x: f32| FlareBlock::of(&lamp(Vec3::new(x, 0.0, -10.0)), &view());
        let whole = at(19.0).unwrap();
        assert_eq!(whole.area([200, 100]).unwrap().size, [5, 5]);
        let cut = at(20.0).unwrap().area([200, 100]).unwrap();
        assert!((1..5).contains(&cut.size[0]) && cut.size[1] == 5, "{cut:?}");
        assert_eq!(cut.origin[0] + cut.size[0], 200);
        let left = at(-20.0).unwrap();
        assert!(left.origin[0] < 0);
        assert_eq!(left.area([200, 100]).unwrap().origin[0], 0);
        assert_eq!(at(21.0), None);
        assert_eq!(at(f32::MAX), None);
    }

    #[test]
    fn lights_behind_the_eye_or_at_the_near_plane_have_none() {
        for z in [5.0, 0.0, -0.5, -0.9] {
            assert_eq!(FlareBlock::of(&lamp(Vec3::Z * z), &view()), None, "{z}");
        }
        assert!(FlareBlock::of(&lamp(Vec3::Z * -1.1), &view()).is_some());
    }
}
