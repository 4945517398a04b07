//! The point of a part under a ray, in double precision.

use antumbra::cull::{CullView, Rays, SectionMode, SectionPlane, SectionPlanes};
use antumbra::glam::{Affine3A, DMat3, DVec3, Vec2, Vec3};
use antumbra::scene::Mesh;

/// A ray of a view, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The point on the near plane.
    pub origin: DVec3,
    /// The direction, scaled to one metre of view depth.
    pub along: DVec3,
}

impl Ray {
    /// Returns the ray through the middle of a pixel, counted from the upper left.
    pub fn of_pixel(view: &CullView, x: u32, y: u32) -> Self {
        let [width, height] = view.size.map(|side| side.max(1) as f32);
        let ndc = Vec2::new((x as f32 + 0.5) / width, (y as f32 + 0.5) / height) * 2.0 - 1.0;
        let rays: &Rays = &view.rays;
        let origin = rays.point_f64(ndc, f64::from(rays.near));
        Self { origin, along: rays.along(ndc).as_dvec3() }
    }

    /// Returns the point at a distance in view depth from the near plane.
    pub fn at(&self, depth_m: f64) -> DVec3 {
        self.origin + self.along * depth_m
    }
}

/// Returns the world position of a point of a part, in double precision.
pub fn world_point(transform: &Affine3A, point: Vec3) -> DVec3 {
    let axes = DMat3::from_cols(
        transform.matrix3.x_axis.as_dvec3(),
        transform.matrix3.y_axis.as_dvec3(),
        transform.matrix3.z_axis.as_dvec3(),
    );
    axes * point.as_dvec3() + transform.translation.as_dvec3()
}

/// The largest distance between the exact and the seen point, relative to the distance from the
/// near plane: the error of single-precision depth.
const SEEN_SHARE: f64 = 2e-5;

/// The distance from a section plane within which a point counts as kept, relative to the distance
/// from the near plane: more than the rounding of sums in double precision.
const PLANE_SHARE: f64 = 1e-9;

/// Returns the first point of a part on a ray that may be the seen point: a point of its mesh that
/// the planes keep, or of a cap. `None` if there is none near the seen point.
pub fn hit_part(
    mesh: &Mesh,
    transform: &Affine3A,
    ray: &Ray,
    section: &SectionPlanes,
    seen: DVec3,
) -> Option<DVec3> {
    let planes = section.planes();
    let seen_m = ray.origin.distance(seen);
    let tolerance_m = PLANE_SHARE * (seen_m + seen.abs().max_element());
    let is_kept_by = |plane: &SectionPlane, point: DVec3| distance_m(plane, point) >= -tolerance_m;
    let is_kept = |point: DVec3| match section.mode() {
        _ if planes.is_empty() => true,
        SectionMode::Intersection => planes.iter().all(|plane| is_kept_by(plane, point)),
        SectionMode::Union => planes.iter().any(|plane| is_kept_by(plane, point)),
    };
    let of_mesh: Vec<f64> = face_depths_m(mesh, transform, ray).collect();
    let of_caps = planes.iter().filter_map(|plane| {
        let slope = plane.normal().dot(ray.along);
        let depth_m = -distance_m(plane, ray.origin) / slope;
        // A cap is seen from the removed side, and an odd number of faces lies behind it.
        let behind = of_mesh.iter().filter(|of_face| **of_face > depth_m).count();
        (slope > 0.0 && depth_m >= 0.0 && behind % 2 == 1).then_some(depth_m)
    });
    let near_m = SEEN_SHARE * seen_m;
    let is_seen = |depth_m: &f64| {
        let point = ray.at(*depth_m);
        is_kept(point) && point.distance(seen) <= near_m
    };
    let all = of_mesh.iter().copied().chain(of_caps).filter(is_seen);
    all.min_by(f64::total_cmp).map(|depth_m| ray.at(depth_m))
}

/// Returns the distance of a point from a plane in metres, positive on the kept side.
fn distance_m(plane: &SectionPlane, point: DVec3) -> f64 {
    plane.normal().dot(point) + plane.offset_m()
}

/// Returns the view depths at which a ray hits the triangles of a mesh, from either side, in metres
/// from the near plane.
fn face_depths_m(mesh: &Mesh, transform: &Affine3A, ray: &Ray) -> impl Iterator<Item = f64> {
    let corner = |index: u32| {
        let position = mesh.vertices.get(index as usize)?.position;
        Some(world_point(transform, position.into()))
    };
    let (triangles, _) = mesh.indices.as_chunks::<3>();
    triangles
        .iter()
        .filter_map(move |[a, b, c]| hit_triangle([corner(*a)?, corner(*b)?, corner(*c)?], ray))
}

/// Returns the view depth at which a ray hits a triangle from either side (T. Möller and B.
/// Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997).
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
        let hit =
            |ray: &Ray, seen| hit_part(&mesh, &transform, ray, &SectionPlanes::default(), seen);
        assert_eq!(hit(&ray(0.0, -1.0), seen), Some(DVec3::new(0.25, 0.25, -5.0)));
        assert!(hit(&ray(-9.0, 1.0), seen).is_some());
        assert!(hit(&ray(-9.0, -1.0), seen).is_none());
        assert!(hit(&ray(0.0, -1.0), seen + DVec3::Z).is_none());
        let beside = Ray { origin: DVec3::new(0.9, 0.9, 0.0), along: DVec3::NEG_Z };
        assert!(hit(&beside, seen).is_none());
    }

    #[test]
    fn on_a_cap_the_point_is_the_planes_and_never_one_that_was_cut_away() {
        // Two sides of a part, 10 mm apart, seen from 200 m: the depth is accurate to 4 mm.
        let grey = [0.5; 3];
        let corners = [0.0, -0.01].map(|z| {
            [[-1.0, -1.0, z], [3.0, -1.0, z], [-1.0, 3.0, z]].map(|corner| (corner, grey))
        });
        let mesh = Mesh::of_triangles("part", corners.as_flattened());
        let ray = Ray { origin: DVec3::new(0.1, 0.1, 200.0), along: DVec3::NEG_Z };
        let hit = |mode, planes: &[(DVec3, f64)], seen_m: f64| {
            let planes: Vec<SectionPlane> = planes
                .iter()
                .map(|(normal, offset_m)| SectionPlane::new(*normal, *offset_m).unwrap())
                .collect();
            let section = SectionPlanes::new(&planes, mode).unwrap();
            let seen = DVec3::new(0.1, 0.1, seen_m);
            hit_part(&mesh, &Affine3A::IDENTITY, &ray, &section, seen).map(|point| point.z)
        };
        let both = SectionMode::Intersection;
        assert_eq!(hit(both, &[], -0.001), Some(0.0));
        // The planes keep what lies below -1 mm, and then below -8.5 mm.
        for (offset_m, seen_m) in [(-0.001, -0.001_5), (-0.008_5, -0.009_9)] {
            let point = hit(both, &[(DVec3::NEG_Z, offset_m)], seen_m).unwrap();
            assert!((point - offset_m).abs() < 1e-12, "{point}");
        }
        // A cap that another plane removes does not count.
        let removed = [(DVec3::NEG_Z, -0.001), (DVec3::NEG_X, 0.0)];
        assert_eq!(hit(both, &removed, -0.001), None);
        assert!(hit(SectionMode::Union, &removed, -0.001_5).is_some());
    }

    #[test]
    fn a_thousand_kilometres_away_points_are_as_exact() {
        // 1e6 m and the corners are exact in single precision, their sums are not.
        let mesh = triangle();
        let transform = Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.01),
            antumbra::glam::Quat::IDENTITY,
            vec3(1.0e6, 0.0, 0.0),
        );
        let origin = DVec3::new(1.0e6 + 0.002_5, 0.002_5, 5.0);
        let ray = Ray { origin, along: DVec3::NEG_Z };
        let seen = DVec3::new(origin.x, origin.y, 0.0);
        let hit = hit_part(&mesh, &transform, &ray, &SectionPlanes::default(), seen).unwrap();
        assert_eq!((hit.x, hit.z), (origin.x, 0.0));
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
            let view = CullView::new(&camera, [101, 51], 8);
            let ray = Ray::of_pixel(&view, 50, 25);
            assert!((ray.at(1.0) - DVec3::new(0.0, 0.0, ray.origin.z - 1.0)).length() < 1e-6);
            let corner =
                view.view_proj.project_point3(Ray::of_pixel(&view, 0, 50).at(2.0).as_vec3());
            let expected = Vec3::new(1.0 / 101.0 - 1.0, 101.0 / 51.0 - 1.0, corner.z);
            assert!(corner.distance(expected) < 1e-5, "{corner}");
        }
    }
}
