//! The camera: position, direction and angle of sight, the input of a view.

use glam::Vec3;

/// A perspective camera in a right-handed world.
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
    /// The full vertical angle of sight (radians), inside 0 to pi.
    pub fov_y: f32,
    /// Distance of the near plane along `forward` (metres), above 0. There is no far plane.
    pub near: f32,
}
