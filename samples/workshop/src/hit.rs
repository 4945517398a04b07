//! The point of a part under a ray, in double precision.

use antumbra::cull::{Rays, View};
use antumbra::glam::{Affine3A, DMat3, DVec3, Vec2, Vec3};
use antumbra::scene::Mesh;

/// A ray of a view, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The point on the near plane.
    pub origin: DVec3,
    /// The direction, over one metre of view depth.
    pub along: DVec3,
}

impl Ray {
    /// Returns the ray through the middle of a pixel, counted from the upper left.
    pub fn of_pixel(view: &View, x: u32, y: u32) -> Self {
        let [width, height] = view.size.map(|side| side.max(1) as f32);
        let ndc = Vec2::new((x as f32 + 0.5) / width, (y as f32 + 0.5) / height) * 2.0 - 1.0;
        let rays: &Rays = &view.rays;
        let origin = rays.point_f64(ndc, f64::from(rays.near));
        Self { origin, along: rays.along(ndc).as_dvec3() }
    }

    /// Returns the point at a view depth behind the near plane.
    pub fn at(&self, depth_m: f64) -> DVec3 {
        self.origin + self.along * depth_m
    }
}

/// Returns where a point of a part lies in the world, in double precision.
pub fn world_point(transform: &Affine3A, point: Vec3) -> DVec3 {
    let axes = DMat3::from_cols(
        transform.matrix3.x_axis.as_dvec3(),
        transform.matrix3.y_axis.as_dvec3(),
        transform.matrix3.z_axis.as_dvec3(),
    );
    axes * point.as_dvec3() + transform.translation.as_dvec3()
}

/// A point of a mesh on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The view depth behind the near plane, in metres.
    pub depth_m: f64,
    /// The point, in metres.
    pub point: DVec3,
    /// The number of the triangle of the mesh.
    pub triangle: usize,
}

/// The largest distance of the exact point from the seen one, as a share of the distance from the
/// near plane: what single-precision depth loses. A cap of a section may lie little deeper.
const SEEN_SHARE: f64 = 2e-5;

/// Returns the point of a mesh on a ray, on either side of its triangles, that lies nearest to a
/// point that was seen there; `None` if none lies near it, as where the mesh was cut.
pub fn hit_mesh(mesh: &Mesh, transform: &Affine3A, ray: &Ray, seen: DVec3) -> Option<Hit> {
    let corner = |index: u32| {
        let position = mesh.vertices.get(index as usize)?.position;
        Some(world_point(transform, position.into()))
    };
    let (triangles, _) = mesh.indices.as_chunks::<3>();
    let hits = triangles.iter().enumerate().filter_map(|(triangle, [a, b, c])| {
        let depth_m = hit_triangle([corner(*a)?, corner(*b)?, corner(*c)?], ray)?;
        Some(Hit { depth_m, point: ray.at(depth_m), triangle })
    });
    let apart = |hit: &Hit| hit.point.distance(seen);
    let nearest = hits.min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    (apart(&nearest) <= SEEN_SHARE * ray.origin.distance(seen)).then_some(nearest)
}

/// Returns the view depth at which a ray meets a triangle from either side (T. Möller and
/// B. Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997).
fn hit_triangle(corners: [DVec3; 3], ray: &Ray) -> Option<f64> {
    let [a, b, c] = corners;
    let ab = b - a;
    let ac = c - a;
    let across = ray.along.cross(ac);
    let volume = ab.dot(across);
    if volume == 0.0 {
        return None;
    }
    let from_a = ray.origin - a;
    let weight_b = from_a.dot(across) / volume;
    let sideways = from_a.cross(ab);
    let weight_c = ray.along.dot(sideways) / volume;
    if weight_b < 0.0 || weight_c < 0.0 || weight_b + weight_c > 1.0 {
        return None;
    }
    let depth_m = ac.dot(sideways) / volume;
    (depth_m >= 0.0).then_some(depth_m)
}

#[cfg(test)]
mod tests {
    use antumbra::glam::vec3;

    use super::*;

    fn triangle() -> Mesh {
        let grey = [0.5; 3];
        let corners = [([0.0, 0.0, 0.0], grey), ([1.0, 0.0, 0.0], grey), ([0.0, 1.0, 0.0], grey)];
        Mesh::of_triangles("triangle", &corners)
    }

    #[test]
    fn the_point_that_was_seen_is_found_on_both_sides() {
        let mesh = triangle();
        let transform = Affine3A::from_translation(vec3(0.0, 0.0, -5.0));
        let ray = |z: f64, along: f64| Ray {
            origin: DVec3::new(0.25, 0.25, z),
            along: DVec3::new(0.0, 0.0, along),
        };
        let seen = DVec3::new(0.25, 0.25, -5.000_05);
        let hit = hit_mesh(&mesh, &transform, &ray(0.0, -1.0), seen).unwrap();
        assert_eq!((hit.depth_m, hit.point.z, hit.triangle), (5.0, -5.0, 0));
        assert!(hit_mesh(&mesh, &transform, &ray(-9.0, 1.0), seen).is_some());
        assert!(hit_mesh(&mesh, &transform, &ray(-9.0, -1.0), seen).is_none());
        assert!(hit_mesh(&mesh, &transform, &ray(0.0, -1.0), seen + DVec3::Z).is_none());
        let beside = Ray { origin: DVec3::new(0.9, 0.9, 0.0), along: DVec3::NEG_Z };
        assert!(hit_mesh(&mesh, &transform, &beside, seen).is_none());
    }

    #[test]
    fn a_thousand_kilometres_away_points_are_as_exact() {
        // 1e6 m and the places of the corners are numbers of single precision, their sums are not.
        let mesh = triangle();
        let transform = Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.01),
            antumbra::glam::Quat::IDENTITY,
            vec3(1.0e6, 0.0, 0.0),
        );
        let origin = DVec3::new(1.0e6 + 0.002_5, 0.002_5, 5.0);
        let ray = Ray { origin, along: DVec3::NEG_Z };
        let hit = hit_mesh(&mesh, &transform, &ray, DVec3::new(origin.x, origin.y, 0.0)).unwrap();
        assert_eq!((hit.point.x, hit.point.z), (origin.x, 0.0));
    }

    #[test]
    fn rays_of_pixels_go_through_the_view() {
        use antumbra::{Camera, Projection};
        for projection in
            [Projection::perspective(1.0), Projection::Orthographic { height: 2.0, far: 9.0 }]
        {
            let eye = Vec3::Z * 3.0;
            let forward = Vec3::NEG_Z;
            let up = Vec3::Y;
            let camera = Camera { eye, forward, up, projection, near: 0.5 };
            let view = View::new(&camera, [101, 51], 8);
            let ray = Ray::of_pixel(&view, 50, 25);
            assert!((ray.at(1.0) - DVec3::new(0.0, 0.0, ray.origin.z - 1.0)).length() < 1e-6);
            let corner =
                view.view_proj.project_point3(Ray::of_pixel(&view, 0, 50).at(2.0).as_vec3());
            let expected = Vec3::new(1.0 / 101.0 - 1.0, 101.0 / 51.0 - 1.0, corner.z);
            assert!(corner.distance(expected) < 1e-5, "{corner}");
        }
    }
}
