//! The camera: position, direction and projection, the input of a view.

use glam::Vec3;

/// A camera in a right-handed world.
///
/// [`View::new`](crate::View::new) repairs values that describe no camera, and says how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye (metres).
    pub eye: Vec3,
    /// Direction of sight; any length but 0.
    pub forward: Vec3,
    /// The direction that is up; not parallel to `forward`.
    pub up: Vec3,
    /// The way in which it projects the world.
    pub projection: Projection,
    /// Distance of the near plane along `forward` (metres), above 0 in perspective.
    pub near: f32,
}

/// The projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A perspective projection without a far plane.
    Perspective {
        /// The full vertical angle of sight (radians), inside 0 to pi.
        fov_y: f32,
    },
    /// An orthographic projection.
    Orthographic {
        /// The full height of the image (metres), above 0.
        height: f32,
        /// Distance of the far plane along `forward` (metres), beyond the near plane.
        far: f32,
    },
}

impl Projection {
    /// Creates a perspective projection from the full vertical angle of sight (radians).
    #[must_use]
    pub const fn perspective(fov_y: f32) -> Self {
        Self::Perspective { fov_y }
    }

    /// Returns the height of the image where it is `depth_m` away (metres).
    #[must_use]
    pub fn height_at(&self, depth_m: f32) -> f32 {
        match *self {
            Self::Perspective { fov_y } => 2.0 * (fov_y * 0.5).tan() * depth_m,
            Self::Orthographic { height, .. } => height,
        }
    }
}
