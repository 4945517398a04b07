//! Framing: the views that show a whole scene.

use cull::{Aabb, Camera, Projection, trigonometry};
use glam::{Vec3, vec3};
use scene::FOV_Y_RAD;

/// The least aspect ratio of an image for which the view shows everything.
const ASPECT: f32 = 4.0 / 3.0;

/// The least distance of a view of a whole scene, in metres.
pub(super) const LEAST_DISTANCE_M: f32 = 1e-5;

/// The share of the image that the scene fills.
const FILLED: f32 = 0.9;

/// Returns a view of everything, diagonally from the front and above.
pub(crate) fn overview(bounds: &Aabb) -> Camera {
    let forward = vec3(-0.6, -0.45, -0.66).normalize_or(Vec3::NEG_Z);
    let right = forward.cross(Vec3::Y).normalize_or(Vec3::X);
    let up = right.cross(forward);
    let tan_up = trigonometry::tan(FOV_Y_RAD * 0.5) * FILLED;
    // The distance that the outermost corner requires.
    let distance_for = |corner: Vec3| {
        let from_centre = corner - bounds.centre();
        let across = from_centre.dot(right).abs() / (tan_up * ASPECT);
        across.max(from_centre.dot(up).abs() / tan_up) - from_centre.dot(forward)
    };
    let distance = bounds.corners().into_iter().map(distance_for).fold(LEAST_DISTANCE_M, f32::max);
    Camera {
        eye: bounds.centre() - forward * distance,
        forward,
        up: Vec3::Y,
        projection: Projection::perspective(FOV_Y_RAD),
        near: (distance * 1e-3).max(1e-6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_overview_has_every_corner_in_sight() {
        let bounds = Aabb::new(vec3(-10.0, 0.0, 5.0), vec3(70.0, 4.0, 9.0));
        let camera = overview(&bounds);
        let view = cull::CullView::new(&camera, [400, 300], 8);
        let mut farthest_out: f32 = 0.0;
        for corner in bounds.corners() {
            let clip = view.view_proj * corner.extend(1.0);
            assert!(clip.w > camera.near);
            farthest_out = farthest_out.max(clip.x.abs() / clip.w).max(clip.y.abs() / clip.w);
        }
        assert!((farthest_out - FILLED).abs() < 1.0e-3, "{farthest_out}");
        let point = overview(&Aabb::new(Vec3::ONE, Vec3::ONE));
        assert!(point.eye.is_finite() && point.near > 0.0);
    }

    #[test]
    fn what_is_tiny_fills_the_image_too() {
        let bounds = Aabb::new(Vec3::ZERO, Vec3::splat(1e-4));
        let camera = overview(&bounds);
        assert!(camera.eye.distance(bounds.centre()) < 4e-4 && camera.near < 2e-6);
    }
}
