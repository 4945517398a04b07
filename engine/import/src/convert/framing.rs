//! Framing: the views from which a whole scene is seen.

use cull::{Aabb, Camera};
use glam::{Vec3, vec3};
use render::scene::{FOV_Y_RAD, Flight};

/// A circle over a scene from which it is seen.
pub(super) fn flight(bounds: &Aabb) -> Flight {
    let size = bounds.half_extent();
    let reach = size.x.hypot(size.z).max(0.5);
    let top = Vec3::new(bounds.centre().x, bounds.max.y, bounds.centre().z);
    Flight { centre: top + Vec3::Y * (reach * 0.35), radius_m: reach * 0.75, down_rad: 0.5 }
}

/// Three quarters from the front, somewhat from above, with everything in sight.
pub(crate) fn overview(bounds: &Aabb) -> Camera {
    let radius = bounds.half_extent().length().max(1e-3);
    let forward = vec3(-0.6, -0.45, -0.66).normalize_or(Vec3::NEG_Z);
    // The sphere around the box fits between the frustum's sides: its distance is r / sin(half the angle).
    let distance = radius / (FOV_Y_RAD * 0.5).sin();
    Camera {
        eye: bounds.centre() - forward * distance,
        forward,
        up: Vec3::Y,
        fov_y: FOV_Y_RAD,
        near: (distance * 1e-3).max(1e-4),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_overview_has_every_corner_in_sight() {
        let bounds = Aabb::new(vec3(-10.0, 0.0, 5.0), vec3(70.0, 4.0, 9.0));
        let camera = overview(&bounds);
        for corner in bounds.corners() {
            let towards = corner - camera.eye;
            assert!(towards.dot(camera.forward) > camera.near);
            assert!(towards.angle_between(camera.forward) < camera.fov_y * 0.5);
        }
        let point = overview(&Aabb::new(Vec3::ONE, Vec3::ONE));
        assert!(point.eye.is_finite() && point.near > 0.0);
    }

    #[test]
    fn a_flight_goes_round_over_the_scene() {
        let bounds = Aabb::new(vec3(-10.0, 0.0, 5.0), vec3(70.0, 4.0, 9.0));
        let flight = flight(&bounds);
        assert!(flight.centre.y > 4.0 && flight.radius_m > 20.0);
        assert!((flight.centre.x, flight.centre.z) == (30.0, 7.0));
        assert!(super::flight(&Aabb::new(Vec3::ZERO, Vec3::ZERO)).radius_m > 0.0);
    }
}
