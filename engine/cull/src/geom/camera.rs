//! The camera: position, direction and projection, the input of a view.

use glam::Vec3;

use crate::trigonometry;

/// The largest absolute y of a direction of sight for which +y is used as the upward direction.
const STEEPEST: f32 = 0.999;

/// A camera in a right-handed world.
///
/// [`CullView::new`](crate::CullView::new) repairs invalid values as its documentation describes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye (metres).
    pub eye: Vec3,
    /// Direction of sight; any length but 0.
    pub forward: Vec3,
    /// The direction that is up; not parallel to `forward`.
    pub up: Vec3,
    /// The projection to the image.
    pub projection: Projection,
    /// Distance of the near plane along `forward` (metres), above 0 in perspective.
    pub near: f32,
}

impl Camera {
    /// The vertical angle of sight of [`Camera::look_at`] (radians): 60 degrees.
    pub const USUAL_FOV_Y: f32 = std::f32::consts::FRAC_PI_3;

    /// Returns a camera at `eye` that looks at `target` (metres), in a perspective of
    /// [`Camera::USUAL_FOV_Y`] with the near plane at 0.1 m. Up is +y, or +z if the camera looks
    /// along y. If `eye` and `target` are equal, it looks along -z. Numbers that are not finite
    /// stay in the camera, and [`check_camera`](crate::check_camera) refuses it.
    #[must_use]
    pub fn look_at(eye: impl Into<Vec3>, target: impl Into<Vec3>) -> Self {
        let eye = eye.into();
        let towards = target.into() - eye;
        // Divided first: the square of a large number is infinite.
        let forward = (towards / towards.abs().max_element()).normalize();
        let forward = if towards == Vec3::ZERO { Vec3::NEG_Z } else { forward };
        let is_vertical = forward.y.abs() > STEEPEST;
        let up = if is_vertical { Vec3::Z } else { Vec3::Y };
        let projection = Projection::perspective(Self::USUAL_FOV_Y);
        Self { eye, forward, up, projection, near: 0.1 }
    }
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

    /// Returns the height of the image at the view depth `depth_m` (metres).
    #[must_use]
    pub fn height_at(&self, depth_m: f32) -> f32 {
        match *self {
            Self::Perspective { fov_y } => 2.0 * trigonometry::tan(0.5 * fov_y) * depth_m,
            Self::Orthographic { height, .. } => height,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CullView;

    #[test]
    fn a_target_is_in_the_middle_of_the_image_wherever_it_is() {
        let eye = Vec3::new(1.0, 2.0, 3.0);
        for target in [Vec3::X * 9.0, eye + Vec3::Y, eye - Vec3::Y * 5.0, Vec3::NEG_ONE * 1e4] {
            let camera = Camera::look_at(eye, target);
            let clip = CullView::new(&camera, [640, 480], 8).clip(target);
            assert!((clip.truncate().truncate() / clip.w).abs().max_element() < 1e-3, "{target}");
            assert!(clip.w > 0.0 && camera.up.cross(camera.forward).length() > 0.01);
        }
        assert_eq!(Camera::look_at(eye, eye).forward, Vec3::NEG_Z);
        assert_eq!(Camera::look_at([0.0; 3], [3e38, 0.0, 0.0]).forward, Vec3::X);
        assert_eq!(Camera::look_at([1.0, 2.0, 3.0], [0.0; 3]).eye, eye);
    }

    #[test]
    fn a_target_that_is_not_finite_is_refused() {
        for impossible in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let camera = Camera::look_at([0.0, 1.7, 0.0], [1.0, impossible, 2.0]);
            assert!(crate::check_camera(&camera, [640, 480]).is_err(), "{camera:?}");
        }
    }
}
