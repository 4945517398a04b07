//! Rays against the triangles of a scene in its current state.

use cull::{Aabb, Camera};
use glam::{DAffine3, DVec3, Vec3};
use scene::Scene;

/// The triangles of a scene.
pub struct SceneRays {
    meshes: Vec<Vec<[DVec3; 3]>>,
    objects: Vec<Placed>,
}

struct Placed {
    mesh: usize,
    bounds: Aabb,
    to_world: DAffine3,
    to_mesh: DAffine3,
}

/// The intersection of a ray and a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Met {
    /// The index of the object.
    pub object: usize,
    /// The distance in lengths of the ray.
    pub distance: f64,
    /// The place in the world.
    pub place: DVec3,
    /// The unit normal of the triangle, towards the origin of the ray.
    pub normal: DVec3,
}

/// The triangles that a ray can meet.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Sides {
    /// Triangles that face the origin of the ray.
    Fronts,
    /// All triangles.
    Both,
}

impl SceneRays {
    /// Collects the triangles of all objects that are not transparent.
    pub fn new(scene: &Scene) -> Self {
        let meshes = scene.meshes.iter().map(|mesh| {
            let place =
                |index: &u32| Vec3::from(mesh.vertices[*index as usize].position).as_dvec3();
            mesh.indices
                .chunks_exact(3)
                .map(|at| [0, 1, 2].map(|corner| place(&at[corner])))
                .collect()
        });
        let objects = scene.objects.iter().map(|object| {
            let [x, y, z] =
                [object.transform.x_axis, object.transform.y_axis, object.transform.z_axis]
                    .map(|axis| Vec3::from(axis).as_dvec3());
            let to_world =
                DAffine3::from_cols(x, y, z, Vec3::from(object.transform.translation).as_dvec3());
            Placed {
                mesh: object.mesh.0 as usize,
                bounds: scene.bounds_of(object).unwrap().enlarged(1e-3),
                to_world,
                to_mesh: to_world.inverse(),
            }
        });
        Self { meshes: meshes.collect(), objects: objects.collect() }
    }

    /// Returns the point that a place in an image of `size` pixels shows. The camera has an angle
    /// of 1 radian.
    pub fn shown_at(&self, camera: &Camera, size: [u32; 2], place: [f64; 2]) -> Option<Met> {
        let [x, y] = place;
        let [width, height] = size.map(f64::from);
        let half = 0.5_f64.tan();
        let right = camera.forward.cross(camera.up).normalize();
        let up = right.cross(camera.forward);
        let across = (x / width * 2.0 - 1.0) * half * width / height;
        let down = (y / height * 2.0 - 1.0) * half;
        let [forward, right, up] = [camera.forward, right, up].map(Vec3::as_dvec3);
        let along = forward + right * across - up * down;
        let from = camera.eye.as_dvec3() + along * f64::from(camera.near);
        self.first(from, along, Sides::Fronts)
    }

    /// Returns true if a triangle lies on a ray before `end`, in lengths of `along`.
    pub fn is_blocked(&self, from: DVec3, along: DVec3, end: f64) -> bool {
        let met = self.first(from, along, Sides::Both);
        met.is_some_and(|met| (met.place - from).length() < end * along.length())
    }

    /// Returns the first triangle that a ray meets.
    pub fn first(&self, from: DVec3, along: DVec3, sides: Sides) -> Option<Met> {
        let mut nearest: Option<Met> = None;
        for (object, placed) in self.objects.iter().enumerate() {
            let before = nearest.map_or(f64::INFINITY, |met| met.distance);
            if !enters(&placed.bounds, from, along).is_some_and(|at| at < before) {
                continue;
            }
            // A transform does not change distances in lengths of the ray.
            let start = placed.to_mesh.transform_point3(from);
            let way = placed.to_mesh.transform_vector3(along);
            let is_mirrored = placed.to_world.matrix3.determinant() < 0.0;
            for corners in &self.meshes[placed.mesh] {
                let Some((at, is_front)) = hit(corners, start, way) else { continue };
                let is_met = sides == Sides::Both || is_front != is_mirrored;
                if is_met && nearest.is_none_or(|met| at < met.distance) {
                    let [a, b, c] = corners.map(|corner| placed.to_world.transform_point3(corner));
                    let normal = (b - a).cross(c - a).normalize();
                    let normal = normal * -normal.dot(along).signum();
                    nearest = Some(Met { object, distance: at, place: from + along * at, normal });
                }
            }
        }
        nearest
    }
}

/// Returns the distance at which a ray enters a box, in lengths of `along`.
fn enters(bounds: &Aabb, from: DVec3, along: DVec3) -> Option<f64> {
    let low = (bounds.min.as_dvec3() - from) / along;
    let high = (bounds.max.as_dvec3() - from) / along;
    let near = low.min(high).max_element();
    let far = low.max(high).min_element();
    (near <= far && far > 0.0).then_some(near.max(0.0))
}

/// Returns the distance at which a ray meets a triangle, in lengths of `along`, and true for its
/// front.
fn hit(corners: &[DVec3; 3], from: DVec3, along: DVec3) -> Option<(f64, bool)> {
    let [a, b, c] = corners;
    let ab = b - a;
    let ac = c - a;
    let across = along.cross(ac);
    let determinant = ab.dot(across);
    let to_start = from - a;
    let u = to_start.dot(across) / determinant;
    let beside = to_start.cross(ab);
    let v = along.dot(beside) / determinant;
    let at = ac.dot(beside) / determinant;
    let is_met = determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && at > 0.0;
    is_met.then_some((at, determinant > 0.0))
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;
    use crate::shadow_scene;

    #[test]
    fn rays_meet_boxes_where_rays_against_boxes_do() {
        let boxes = shadow_scene::boxes();
        let rays = SceneRays::new(&shadow_scene::scene(&boxes, &[]));
        let size = [48, 36];
        let mut met = 0;
        for pixel in 0..size[0] * size[1] {
            let at = [pixel % size[0], pixel / size[0]].map(|side| f64::from(side) + 0.5);
            let of_boxes = crate::box_rays::shown_at(
                &boxes,
                &shadow_scene::camera(),
                size,
                at.map(|side| side as f32),
            );
            let found = rays.shown_at(&shadow_scene::camera(), size, at);
            assert_eq!(found.is_some(), of_boxes.is_some(), "{at:?}");
            let (Some(found), Some((place, normal))) = (found, of_boxes) else { continue };
            if (found.place.as_vec3() - place).length() < 1e-3 {
                met += u32::from(found.normal.as_vec3().dot(normal) > 0.999);
            }
        }
        assert!(met > size[0] * size[1] / 2, "{met}");
        let up = vec3(0.0, 1.0, 0.0).as_dvec3();
        let under_the_roof = vec3(7.0, 1.0, 0.0).as_dvec3();
        assert!(rays.is_blocked(under_the_roof, up, 2.0));
        assert!(!rays.is_blocked(under_the_roof, up, 1.0));
    }
}
