//! The margin by which a proxy must be larger than its node, so that no sample is lost to rounding.
//!
//! A rasteriser moves every vertex to a grid of `2^-b` pixels (`b` = `subPixelPrecisionBits`)
//! before it looks which samples a triangle covers. A fragment of the object at sample `s`
//! therefore stands for a point `p` of the object whose true projection is up to `e = sqrt(2) *
//! 2^-b` pixels away from `s`, and it carries the depth of `p`: the vertex shader must see to that,
//! since some rasterisers take depth from the positions of the vertices before the snapping
//! ([`View::snap_steps`](crate::View::snap_steps)). In the same way the fragment of the proxy at
//! `s` stands for the point `q` of the proxy's front that the true ray up to `e` away from `s`
//! meets: that ray passes `p` in a distance of at most `2e` pixels. A shift by one pixel at view
//! depth `w` is a shift by `footprint(w) = w * 2 tan(fov_y / 2) / height` in the plane through `p`
//! parallel to the image. So when the proxy holds a ball of `2e` footprints around `p`, the ray
//! goes through a point of the proxy that is as deep as `p`, hence enters the proxy, at `q`, no
//! deeper than `p`: the proxy covers `s` and passes the depth test wherever the object does. The
//! box grown by `d` holds that ball around every point of the object, with the footprint taken at
//! the farthest corner.
//!
//! A quarter of a pixel on top pays for the rounding of the depth itself: `q` is nearer than `p` by
//! about that much of a footprint, some ten thousandths of `w`. A 32-bit depth resolves ten
//! millionths. The last term pays for coordinates far from the origin.
//!
//! Only front faces of proxies are drawn. A proxy that reaches before the near plane would lose
//! front faces to clipping, so such a box has no proxy: it counts as visible.

use glam::Vec3;

use crate::geom::bounds::Aabb;

/// Pixels added to the need of the sub-pixel grid, against rounding of depths.
const SLACK_PIXELS: f32 = 0.25;

/// Relative distance that a proxy keeps from the near plane.
const NEAR_SLACK: f32 = 1.0 / 1024.0;

/// The computation of proxies for one view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    eye: Vec3,
    forward: Vec3,
    near: f32,
    /// Size of a pixel at view depth 1 (metres).
    footprint: f32,
    /// The distance by which a proxy reaches beyond its box on the screen (pixels).
    pixels: f32,
}

impl Margin {
    /// Creates the margin of a view at `eye` along `forward` (unit length) with pixels of
    /// `footprint` metres at view depth 1, on a device that snaps vertices to `2^-sub_pixel_bits`
    /// pixels.
    #[must_use]
    pub fn new(eye: Vec3, forward: Vec3, near: f32, footprint: f32, sub_pixel_bits: u32) -> Self {
        let grid = 0.5_f32.powi(sub_pixel_bits.min(24) as i32);
        Self {
            eye,
            forward,
            near,
            footprint,
            pixels: SLACK_PIXELS + 2.0 * std::f32::consts::SQRT_2 * grid,
        }
    }

    /// Returns the distance by which a proxy reaches beyond its box on the screen (pixels).
    #[must_use]
    pub fn pixels(&self) -> f32 {
        self.pixels
    }

    /// Returns the distance by which a proxy reaches beyond a box at view depth 1 (metres),
    /// rounding apart.
    #[must_use]
    pub fn metres_at_depth_1(&self) -> f32 {
        self.pixels * self.footprint
    }

    /// Returns the box to test in place of `bounds`, or `None` if it must count as visible, because
    /// the eye is inside or some of the proxy is nearer than the near plane. An
    /// [empty](Aabb::is_empty) box is never tested: it is in no frustum.
    #[must_use]
    pub fn proxy(&self, bounds: &Aabb) -> Option<Aabb> {
        let depth = self.forward.dot(bounds.centre() - self.eye);
        let forward = self.forward.abs();
        let reach = forward.dot(bounds.half_extent());
        let farthest = (depth + reach).max(self.near);
        let slack = rounding(bounds, self.eye);
        let distance = self.pixels * self.footprint * farthest + slack;
        let nearest = depth - reach - distance * forward.element_sum() - slack;
        // A NaN fails the comparison and makes the box visible.
        (nearest > self.near * (1.0 + NEAR_SLACK)).then(|| bounds.enlarged(distance))
    }
}

/// Returns a bound on the rounding error of single precision where `bounds` is seen from `eye`
/// (metres).
pub(crate) fn rounding(bounds: &Aabb, eye: Vec3) -> f32 {
    16.0 * f32::EPSILON * bounds.largest_coordinate().max(eye.abs().max_element())
}
