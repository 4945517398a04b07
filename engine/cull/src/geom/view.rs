//! The view of one frame, derived from a camera and the size of its image.

use glam::{Mat4, Vec3};

use crate::geom::bounds::Aabb;
use crate::geom::camera::Camera;
use crate::geom::frustum::Frustum;
use crate::geom::margin::Margin;

/// One frame's view: the matrix that draws and the volumes that cull, from the same numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// World to Vulkan clip space: y down, depth reversed (1 at the near plane, 0 at infinity).
    pub view_proj: Mat4,
    /// Position of the eye (metres).
    pub eye: Vec3,
    /// Direction of sight, unit length.
    pub forward: Vec3,
    /// The direction to the right of the image, unit length.
    pub right: Vec3,
    /// The direction to the top of the image, unit length.
    pub up: Vec3,
    /// Distance of the near plane (metres).
    pub near: f32,
    /// Tangents of half the horizontal and half the vertical angle of sight.
    pub tan_half: [f32; 2],
    /// Size of the image (pixels).
    pub size: [u32; 2],
    /// The place of the image in a larger image: its upper left corner (pixels). No decision
    /// depends on it.
    pub origin: [u32; 2],
    /// Steps of the device's sub-pixel grid from the middle of the image to its edges: drawn
    /// vertices are moved onto it, so that no triangle carries a depth that is not its own.
    pub snap_steps: [f32; 2],
    /// The volume that the view sees.
    pub frustum: Frustum,
    /// The proxies of boxes in this view.
    pub margin: Margin,
}

impl View {
    /// Derives a view for an image of `size` pixels on a device that snaps vertices to
    /// `2^-sub_pixel_bits` pixels (Vulkan's `subPixelPrecisionBits`).
    ///
    /// Never fails: a size of 0 counts as 1; an eye that is not finite is moved to the origin; a
    /// missing `forward` becomes -z and an `up` that does not fit the axis farthest from it; the
    /// angle is kept between 0.001 and 3.1 radians and the near plane between 1e-6 and 1e6 m.
    #[must_use]
    pub fn new(camera: &Camera, size: [u32; 2], sub_pixel_bits: u32) -> Self {
        let [width, height] = size.map(|pixels| pixels.max(1));
        let eye = if camera.eye.is_finite() { camera.eye } else { Vec3::ZERO };
        let forward = camera.forward.try_normalize().unwrap_or(Vec3::NEG_Z);
        let right = sideways(forward, camera.up);
        let up = right.cross(forward);
        let near = clamp_or(camera.near, 1.0e-6, 1.0e6, 0.1);
        let fov_y = clamp_or(camera.fov_y, 1.0e-3, 3.1, 1.0);
        let tan_y = (fov_y * 0.5).tan();
        let aspect = width as f32 / height as f32;
        let tan_half = [tan_y * aspect, tan_y];
        let footprint = 2.0 * tan_y / height as f32;
        let steps_per_pixel = 2.0_f32.powi(sub_pixel_bits.min(24) as i32);
        Self {
            view_proj: projection(tan_half, near) * world_to_eye(eye, right, up, forward),
            eye,
            forward,
            right,
            up,
            near,
            tan_half,
            size: [width, height],
            origin: [0, 0],
            snap_steps: [width, height].map(|side| side as f32 * 0.5 * steps_per_pixel),
            frustum: Frustum::new(eye, [right, up, forward], tan_half, near),
            margin: Margin::new(eye, forward, near, footprint, sub_pixel_bits),
        }
    }

    /// Returns how many pixels a metre covers at the nearest point of `bounds`, in the middle of
    /// the image; at the near plane where the box is nearer.
    #[must_use]
    pub fn pixels_per_metre(&self, bounds: &Aabb) -> f32 {
        let distance = bounds.distance_squared(self.eye).sqrt().max(self.near);
        let [_, tan_y] = self.tan_half;
        self.size[1] as f32 * 0.5 / (tan_y * distance)
    }
}

/// Returns `value` clamped to a range, or `otherwise` if it is NaN.
fn clamp_or(value: f32, low: f32, high: f32, otherwise: f32) -> f32 {
    if value.is_nan() { otherwise } else { value.clamp(low, high) }
}

/// Returns the unit vector to the right, also for an `up` that is missing or parallel to `forward`.
fn sideways(forward: Vec3, up: Vec3) -> Vec3 {
    let across = forward.cross(up.normalize_or_zero());
    if across.is_finite() && across.length_squared() > 1.0e-12 {
        return across.normalize();
    }
    forward.any_orthonormal_vector()
}

/// Returns the matrix from world to eye space, right-handed: x is right, y up, and the camera looks
/// along -z.
fn world_to_eye(eye: Vec3, right: Vec3, up: Vec3, forward: Vec3) -> Mat4 {
    let back = -forward;
    let rotation =
        Mat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), glam::Vec4::W)
            .transpose();
    rotation * Mat4::from_translation(-eye)
}

/// Returns the projection with infinite far plane, reversed depth, y down.
fn projection([tan_x, tan_y]: [f32; 2], near: f32) -> Mat4 {
    use glam::Vec4;
    Mat4::from_cols(
        Vec4::new(1.0 / tan_x, 0.0, 0.0, 0.0),
        Vec4::new(0.0, -1.0 / tan_y, 0.0, 0.0),
        Vec4::new(0.0, 0.0, 0.0, -1.0),
        Vec4::new(0.0, 0.0, near, 0.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: Camera = Camera {
        eye: Vec3::new(1.0, 2.0, 3.0),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        fov_y: std::f32::consts::FRAC_PI_2,
        near: 0.5,
    };

    #[test]
    fn clip_space_is_vulkans_with_reversed_depth() {
        let view = View::new(&CAMERA, [200, 100], 8);
        let ndc = |offset: Vec3| view.view_proj.project_point3(view.eye + offset);
        assert!(ndc(Vec3::new(0.0, 0.0, -0.5)).abs_diff_eq(Vec3::new(0.0, 0.0, 1.0), 1e-5));
        assert!(ndc(Vec3::new(0.0, 0.0, -5.0e6)).z < 1e-6);
        assert!(ndc(Vec3::new(0.0, 4.0, -4.0)).abs_diff_eq(Vec3::new(0.0, -1.0, 0.125), 1e-5));
        assert!(ndc(Vec3::new(8.0, 0.0, -4.0)).abs_diff_eq(Vec3::new(1.0, 0.0, 0.125), 1e-5));
    }

    #[test]
    fn what_is_no_camera_is_repaired() {
        let nothing = Camera {
            eye: Vec3::NAN,
            forward: Vec3::ZERO,
            up: Vec3::ZERO,
            fov_y: f32::NAN,
            near: -1.0,
        };
        let view = View::new(&nothing, [0, 0], 400);
        assert!(view.view_proj.is_finite());
        assert!(view.right.is_normalized() && view.up.is_normalized());
        let along = Camera { up: CAMERA.forward, ..CAMERA };
        assert!(View::new(&along, [64, 64], 8).view_proj.is_finite());
    }
}
