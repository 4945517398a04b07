//! A walk of hosts past boxes. Most boxes are hidden, and jumps of the eye reveal some at once.

use cull::{Aabb, Camera, Projection};
use glam::{Vec3, vec3};

/// Returns a wall and a thousand boxes behind it. The boxes at the edge of the wall show.
pub fn boxes() -> Vec<Aabb> {
    let wall = Aabb::new(vec3(-4.0, -3.0, -6.0), vec3(4.0, 3.0, -5.5));
    let small = (0..1_000).map(|number| {
        let [x, y, z] = [number % 20, number / 20 % 10, number / 200].map(|part| part as f32);
        let low = vec3(x * 0.7 - 7.0, y * 0.7 - 3.5, -12.0 - z * 1.3 - 0.01 * x);
        Aabb::new(low, low + Vec3::splat(0.45))
    });
    std::iter::once(wall).chain(small).collect()
}

/// Returns the camera of a frame, which moves and sometimes jumps to another side of the wall.
pub fn camera(frame: u64) -> Camera {
    let side = (frame / 6 % 3) as f32 - 1.0;
    let eye = vec3(side * 9.0 + frame as f32 * 0.08, 0.0, 3.0);
    Camera {
        eye,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(0.9),
        near: 0.1,
    }
}
