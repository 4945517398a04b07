//! Projections as matrices: the conventions of a host's matrix, and the rays that follow from it.

use glam::{DMat3, DVec3, DVec4, Mat4};
use thiserror::Error;

use crate::geom::rays::{ProjectionKind, Rays};

/// The direction in which depths grow. Depths range from 0 to 1 in both conventions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthConvention {
    /// 1 at the near plane; 0 at the far plane or at infinity.
    #[default]
    Reversed,
    /// 0 at the near plane; 1 at the far plane or at infinity.
    Standard,
}

impl DepthConvention {
    /// Returns 1 if the larger of two depths is nearer, -1 if the smaller is.
    #[must_use]
    pub fn sign(self) -> f32 {
        match self {
            Self::Reversed => 1.0,
            Self::Standard => -1.0,
        }
    }

    /// Returns the depth at the near plane.
    #[must_use]
    pub fn nearest(self) -> f32 {
        match self {
            Self::Reversed => 1.0,
            Self::Standard => 0.0,
        }
    }

    /// Returns the depth where nothing was drawn: the depth of the far plane or of infinity.
    #[must_use]
    pub fn farthest(self) -> f32 {
        1.0 - self.nearest()
    }
}

/// The direction of y in clip space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ClipY {
    /// Down, as in Vulkan.
    #[default]
    Down,
    /// Up: the host flips its images by a viewport of negative height.
    Up,
}

/// A host's projection: the matrix that its shaders use, with its conventions of depth and y.
///
/// The matrix must keep lines straight, and its planes of equal depth must be parallel to the
/// image. It may be perspective or orthographic, off-centre, jittered, with a finite or an infinite
/// far plane, right-handed or left-handed, of any scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewProjection {
    /// The matrix from world to clip space that the host's shaders multiply with positions: the
    /// product that the host computed, including its jitter.
    pub matrix: Mat4,
    /// The direction in which its depths grow.
    pub depth: DepthConvention,
    /// The direction of y in its clip space.
    pub y: ClipY,
}

/// The reason why a matrix is not a projection that a culler supports.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ViewError {
    /// An element is infinite or NaN.
    #[error("the matrix of the view has an element that is not finite: {matrix}")]
    NotFinite {
        /// The matrix as it was given.
        matrix: Mat4,
    },
    /// The rows for x, y and w (in an orthographic view, z) are not linearly independent.
    #[error(
        "the matrix of the view flattens the world: its rows for x, y and w (orthographic: z) must \
         be independent; was it transposed? {matrix}"
    )]
    Flat {
        /// The matrix as it was given.
        matrix: Mat4,
    },
    /// Depth varies over a plane parallel to the image, as with an oblique near plane.
    #[error(
        "the depth of the view's matrix is not constant in planes parallel to the image: was it \
         transposed? An oblique near plane is for a shader to clip against"
    )]
    ObliqueDepth,
    /// Depth or w grows in the wrong direction, or the near plane lies behind the eye.
    #[error(
        "the matrix of the view has no near plane before the eye where depth is {nearest} and \
         from which it goes to {}: is its depth {}, or from -1 to 1?",
        1.0 - nearest,
        if *nearest == 0.0 { "reversed" } else { "not reversed" }
    )]
    NoNearPlane {
        /// The depth of the near plane in the given convention.
        nearest: f32,
    },
}

/// The largest allowed deviation of the gradient of depth from the line of sight, relative to the
/// gradient. The depth bias of proxies covers it: over a few pixels it is far below
/// [`DEPTH_ROUNDING`].
const DEPTH_TILT: f64 = 1.0 / 65536.0;

/// The least volume that the unit normals of the rows may span: in a flatter matrix, 32 bits cannot
/// resolve the eye.
const LEAST_VOLUME: f64 = 1.0 / 4096.0;

/// A bound on the rounding of a depth in single precision, relative to its terms.
pub(crate) const DEPTH_ROUNDING: f32 = 1.0 / 524_288.0;

/// The rows of a matrix in 64 bits, scaled so that `w` is the view depth in metres, or 1 everywhere
/// in an orthographic view.
#[derive(Clone, Copy)]
pub(crate) struct Rows {
    pub(crate) x: DVec4,
    pub(crate) y: DVec4,
    pub(crate) z: DVec4,
    pub(crate) w: DVec4,
}

impl Rows {
    pub(crate) fn of(matrix: &Mat4) -> Self {
        let [x, y, z, w] = [0, 1, 2, 3].map(|row| matrix.row(row).as_dvec4());
        let along = w.truncate().length();
        let scale = if along > 0.0 { along.recip() } else { w.w.recip() };
        Self { x: x * scale, y: y * scale, z: z * scale, w: w * scale }
    }

    fn kind(&self) -> ProjectionKind {
        if self.w.truncate() == DVec3::ZERO {
            ProjectionKind::Orthographic
        } else {
            ProjectionKind::Perspective
        }
    }
}

impl ViewProjection {
    /// Returns the matrix for clip space with y down.
    pub(crate) fn downwards(&self) -> Mat4 {
        match self.y {
            ClipY::Down => self.matrix,
            // Exact: a viewport of negative height does the same to positions.
            ClipY::Up => Mat4::from_diagonal(glam::Vec4::new(1.0, -1.0, 1.0, 1.0)) * self.matrix,
        }
    }

    pub(crate) fn rays(&self) -> Result<Rays, ViewError> {
        let matrix = self.downwards();
        if !matrix.is_finite() {
            return Err(ViewError::NotFinite { matrix: self.matrix });
        }
        let flat = ViewError::Flat { matrix: self.matrix };
        let nearest = self.depth.nearest();
        let rows = Rows::of(&matrix);
        let kind = rows.kind();
        let sign = f64::from(self.depth.sign());
        let forward = match kind {
            ProjectionKind::Perspective => Some(rows.w.truncate()),
            ProjectionKind::Orthographic => (-sign * rows.z.truncate()).try_normalize(),
        };
        let forward = forward.filter(|direction| direction.is_finite()).ok_or(flat.clone())?;
        let normals = [rows.x.truncate(), rows.y.truncate(), forward];
        let volume = DMat3::from_cols_array_2d(&normals.map(|row| row.normalize_or_zero().into()));
        let volume = volume.determinant().abs();
        let from_rows = DMat3::from_cols_array_2d(&normals.map(Into::into)).transpose().inverse();
        // Written so that a NaN is rejected.
        if !(volume >= LEAST_VOLUME && from_rows.is_finite()) {
            return Err(flat);
        }
        let slope = rows.z.truncate().dot(forward);
        if (rows.z.truncate() - forward * slope).length() > DEPTH_TILT * slope.abs() {
            return Err(ViewError::ObliqueDepth);
        }
        let nearest_64 = f64::from(nearest);
        // The view depth of the origin relative to the rows, and the depth terms of the rays.
        let (along, depth) = match kind {
            ProjectionKind::Perspective => (-rows.w.w, [slope, rows.z.w - slope * rows.w.w]),
            ProjectionKind::Orthographic => ((nearest_64 - rows.z.w) / slope, [nearest_64, slope]),
        };
        let near = match kind {
            ProjectionKind::Perspective => depth[1] / (nearest_64 - depth[0]),
            ProjectionKind::Orthographic => 0.0,
        };
        let is_ordered = kind == ProjectionKind::Orthographic || depth[1] * sign > 0.0;
        if !(is_ordered && near >= 0.0 && near.is_finite() && rows.w.is_finite()) {
            return Err(ViewError::NoNearPlane { nearest });
        }
        let origin = (from_rows * DVec3::new(-rows.x.w, -rows.y.w, along)).as_vec3();
        let right = from_rows.x_axis;
        let down = from_rows.y_axis;
        let middle = from_rows.z_axis;
        let rays = Rays {
            kind,
            origin,
            forward: forward.as_vec3(),
            middle: middle.as_vec3(),
            right: right.as_vec3(),
            down: down.as_vec3(),
            near: near as f32,
            depth: depth.map(|depth| depth as f32),
            coordinate: origin.abs().max_element() / volume as f32,
        };
        if !rays.is_finite() {
            return Err(ViewError::Flat { matrix: self.matrix });
        }
        Ok(rays)
    }
}
