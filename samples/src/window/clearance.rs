//! The clearance of a view: the free distance in front of it.

use antumbra::cull::{Aabb, Camera, Projection};
use antumbra::glam::{Affine3A, Vec3};
use antumbra::scene::{Mesh, Scene};

/// The rays per row and per column, over the middle half of the image.
const RAYS: usize = 5;

/// Returns the median distance, in metres, at which rays through the middle of a view hit a
/// triangle of the scene at rest; infinite if most rays hit nothing.
pub fn clearance_m(scene: &Scene, camera: &Camera) -> f32 {
    let right = camera.forward.cross(camera.up).normalize_or(Vec3::X);
    let up = right.cross(camera.forward).normalize_or(Vec3::Y);
    let reach = camera.projection.height_at(1.0) * 0.25;
    let part = |place: usize| (place as f32 / (RAYS - 1) as f32 * 2.0 - 1.0) * reach;
    let forward = camera.forward.normalize_or(Vec3::NEG_Z);
    let rays = (0..RAYS * RAYS).map(|ray| {
        let across = right * part(ray % RAYS) + up * part(ray / RAYS);
        match camera.projection {
            Projection::Perspective { .. } => (camera.eye, (forward + across).normalize()),
            Projection::Orthographic { .. } => (camera.eye + across, forward),
        }
    });
    let mut distances_m: Vec<f32> = rays.map(|(eye, ray)| nearest_m(scene, eye, ray)).collect();
    distances_m.sort_by(f32::total_cmp);
    distances_m.get(RAYS * RAYS / 2).copied().unwrap_or(f32::INFINITY)
}

fn nearest_m(scene: &Scene, eye: Vec3, ray: Vec3) -> f32 {
    let near = scene.objects.iter().filter_map(|object| {
        let is_met = scene.bounds_of(object).is_some_and(|bounds| meets_box(&bounds, eye, ray));
        scene.mesh_of(object).filter(|_| is_met).map(|mesh| (mesh, object.transform))
    });
    near.map(|(mesh, transform)| nearest_of_mesh_m(mesh, &transform, eye, ray))
        .fold(f32::INFINITY, f32::min)
}

fn meets_box(bounds: &Aabb, eye: Vec3, ray: Vec3) -> bool {
    let a = (bounds.min - eye) / ray;
    let b = (bounds.max - eye) / ray;
    let enter = a.min(b).max_element();
    let leave = a.max(b).min_element();
    enter <= leave && leave >= 0.0
}

/// Returns the distance of the nearest triangle of a mesh along the ray, from either side (Möller
/// and Trumbore, 1997).
fn nearest_of_mesh_m(mesh: &Mesh, transform: &Affine3A, eye: Vec3, ray: Vec3) -> f32 {
    let inverse = transform.inverse();
    let eye = inverse.transform_point3(eye);
    let ray = inverse.transform_vector3(ray);
    let corner =
        |index: u32| mesh.vertices.get(index as usize).map(|vertex| Vec3::from(vertex.position));
    let (triangles, _) = mesh.indices.as_chunks::<3>();
    let distances = triangles.iter().filter_map(|&[a, b, c]| {
        let a = corner(a)?;
        let b = corner(b)?;
        let c = corner(c)?;
        let side = b - a;
        let other = c - a;
        let slope = ray.cross(other);
        let scale = 1.0 / side.dot(slope);
        let from = eye - a;
        let u = from.dot(slope) * scale;
        let turned = from.cross(side);
        let v = ray.dot(turned) * scale;
        let distance = other.dot(turned) * scale;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
    });
    distances.fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_is_as_near_as_it_is_and_a_door_in_its_box_is_clear() {
        let corner = |x: f32, y: f32| ([x, y, 0.0], [1.0; 3]);
        let quad = |x: [f32; 2], y: [f32; 2]| {
            let a = corner(x[0], y[0]);
            let b = corner(x[1], y[0]);
            let c = corner(x[1], y[1]);
            let d = corner(x[0], y[1]);
            [a, b, c, a, c, d]
        };
        let camera = |eye: Vec3| Camera {
            eye,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(1.0),
            near: 0.1,
        };
        let wall = Scene::single(Mesh::of_triangles("wall", &quad([-9.0, 9.0], [-9.0, 9.0])));
        let near_m = clearance_m(&wall, &camera(Vec3::Z * 1.5));
        assert!((1.5..1.6).contains(&near_m), "{near_m}");
        let door = [quad([-9.0, -2.0], [-9.0, 9.0]), quad([2.0, 9.0], [-9.0, 9.0])].concat();
        let door = Scene::single(Mesh::of_triangles("door", &door));
        assert_eq!(clearance_m(&door, &camera(Vec3::Z * 1.5)), f32::INFINITY);
        // Triangles behind the eye do not count.
        assert_eq!(clearance_m(&wall, &camera(Vec3::Z * -1.5)), f32::INFINITY);
    }
}
