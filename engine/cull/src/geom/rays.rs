//! The rays of a view: the points of the world at each position of the image, and their depths.

use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::geom::bounds::Aabb;

/// The arrangement of the rays of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ProjectionKind {
    /// All rays pass through one point, the eye.
    Perspective,
    /// All rays are parallel.
    Orthographic,
}

impl ProjectionKind {
    /// Returns the clip coordinate w at a view depth (metres): the view depth in perspective,
    /// otherwise 1. It is the scale of the image at this depth.
    #[must_use]
    pub fn w(self, depth_m: f32) -> f32 {
        match self {
            Self::Perspective => depth_m,
            Self::Orthographic => 1.0,
        }
    }
}

/// The rays of a view, one for each position in its image.
///
/// The point at view depth `t` (metres) and position `(x, y)` in normalised device coordinates (-1
/// to 1, y down) is `origin + middle * t + (right * x + down * y) * w`, where `w` is
/// [`ProjectionKind::w`] of `t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rays {
    /// The arrangement of the rays.
    pub kind: ProjectionKind,
    /// The eye; in an orthographic view, the middle of the image on the near plane (metres).
    pub origin: Vec3,
    /// The direction in which view depth grows, unit length: the normal of the image.
    pub forward: Vec3,
    /// The ray through the middle of the image, over one metre of view depth.
    pub middle: Vec3,
    /// The vector from the middle of the image to its right edge, where w is 1 (metres).
    pub right: Vec3,
    /// The vector from the middle of the image to its lower edge, where w is 1 (metres).
    pub down: Vec3,
    /// The view depth of the near plane (metres); 0 in an orthographic view.
    pub near: f32,
    /// The terms `[a, b]` of the depth that the rasteriser stores: `a + b / view depth` in
    /// perspective, `a + b * view depth` in an orthographic view.
    pub depth: [f32; 2],
    /// The coordinate that bounds the rounding of these numbers (metres).
    pub coordinate: f32,
}

impl Rays {
    /// Returns the eye in homogeneous coordinates. In an orthographic view it is infinitely far
    /// away: w is 0, and x, y and z are the direction towards it.
    #[must_use]
    pub fn eye(&self) -> Vec4 {
        match self.kind {
            ProjectionKind::Perspective => self.origin.extend(1.0),
            ProjectionKind::Orthographic => (-self.middle).extend(0.0),
        }
    }

    /// Returns the rows of clip x and y for points relative to the origin. Their w is given by
    /// [`Rays::row_w`].
    #[must_use]
    pub fn rows_xy(&self) -> [Vec3; 2] {
        let volume = self.right.cross(self.down).dot(self.middle);
        [self.down.cross(self.middle) / volume, self.middle.cross(self.right) / volume]
    }

    /// Returns the row of w: its growth along each axis, and its value at the origin.
    #[must_use]
    pub fn row_w(&self) -> Vec4 {
        match self.kind {
            ProjectionKind::Perspective => self.forward.extend(0.0),
            ProjectionKind::Orthographic => Vec4::W,
        }
    }

    /// Returns the view depth of a point (metres).
    #[must_use]
    pub fn depth_m(&self, point: Vec3) -> f32 {
        self.forward.dot(point - self.origin)
    }

    /// Returns the view depth (metres) of a stored depth; infinite for the depth of the horizon.
    #[must_use]
    pub fn depth_m_of(&self, stored: f32) -> f32 {
        let [at_start, slope] = self.depth;
        match self.kind {
            ProjectionKind::Perspective => slope / (stored - at_start),
            ProjectionKind::Orthographic => (stored - at_start) / slope,
        }
    }

    /// Returns the point at a position in normalised device coordinates and a view depth (metres).
    #[must_use]
    pub fn point(&self, ndc: Vec2, depth_m: f32) -> Vec3 {
        let aside = self.right * ndc.x + self.down * ndc.y;
        self.origin + self.middle * depth_m + aside * self.kind.w(depth_m)
    }

    /// Returns the point of [`Rays::point`] in double precision, for measurements: far from the
    /// world's origin, neighbouring numbers of single precision are centimetres apart.
    #[must_use]
    pub fn point_f64(&self, ndc: Vec2, depth_m: f64) -> DVec3 {
        let aside =
            self.right.as_dvec3() * f64::from(ndc.x) + self.down.as_dvec3() * f64::from(ndc.y);
        let w = match self.kind {
            ProjectionKind::Perspective => depth_m,
            ProjectionKind::Orthographic => 1.0,
        };
        self.origin.as_dvec3() + self.middle.as_dvec3() * depth_m + aside * w
    }

    /// Returns the vector along the ray at a position in normalised device coordinates, per metre
    /// of view depth.
    #[must_use]
    pub fn along(&self, ndc: Vec2) -> Vec3 {
        match self.kind {
            ProjectionKind::Perspective => self.middle + self.right * ndc.x + self.down * ndc.y,
            ProjectionKind::Orthographic => self.middle,
        }
    }

    /// Returns the direction of sight towards a point, with unit length; 0 at the eye itself.
    #[must_use]
    pub fn towards(&self, point: Vec3) -> Vec3 {
        match self.kind {
            ProjectionKind::Perspective => (point - self.origin).normalize_or_zero(),
            ProjectionKind::Orthographic => self.middle.normalize_or_zero(),
        }
    }

    /// Returns the distance from the eye to a box (metres); in an orthographic view, from the near
    /// plane along `forward`. It is 0 for a box that contains the eye or meets the near plane.
    #[must_use]
    pub fn distance(&self, bounds: &Aabb) -> f32 {
        self.distance_squared(bounds).sqrt()
    }

    /// Returns the square of [`Rays::distance`], which is cheaper.
    #[must_use]
    pub fn distance_squared(&self, bounds: &Aabb) -> f32 {
        match self.kind {
            ProjectionKind::Perspective => bounds.distance_squared(self.origin),
            ProjectionKind::Orthographic => {
                // The nearest corner: with it, no part is nearer than the whole box, even with
                // rounding.
                let is_ahead = self.forward.cmpge(Vec3::ZERO);
                let corner = Vec3::select(is_ahead, bounds.min, bounds.max);
                let nearest_m = self.depth_m(corner).max(0.0);
                nearest_m * nearest_m
            }
        }
    }

    /// Returns the length seen under an angle of 1 radian at a distance (metres). In an
    /// orthographic view this is the height of the image: objects look as large as in a view 1
    /// radian high.
    #[must_use]
    pub fn metres_per_radian(&self, distance_m: f32) -> f32 {
        match self.kind {
            ProjectionKind::Perspective => distance_m,
            ProjectionKind::Orthographic => 2.0 * self.down.length(),
        }
    }

    /// Returns the shortest and the longest vector between two positions one pixel apart in an
    /// image of `size` pixels, where w is 1 (metres).
    pub(crate) fn pixel_m(&self, size: [u32; 2]) -> [f32; 2] {
        let across = self.right * (2.0 / size[0] as f32);
        let down = self.down * (2.0 / size[1] as f32);
        // The singular values of the matrix of the two columns.
        let a = across.length_squared();
        let b = down.length_squared();
        let longest = (0.5 * (a + b) + (0.5 * (a - b)).hypot(across.dot(down))).sqrt();
        [across.cross(down).length() / longest, longest]
    }

    pub(crate) fn is_finite(&self) -> bool {
        let vectors = [self.origin, self.forward, self.middle, self.right, self.down];
        vectors.iter().all(|vector| vector.is_finite()) && Vec2::from(self.depth).is_finite()
    }
}
