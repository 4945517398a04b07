//! Tests that every mesh is within its budget, closed as far as it is visible, and faces outwards.

use glam::Vec3;
use scene::{Mesh, unpack_normal};

use super::super::random::Random;
use super::super::{city, field};

fn all_meshes() -> Vec<Mesh> {
    let mut meshes = city(1, 0).unwrap().scene.meshes;
    meshes.extend(field(1, 0).unwrap().scene.meshes);
    meshes
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [Vec3; 3]> {
    let position = |index: u32| Vec3::from_array(mesh.vertices[index as usize].position);
    mesh.indices
        .chunks_exact(3)
        .map(move |indices| [0, 1, 2].map(|corner| position(indices[corner])))
}

#[test]
fn triangles_keep_to_their_budgets() {
    let mut counts = [0; 3];
    for mesh in city(1, 0).unwrap().scene.meshes {
        let (kind, budget) = if mesh.name.starts_with("ground") {
            (0, 500..=1000)
        } else if mesh.bounds.max.y > 12.0 {
            (1, 1000..=2000)
        } else {
            (2, 200..=900)
        };
        counts[kind] += 1;
        assert!(
            budget.contains(&mesh.triangles()),
            "{}: {} triangles",
            mesh.name,
            mesh.triangles()
        );
        assert!(
            mesh.vertices.len() as u64 <= 2 * mesh.triangles(),
            "{} repeats vertices",
            mesh.name
        );
    }
    let [grounds, buildings, props] = counts;
    assert!(grounds == 2 && (16..=24).contains(&buildings) && props >= 10, "{counts:?}");
    for mesh in field(1, 0).unwrap().scene.meshes {
        assert!((90..=1000).contains(&mesh.triangles()), "{}: {}", mesh.name, mesh.triangles());
        assert!(mesh.bounds.max.y < 8.0, "{} is too high for a field", mesh.name);
    }
}

#[test]
fn triangles_face_the_way_their_normals_do() {
    for mesh in all_meshes() {
        let normals = mesh.indices.chunks_exact(3).map(|indices| {
            [0, 1, 2].map(|corner| unpack_normal(mesh.vertices[indices[corner] as usize].normal))
        });
        for ([a, b, c], normals) in corners(&mesh).zip(normals) {
            let face = (b - a).cross(c - a);
            assert!(face.length() > 1e-6, "{}: a triangle without area at {a}", mesh.name);
            for normal in normals {
                assert!((normal.length() - 1.0).abs() < 0.02, "{}: {normal}", mesh.name);
                assert!(face.normalize().dot(normal) > 0.2, "{}: {normal} at {a}", mesh.name);
            }
        }
    }
}

/// Returns the distance at which a ray hits a triangle (Moeller and Trumbore, 1997), and true if it
/// hits the front. In double precision, since in single precision rays pass between slender
/// triangles.
fn meet(eye: Vec3, towards: Vec3, corners: [Vec3; 3]) -> Option<(f64, bool)> {
    let eye = eye.as_dvec3();
    let towards = towards.as_dvec3();
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let ab = b - a;
    let ac = c - a;
    let across = towards.cross(ac);
    let determinant = ab.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let from_a = eye - a;
    let u = from_a.dot(across) / determinant;
    let aside = from_a.cross(ab);
    let v = towards.dot(aside) / determinant;
    let distance = ac.dot(aside) / determinant;
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0;
    inside.then_some((distance, determinant > 0.0))
}

#[test]
fn nobody_sees_the_back_of_a_face() {
    for mesh in all_meshes() {
        let triangles: Vec<[Vec3; 3]> = corners(&mesh).collect();
        let min = mesh.bounds.min;
        let max = mesh.bounds.max;
        let size = (max - min).length();
        let mut random = Random::keyed(9, &[mesh.indices.len() as i64]);
        let mut hits = 0;
        for _ in 0..1200 {
            // From anywhere above the ground.
            let turn = random.between(0.0, std::f32::consts::TAU);
            let height = random.unit() * random.unit();
            let outward = Vec3::new(turn.cos(), height, turn.sin()).normalize();
            let mut eye = (min + max) / 2.0 + outward * size * random.between(0.6, 1.5);
            eye.y = eye.y.max(min.y + 0.05);
            let share = Vec3::new(random.unit(), random.unit(), random.unit());
            let towards = (min + (max - min) * share - eye).normalize();
            let met = triangles.iter().filter_map(|&corners| meet(eye, towards, corners));
            let mut front = f64::INFINITY;
            let mut back = f64::INFINITY;
            for (distance, is_front) in met {
                let nearest = if is_front { &mut front } else { &mut back };
                *nearest = nearest.min(distance);
            }
            hits += u32::from(front.is_finite());
            // Thin sheets have both faces at the same place.
            let seen = back + 1e-3 < front;
            assert!(!seen, "{}: a back at {}, from {eye}", mesh.name, eye + towards * back as f32);
        }
        assert!(hits > 30, "{}: only {hits} hits", mesh.name);
    }
}
