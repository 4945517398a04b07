//! The rays of a view: through which points of the world a place in the image looks, and which
//! depth a point on them has.

use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::geom::bounds::Aabb;

/// The way in which rays run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ProjectionKind {
    /// All through one point, the eye.
    Perspective,
    /// In parallel.
    Orthographic,
}

impl ProjectionKind {
    /// Returns the scale of the image at a view depth (metres): in perspective the view depth,
    /// else 1. It is the clip coordinate w.
    #[must_use]
    pub fn w(self, depth_m: f32) -> f32 {
        match self {
            Self::Perspective => depth_m,
            Self::Orthographic => 1.0,
        }
    }
}

/// The rays of a view, one for each place in its image.
///
/// The point at view depth `t` (metres) under `(x, y)`, the place in normalised device coordinates
/// (-1 to 1, y down), is `origin + middle * t + (right * x + down * y) * w`, where `w` is
/// [`ProjectionKind::w`] of `t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rays {
    /// The way in which they run.
    pub kind: ProjectionKind,
    /// The eye; where rays are parallel, the middle of the image on the near plane (metres).
    pub origin: Vec3,
    /// The direction in which view depth grows, unit length: the normal of the image.
    pub forward: Vec3,
    /// The ray through the middle of the image, over one metre of view depth.
    pub middle: Vec3,
    /// From the middle of the image to its right edge, where w is 1 (metres).
    pub right: Vec3,
    /// From the middle of the image to its lower edge, where w is 1 (metres).
    pub down: Vec3,
    /// View depth of the near plane (metres); 0 where rays are parallel.
    pub near: f32,
    /// Depth as the rasteriser stores it: the sum of the first, and of the second over the view
    /// depth, or, where rays are parallel, times the view depth.
    pub depth: [f32; 2],
    /// The coordinate by which the rounding of these numbers is bounded (metres).
    pub coordinate: f32,
}

impl Rays {
    /// Returns the eye in homogeneous coordinates: where rays are parallel it lies infinitely far
    /// away, w is 0, and x, y and z are the direction towards it.
    #[must_use]
    pub fn eye(&self) -> Vec4 {
        match self.kind {
            ProjectionKind::Perspective => self.origin.extend(1.0),
            ProjectionKind::Orthographic => (-self.middle).extend(0.0),
        }
    }

    /// Returns the rows of clip x and y for points relative to the origin, where w is that of
    /// [`Rays::row_w`].
    #[must_use]
    pub fn rows_xy(&self) -> [Vec3; 2] {
        let volume = self.right.cross(self.down).dot(self.middle);
        [self.down.cross(self.middle) / volume, self.middle.cross(self.right) / volume]
    }

    /// Returns the row of w: what it is at the origin, and how it grows along each axis.
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

    /// Returns the view depth at which the rasteriser stores a depth (metres): infinite for the
    /// depth of the horizon.
    #[must_use]
    pub fn depth_m_of(&self, stored: f32) -> f32 {
        let [at_start, slope] = self.depth;
        match self.kind {
            ProjectionKind::Perspective => slope / (stored - at_start),
            ProjectionKind::Orthographic => (stored - at_start) / slope,
        }
    }

    /// Returns the point under a place in normalised device coordinates, at a view depth (metres).
    #[must_use]
    pub fn point(&self, ndc: Vec2, depth_m: f32) -> Vec3 {
        let aside = self.right * ndc.x + self.down * ndc.y;
        self.origin + self.middle * depth_m + aside * self.kind.w(depth_m)
    }

    /// Returns the same in double precision, for what is measured: far from the world's origin the
    /// numbers of single precision lie centimetres apart.
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

    /// Returns the way along the ray under a place in normalised device coordinates, over one metre
    /// of view depth.
    #[must_use]
    pub fn along(&self, ndc: Vec2) -> Vec3 {
        match self.kind {
            ProjectionKind::Perspective => self.middle + self.right * ndc.x + self.down * ndc.y,
            ProjectionKind::Orthographic => self.middle,
        }
    }

    /// Returns the direction of sight towards a point, unit length; 0 at the eye itself.
    #[must_use]
    pub fn towards(&self, point: Vec3) -> Vec3 {
        match self.kind {
            ProjectionKind::Perspective => (point - self.origin).normalize_or_zero(),
            ProjectionKind::Orthographic => self.middle.normalize_or_zero(),
        }
    }

    /// Returns the distance from the eye to a box (metres); where rays are parallel, from the near
    /// plane along `forward`. It is 0 for what contains the eye or meets the near plane.
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
                // The nearest corner, so that no part is nearer than the whole, rounding or not.
                let is_ahead = self.forward.cmpge(Vec3::ZERO);
                let corner = Vec3::select(is_ahead, bounds.min, bounds.max);
                let nearest_m = self.depth_m(corner).max(0.0);
                nearest_m * nearest_m
            }
        }
    }

    /// Returns how large an angle of 1 radian is at a distance (metres). Where rays are parallel
    /// that is the height of the image: things look as large as in a view 1 radian high.
    #[must_use]
    pub fn metres_per_radian(&self, distance_m: f32) -> f32 {
        match self.kind {
            ProjectionKind::Perspective => distance_m,
            ProjectionKind::Orthographic => 2.0 * self.down.length(),
        }
    }

    /// Returns the shortest and the longest step from a place in an image of `size` pixels to
    /// another one pixel away, where w is 1 (metres).
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
