//! The margin by which a proxy must be larger than its node, so that no sample is lost to rounding.
//!
//! A rasteriser moves every vertex to a grid of `2^-b` pixels (`b` = `subPixelPrecisionBits`)
//! before it looks which samples a triangle covers. A fragment of the object at sample `s`
//! therefore stands for a point `p` of the object whose true projection is up to
//! `e = sqrt(2) * 2^-b` pixels away from `s`, and it carries the depth of `p`: the vertex shader
//! must see to that, since some rasterisers take depth from the positions of the vertices before
//! the snapping ([`CullView::snap_steps`](crate::CullView::snap_steps)). In the same way the
//! fragment of the proxy at `s` stands for the point `q` of the proxy's front that the true ray up
//! to `e` away from `s` meets: that ray passes `p` in a distance of at most `2e` pixels.
//!
//! A shift by one pixel is a shift in the plane through `p` parallel to the image, by at most
//! `footprint(w) = w * pixel`: `pixel` is the longest such shift where the clip coordinate `w` is 1
//! (metres). In perspective `w` is the view depth, in an orthographic view it is 1 throughout. A
//! centre that is not in the middle, as under a jitter, leaves shifts in this plane as they are. So
//! when the proxy holds a ball of `2e` footprints around `p`, the ray goes through a point of the
//! proxy that is as deep as `p`, hence enters the proxy, at `q`, no deeper than `p`: the proxy
//! covers `s` and passes the depth test wherever the object does. The box grown by `d` holds that
//! ball around every point of the object, with the footprint taken at the farthest corner.
//!
//! # Several samples per pixel
//! `s` is any place in a pixel, its middle or not: coverage and depth of each sample are those of
//! its own place, of the object as of the proxy, and a test passes if one sample does. So the proof
//! is the same with several samples per pixel, and no margin grows. A tester that does not
//! rasterise has one depth per pixel, the farthest of its samples, and takes the sample to be
//! anywhere in the pixel: `compute_test.comp` by its reach of half a pixel more, the depth pyramid
//! since it covers whole pixels.
//!
//! # Rounding
//! A quarter of a pixel on top pays for the rounding of a depth that is reversed and infinite: `q`
//! is nearer than `p` by about that much of a footprint, some ten thousandths of `w`, and a 32-bit
//! depth resolves ten millionths.
//!
//! The last term pays for coordinates far from the origin of the world, by the largest coordinate
//! `C` of the box and of the eye. Objects and proxies have a matrix each. Shaders of objects
//! multiply [`CullView::from_anchor`](crate::CullView::from_anchor) with positions relative to the
//! anchor, which lies at the eye or near it. Shaders of proxies multiply
//! [`CullView::proxy_view_proj`](crate::CullView::proxy_view_proj) with coordinates of the world.
//! The columns of both but the last are the same. The last, the translation, is almost exact in the
//! one and rounded in the other, and nothing of that error cancels: the errors of both paths add
//! up.
//!
//! An error of clip x, y and w shifts a vertex along the rows of the matrix, by a distance that
//! does not depend on the angle of view. Depth that is reversed and infinite has a constant clip z
//! and follows w. Let `u = eps / 2`, and for rows of unit length let `s(v)` be the sum of the
//! absolute products of a row's and `v`'s coordinates. For an eye `e`, a vertex `p` and `d = p - e`
//! each row is wrong by at most
//!
//! - `5 u s(e)` by the proxy's translation: its coefficients, three products, two sums, and the
//!   product with the projection's scale. A host's matrix is right by definition;
//! - `3 u s(p) + u s(d)` by the proxy's shader: products, two sums, and the sum with the
//!   translation;
//! - `4 u s(d)` by the object's shader: the difference from the anchor, products and two sums.
//!
//! Over three orthogonal rows the vector of `s(v)` is no longer than 2.9 times the largest
//! coordinate of `v`. So the shift is at most `12 eps C` where `d` is small beside `C`, and `26 eps
//! C` where eye and vertex lie on opposite sides of the origin; `29 eps C` if the shader of the
//! proxy begins its sum with the translation. The rounding of the corners of the enlarged box adds
//! less than `eps C`. So does that of the object's box on the CPU, and that of an eye that lies
//! between the numbers of single precision, by a host's matrix or an [`Anchor`](crate::Anchor). All
//! together stays below `32 eps C`: a term of `16 eps C` for each of two paths. Rows that are not
//! orthogonal have a larger [`Rays::coordinate`].
//!
//! Other depths are a sum `a + b / w`, or `a + b * view depth` without perspective, and lose digits
//! to the constant `a`. No distance in the world pays for that. So proxies are moved towards the
//! eye by a bound on this rounding, by the matrix that they are drawn with
//! ([`CullView::proxy_view_proj`](crate::CullView::proxy_view_proj)): `|a| * 2^-19`, and `2^-19` of
//! what `a` times a coordinate of the eye adds to the clip coordinate z: `16 eps` of each. The
//! shifts above cancel but for the errors of z and of `a w`. In perspective only a host's matrix
//! has such an `a`, so these are `6 u a s(e) / w` by the shader of the proxy, as much by that of an
//! object which is drawn with the same matrix, and what is relative to `d`: less than
//! `11 eps a C / w`, and some `eps a`. Rounding to a depth buffer with fewer bits keeps the order
//! of depths.
//!
//! # The near plane
//! Only front faces of proxies are drawn. A proxy that reaches before the near plane would lose
//! front faces to clipping, so such a box has no proxy: it counts as visible. Clipping at a far
//! plane takes the same from an object and from its proxy.

use glam::Vec3;

use crate::geom::bounds::Aabb;
use crate::geom::projection::DEPTH_ROUNDING;
use crate::geom::rays::{ProjectionKind, Rays};

/// Pixels added to the need of the sub-pixel grid, against rounding of depths.
const SLACK_PIXELS: f32 = 0.25;

/// Relative distance that a proxy keeps from the near plane.
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
    /// The coordinate by which the rounding of the view's own numbers is bounded (metres).
    coordinate: f32,
    /// The distance by which a proxy reaches beyond its box on the screen (pixels).
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

    /// Returns the distance by which a proxy reaches beyond its box on the screen (pixels).
    #[must_use]
    pub fn pixels(&self) -> f32 {
        self.pixels
    }

    /// Returns the distance by which a proxy reaches beyond a box where the clip coordinate w is 1,
    /// and the least distance anywhere (metres).
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
    /// the eye is inside or some of the proxy is nearer than the near plane. An
    /// [empty](Aabb::is_empty) box is never tested: it is in no frustum.
    #[must_use]
    pub fn proxy(&self, bounds: &Aabb) -> Option<Aabb> {
        let distance = self.distance_m(bounds);
        self.is_beyond_near(bounds, distance).then(|| bounds.enlarged(distance))
    }

    /// Returns the distance by which the proxy of a box reaches beyond it (metres); NaN where
    /// numbers fail.
    pub(crate) fn distance_m(&self, bounds: &Aabb) -> f32 {
        let [depth, reach] = self.depth_and_reach(bounds);
        let farthest = (depth + reach).max(self.near);
        let slack = PATHS * rounding(bounds, self.coordinate);
        self.pixels * self.pixel[1] * self.kind.w(farthest) + slack
    }

    /// Returns true if all of a box that is enlarged by `distance` is beyond the near plane.
    pub(crate) fn is_beyond_near(&self, bounds: &Aabb, distance: f32) -> bool {
        let [depth, reach] = self.depth_and_reach(bounds);
        let forward = self.forward.abs();
        let slack = rounding(bounds, self.coordinate);
        let nearest = depth - reach - distance * forward.element_sum() - slack;
        // A NaN fails the comparison and makes the box visible.
        nearest > self.nearest
    }

    /// Returns the view depth of the centre of a box, and that by which its corners differ.
    fn depth_and_reach(&self, bounds: &Aabb) -> [f32; 2] {
        let depth = self.forward.dot(bounds.centre() - self.origin);
        [depth, self.forward.abs().dot(bounds.half_extent())]
    }
}

/// Paths of single precision to clip space, of an object and of its proxy, that share no matrix.
const PATHS: f32 = 2.0;

/// A bound on the rounding error of single precision on one path, relative to the largest
/// coordinate.
const ROUNDING: f32 = 16.0 * f32::EPSILON;

/// Returns a bound on the rounding error of single precision where `bounds` is seen by a view whose
/// own numbers are as exact as those up to `coordinate` (metres).
pub(crate) fn rounding(bounds: &Aabb, coordinate: f32) -> f32 {
    ROUNDING * bounds.largest_coordinate().max(coordinate)
}
