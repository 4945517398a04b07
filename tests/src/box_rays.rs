//! Rays against boxes: the surfaces that a camera shows, and the surfaces that a light reaches.

use cull::{Aabb, Camera};
use glam::Vec3;
use scene::{LightKind, PunctualLight};

/// Returns the distance at which a ray enters a box, in lengths of `along`; `None` if it misses.
pub fn hit(bounds: &Aabb, from: Vec3, along: Vec3) -> Option<f32> {
    let low = (bounds.min - from) / along;
    let high = (bounds.max - from) / along;
    let near = low.min(high).max_element();
    let far = low.max(high).min_element();
    (near <= far && far > 0.0).then_some(near.max(0.0))
}

/// Returns true if a box lies on a ray before `end`, in lengths of `along`.
pub fn is_blocked(boxes: &[Aabb], from: Vec3, along: Vec3, end: f32) -> bool {
    boxes.iter().any(|bounds| hit(bounds, from, along).is_some_and(|at| at < end))
}

/// Returns the point on the boxes that a place in an image of `size` pixels shows, and the normal
/// at the point. The camera has an angle of 1 radian.
pub fn shown_at(
    boxes: &[Aabb],
    camera: &Camera,
    size: [u32; 2],
    places: [f32; 2],
) -> Option<(Vec3, Vec3)> {
    let [x, y] = places;
    let [width, height] = size.map(|side| side as f32);
    let half = 0.5_f32.tan();
    let right = camera.forward.cross(camera.up).normalize();
    let up = right.cross(camera.forward);
    let across = (x / width * 2.0 - 1.0) * half * width / height;
    let down = (y / height * 2.0 - 1.0) * half;
    let along = camera.forward + right * across - up * down;
    let nearest = boxes
        .iter()
        .filter_map(|bounds| Some((hit(bounds, camera.eye, along)?, bounds)))
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let place = camera.eye + along * nearest.0;
    let centre = nearest.1.centre();
    let half = nearest.1.half_extent();
    let out = (place - centre) / half;
    let axis = (0..3).max_by(|a, b| out[*a].abs().total_cmp(&out[*b].abs()))?;
    let mut normal = Vec3::ZERO;
    normal[axis] = out[axis].signum();
    Some((place, normal))
}

/// Returns the direction from a place to a light, and the distance of the light along it.
pub fn towards(light: &PunctualLight, place: Vec3) -> (Vec3, f32) {
    match light.kind {
        LightKind::Directional => (-light.direction, f32::INFINITY),
        _ => (light.position - place, 1.0),
    }
}
