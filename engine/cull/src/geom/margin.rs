//! The margin by which a proxy must be larger than its node, so that rounding loses no sample.
//!
//! A rasteriser moves every vertex to a grid of `2^-b` pixels (`b` = `subPixelPrecisionBits`)
//! before it finds the samples that a triangle covers. A fragment of the object at sample `s`
//! therefore stands for a point `p` of the object whose true projection is up to `e = sqrt(2) *
//! 2^-b` pixels away from `s`, and it carries the depth of `p`. The vertex shader must ensure this,
//! since some rasterisers take depth from the positions of the vertices before snapping
//! ([`CullView::snap_steps`](crate::CullView::snap_steps)). Similarly, the fragment of the proxy at
//! `s` stands for a point `q` of the proxy's front: the point where a true ray up to `e` away from
//! `s` meets the front. This ray passes `p` at a distance of at most `2e` pixels.
//!
//! A shift by one pixel is a shift in the plane through `p` parallel to the image, by at most
//! `footprint(w) = w * pixel`: `pixel` is the longest such shift where the clip coordinate `w` is 1
//! (metres). In perspective `w` is the view depth; in an orthographic view it is always 1. A centre
//! of projection that is not in the middle, as with a jitter, does not change shifts in this plane.
//! So if the proxy contains a ball of `2e` footprints around `p`, the ray passes through a point of
//! the proxy that is as deep as `p`. Hence it enters the proxy at a `q` that is no deeper than `p`:
//! the proxy covers `s` and passes the depth test wherever the object does. The box grown by `d`
//! contains this ball around every point of the object, with the footprint taken at the farthest
//! corner.
//!
//! # Several samples per pixel
//! `s` is any position in a pixel, not only its middle. Coverage and depth of each sample belong to
//! its own position, for the object and for the proxy, and a test passes if one sample passes. So
//! the proof and the margin are the same with several samples per pixel. A tester that does not
//! rasterise has one depth per pixel, the farthest of its samples, and assumes the sample anywhere
//! in the pixel: `compute_test.comp` reaches half a pixel farther, and the depth pyramid covers
//! whole pixels.
//!
//! # Rounding
//! An additional quarter of a pixel covers the rounding of a reversed, infinite depth: `q` is
//! nearer than `p` by about a quarter of a footprint, some ten thousandths of `w`, and a 32-bit
//! depth resolves ten millionths.
//!
//! The last term covers coordinates far from the origin of the world, by the largest coordinate `C`
//! of the box and of the eye. Objects and proxies have different matrices. Shaders of objects
//! multiply [`CullView::from_anchor`](crate::CullView::from_anchor) with positions relative to the
//! anchor, which lies at the eye or near it. Shaders of proxies multiply
//! [`CullView::proxy_view_proj`](crate::CullView::proxy_view_proj) with coordinates of the world.
//! The two matrices differ only in the last column, the translation. It is almost exact in the
//! first matrix and rounded in the second, and this error does not cancel: the errors of both paths
//! add up.
//!
//! An error of clip x, y and w shifts a vertex along the rows of the matrix, by a distance that
//! does not depend on the angle of view. With a reversed, infinite depth, clip z is constant and
//! the depth follows w. Let `u = eps / 2`, and for rows of unit length let `s(v)` be the sum of the
//! absolute products of the coordinates of a row and of `v`. For an eye `e`, a vertex `p` and `d =
//! p - e` the error of each row is at most
//!
//! - `5 u s(e)` from the proxy's translation: its coefficients, three products, two sums, and the
//!   product with the projection's scale. A host's matrix is right by definition;
//! - `3 u s(p) + u s(d)` from the proxy's shader: products, two sums, and the sum with the
//!   translation;
//! - `4 u s(d)` from the object's shader: the difference from the anchor, products and two sums.
//!
//! Over three orthogonal rows the vector of `s(v)` is at most 2.9 times as long as the largest
//! coordinate of `v`. So the shift is at most `12 eps C` if `d` is small compared with `C`, `26 eps
//! C` if eye and vertex lie on opposite sides of the origin, and `29 eps C` if the shader of the
//! proxy begins its sum with the translation. Three roundings add less than `eps C` each: of the
//! corners of the enlarged box, of the object's box on the CPU, and of an eye between the numbers
//! of single precision (from a host's matrix or an [`Anchor`](crate::Anchor)). The total stays
//! below `32 eps C`: a term of `16 eps C` for each of two paths. Rows that are not orthogonal have
//! a larger [`Rays::coordinate`].
//!
//! Other depths are a sum `a + b / w`, or `a + b * view depth` without perspective, and lose digits
//! to the constant `a`. No distance in the world can compensate this. So proxies are moved towards
//! the eye by a bound on this rounding, in the matrix that they are drawn with
//! ([`CullView::proxy_view_proj`](crate::CullView::proxy_view_proj)): by `|a| * 2^-19`, and by
//! `2^-19` of the share of clip z that comes from `a` times a coordinate of the eye: `16 eps` of
//! each. The shifts above cancel except for the errors of z and of `a w`. In perspective only a
//! host's matrix has such an `a`. Then the errors are `6 u a s(e) / w` in the shader of the proxy,
//! the same in the shader of an object that is drawn with this matrix, and terms relative to `d`:
//! less than `11 eps a C / w`, and some `eps a`. Rounding to a depth buffer with fewer bits keeps
//! the order of depths.
//!
//! # The near plane
//! Only front faces of proxies are drawn. A proxy that reaches before the near plane would lose
//! front faces to clipping, so such a box has no proxy and counts as visible. Clipping at a far
//! plane removes the same part of an object and of its proxy.

use glam::Vec3;

use crate::geom::bounds::Aabb;
use crate::geom::projection::DEPTH_ROUNDING;
use crate::geom::rays::{ProjectionKind, Rays};

/// The pixels added to the margin for the sub-pixel grid, against rounding of depths.
const SLACK_PIXELS: f32 = 0.25;

/// The relative distance that a proxy keeps from the near plane.
const NEAR_SLACK: f32 = 1.0 / 1024.0;

/// The computation of proxies for one view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    kind: ProjectionKind,
    origin: Vec3,
    forward: Vec3,
    near: f32,
    /// The least view depth of a proxy (metres).
    nearest: f32,
    /// The shortest and the longest shift by one pixel where w is 1 (metres).
    pixel: [f32; 2],
    /// The coordinate that bounds the rounding of the view's own numbers (metres).
    coordinate: f32,
    /// The distance by which a proxy extends beyond its box on the screen (pixels).
    pixels: f32,
}

impl Margin {
    /// Creates the margin of a view with these rays through an image of `size` pixels, on a device
    /// that snaps vertices to `2^-sub_pixel_bits` pixels.
    #[must_use]
    pub fn new(rays: &Rays, size: [u32; 2], sub_pixel_bits: u32) -> Self {
        let grid = 0.5_f32.powi(sub_pixel_bits.min(24) as i32);
        // The bias of depths must not move a proxy before the near plane.
        let [constant, slope] = rays.depth;
        let nearest = match rays.kind {
            ProjectionKind::Perspective => rays.near * (1.0 + NEAR_SLACK),
            ProjectionKind::Orthographic => 2.0 * DEPTH_ROUNDING * (constant / slope).abs(),
        };
        Self {
            kind: rays.kind,
            origin: rays.origin,
            forward: rays.forward,
            near: rays.near,
            nearest,
            pixel: rays.pixel_m(size),
            coordinate: rays.coordinate,
            pixels: SLACK_PIXELS + 2.0 * std::f32::consts::SQRT_2 * grid,
        }
    }

    /// Returns the distance by which a proxy extends beyond its box on the screen (pixels).
    #[must_use]
    pub fn pixels(&self) -> f32 {
        self.pixels
    }

    /// Returns the distance by which a proxy extends beyond its box where the clip coordinate w is
    /// 1, and the least such distance anywhere (metres).
    #[must_use]
    pub fn metres(&self) -> [f32; 2] {
        [self.pixels * self.pixel[1], PATHS * ROUNDING * self.coordinate]
    }

    /// Returns the shortest shift by one pixel at a view depth (metres).
    pub(crate) fn pixel_m(&self, depth_m: f32) -> f32 {
        self.pixel[0] * self.kind.w(depth_m)
    }

    /// Returns the least view depth of a proxy (metres).
    #[must_use]
    pub fn nearest_m(&self) -> f32 {
        self.nearest
    }

    /// Returns the box to test in place of `bounds`, or `None` if it must count as visible, because
    /// the eye is inside or a part of the proxy is nearer than the near plane. An
    /// [empty](Aabb::is_empty) box is never tested: it is outside of every frustum.
    #[must_use]
    pub fn proxy(&self, bounds: &Aabb) -> Option<Aabb> {
        let distance = self.distance_m(bounds);
        self.is_beyond_near(bounds, distance).then(|| bounds.enlarged(distance))
    }

    /// Returns the distance by which the proxy of a box extends beyond it (metres); NaN if the
    /// numbers fail.
    pub(crate) fn distance_m(&self, bounds: &Aabb) -> f32 {
        let [depth, reach] = self.depth_and_reach(bounds);
        let farthest = (depth + reach).max(self.near);
        let slack = PATHS * rounding(bounds, self.coordinate);
        self.pixels * self.pixel[1] * self.kind.w(farthest) + slack
    }

    /// Returns true if a box enlarged by `distance` is completely beyond the near plane.
    pub(crate) fn is_beyond_near(&self, bounds: &Aabb, distance: f32) -> bool {
        let [depth, reach] = self.depth_and_reach(bounds);
        let forward = self.forward.abs();
        let slack = rounding(bounds, self.coordinate);
        let nearest = depth - reach - distance * forward.element_sum() - slack;
        // A NaN fails the comparison and makes the box visible.
        nearest > self.nearest
    }

    /// Returns the view depth of the centre of a box, and the largest difference of a corner's
    /// depth from it.
    fn depth_and_reach(&self, bounds: &Aabb) -> [f32; 2] {
        let depth = self.forward.dot(bounds.centre() - self.origin);
        [depth, self.forward.abs().dot(bounds.half_extent())]
    }
}

/// The number of single-precision paths to clip space that share no matrix: of an object and of its
/// proxy.
const PATHS: f32 = 2.0;

/// A bound on the rounding error of single precision on one path, relative to the largest
/// coordinate.
const ROUNDING: f32 = 16.0 * f32::EPSILON;

/// Returns a bound on the rounding error of single precision (metres) for `bounds` in a view whose
/// numbers are as exact as numbers of size `coordinate` (metres).
pub(crate) fn rounding(bounds: &Aabb, coordinate: f32) -> f32 {
    ROUNDING * bounds.largest_coordinate().max(coordinate)
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;
    use crate::geom::camera::{Camera, Projection};
    use crate::geom::view::CullView;

    #[test]
    fn a_deep_box_grows_by_the_pixel_at_its_far_end() {
        let camera = Camera {
            eye: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(1.0),
            near: 0.1,
        };
        let margin = CullView::new(&camera, [64, 64], 8).margin;
        for far_m in [11.0, 100.0, 1000.0] {
            let bounds = Aabb::new(vec3(-1.0, -1.0, -far_m), vec3(1.0, 1.0, -10.0));
            let least = margin.pixels() * margin.pixel_m(far_m);
            assert!(margin.distance_m(&bounds) >= least, "{far_m} m");
        }
    }
}
