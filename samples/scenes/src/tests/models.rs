//! Tests of the models of closed parts: the waffle maker and the assembly.

use std::collections::HashMap;

use glam::{Affine3A, Vec3};
use scene::{Mesh, ObjectChange, Scene};

use super::super::{Assembly, PartId, PartTree, assembly, waffle_maker};

/// Returns the triangles of a mesh, as their corners.
fn triangles(mesh: &Mesh) -> impl Iterator<Item = [Vec3; 3]> {
    let at = |index: &u32| Vec3::from_array(mesh.vertices[*index as usize].position);
    mesh.indices.as_chunks::<3>().0.iter().map(move |corners| corners.each_ref().map(at))
}

/// Fails unless each edge of a mesh has two triangles with opposite directions, after welding equal
/// corners, and unless the mesh encloses its inside.
fn assert_closed(mesh: &Mesh) {
    let bits = |position: Vec3| position.to_array().map(f32::to_bits);
    let mut edges: HashMap<_, [u32; 2]> = HashMap::new();
    let mut volume = 0.0;
    for [a, b, c] in triangles(mesh) {
        volume += a.as_dvec3().dot(b.as_dvec3().cross(c.as_dvec3())) / 6.0;
        for (begin, end) in [(a, b), (b, c), (c, a)].map(|(begin, end)| (bits(begin), bits(end))) {
            let is_back = begin > end;
            let key = if is_back { (end, begin) } else { (begin, end) };
            edges.entry(key).or_default()[usize::from(is_back)] += 1;
        }
    }
    let open = edges.values().filter(|sides| **sides != [1, 1]).count();
    assert_eq!(open, 0, "{}: open edges of {}", mesh.name, edges.len());
    assert!(volume > 1e-9, "{}: {volume} m3", mesh.name);
}

/// Fails unless parents precede their children, and each object is exactly one part.
fn assert_tree(tree: &PartTree, scene: &Scene) {
    assert_eq!(tree.nodes[0].parent, None);
    for (place, node) in tree.nodes.iter().enumerate().skip(1) {
        assert!(node.parent.is_some_and(|parent| (parent.0 as usize) < place), "{}", node.name);
        assert!(!node.name.is_empty());
    }
    let objects = tree.objects_of(PartId(0));
    assert_eq!(objects.len(), scene.objects.len());
    assert!(objects.iter().enumerate().all(|(place, object)| object.0 as usize == place));
}

#[test]
fn the_waffle_maker_is_of_closed_parts_true_to_the_millimetre() {
    let made = waffle_maker();
    assert_eq!(made.scene.validate(), Ok(()));
    assert_eq!(made, waffle_maker());
    assert_tree(&made.parts, &made.scene);
    let logo = &made.scene.objects[made.logo.0 as usize];
    for (place, mesh) in made.scene.meshes.iter().enumerate() {
        if place != logo.mesh.0 as usize {
            assert_closed(mesh);
        }
    }
    let body = made.scene.meshes.iter().find(|mesh| mesh.name == "body").unwrap();
    let size = body.bounds.max - body.bounds.min;
    assert!((size.x - 0.30).abs() < 1e-6 && (size.z - 0.25).abs() < 1e-6, "{size}");
    let low = made.scene.objects.iter().map(|object| made.scene.bounds_of(object).unwrap().min.y);
    assert!(low.fold(f32::MAX, f32::min) >= 0.0, "it stands on y = 0");
}

/// A part in the world, for tests of points inside.
struct Shape {
    name: String,
    triangles: Vec<[Vec3; 3]>,
    min: Vec3,
    max: Vec3,
}

impl Shape {
    fn new(mesh: &Mesh, place: Affine3A) -> Self {
        let placed = |corners: [Vec3; 3]| corners.map(|corner| place.transform_point3(corner));
        let triangles: Vec<[Vec3; 3]> = triangles(mesh).map(placed).collect();
        let corners = triangles.as_flattened();
        let min = corners.iter().copied().reduce(Vec3::min).unwrap();
        let max = corners.iter().copied().reduce(Vec3::max).unwrap();
        Self { name: mesh.name.clone(), triangles, min, max }
    }

    /// Returns true if a point is inside: a ray from it leaves once more than it enters.
    fn holds(&self, point: Vec3) -> bool {
        if point.cmplt(self.min).any() || point.cmpgt(self.max).any() {
            return false;
        }
        let towards = Vec3::new(0.531, 0.777, 0.337);
        let meets = |[a, b, c]: &[Vec3; 3]| {
            let [ab, ac, from] = [*b - *a, *c - *a, point - *a].map(|side| side.as_dvec3());
            let across = towards.as_dvec3().cross(ac);
            let determinant = ab.dot(across);
            let u = from.dot(across) / determinant;
            let aside = from.cross(ab);
            let v = towards.as_dvec3().dot(aside) / determinant;
            u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(aside) / determinant > 0.0
        };
        self.triangles.iter().filter(|corners| meets(corners)).count() % 2 == 1
    }

    fn meets(&self, other: &Self) -> bool {
        let apart = self.max.cmplt(other.min).any() || self.min.cmpgt(other.max).any();
        let reaches = |a: &Self, b: &Self| a.triangles.as_flattened().iter().any(|at| b.holds(*at));
        !apart && (reaches(self, other) || reaches(other, self))
    }
}

#[test]
fn the_lid_opens_without_touching_anything() {
    let made = waffle_maker();
    let turning = made.parts.objects_of(made.lid);
    let solids = (0..made.scene.objects.len() as u32).map(cull::ObjectId);
    let solids: Vec<_> = solids.filter(|object| *object != made.logo).collect();
    let shape = |object: &cull::ObjectId, turn: Affine3A| {
        let object = &made.scene.objects[object.0 as usize];
        Shape::new(made.scene.mesh_of(object).unwrap(), turn * object.transform)
    };
    let all: Vec<Shape> = solids.iter().map(|object| shape(object, Affine3A::IDENTITY)).collect();
    for (place, part) in all.iter().enumerate() {
        for other in &all[..place] {
            assert!(!part.meets(other), "{} and {}", part.name, other.name);
        }
    }
    let is_fixed = |object: &&cull::ObjectId| !turning.contains(object);
    let fixed = solids.iter().filter(is_fixed).map(|object| shape(object, Affine3A::IDENTITY));
    let fixed: Vec<Shape> = fixed.collect();
    assert!(turning.len() > 10 && fixed.len() > 10);
    for step in 0..=7_u8 {
        // Beyond about 163 degrees the cable blocks the lid.
        let angle = 2.8 * f32::from(step) / 7.0;
        let turn = made.hinge.turn(angle);
        for object in turning.iter().filter(|object| **object != made.logo) {
            let part = shape(object, turn);
            for other in &fixed {
                assert!(!part.meets(other), "{} and {} at {angle}", part.name, other.name);
            }
        }
    }
    // The grip rises, and no angle exceeds the range.
    assert_eq!(made.opened(9.0), made.opened(made.hinge.open_rad));
    let update = made.opened(1.8);
    assert_eq!(update.objects.len(), turning.len());
    let grip = made.parts.nodes.iter().find(|node| node.name == "grip").unwrap().object.unwrap();
    let moved = update.objects.iter().find_map(|change| match change {
        ObjectChange::Move { object, transform } if *object == grip => {
            Some(transform.translation.y)
        }
        _ => None,
    });
    assert!(moved.unwrap() > 0.3, "{moved:?}");
}

#[test]
fn an_assembly_has_as_many_closed_parts_as_asked_for() {
    for count in [1, 14, 15, 700, 1000, 1401, 9_999] {
        let Assembly { generated, parts } = assembly(count, 3).unwrap();
        assert_eq!(generated.scene.objects.len(), count as usize);
        assert_tree(&parts, &generated.scene);
    }
    let made = assembly(5_000, 3).unwrap();
    assert_eq!(made.generated.scene.validate(), Ok(()));
    assert_eq!(made, assembly(5_000, 3).unwrap(), "the same each time");
    assert_ne!(made.generated.scene, assembly(5_000, 4).unwrap().generated.scene);
    let meshes = &made.generated.scene.meshes;
    assert!((30..=80).contains(&meshes.len()), "{}", meshes.len());
    meshes.iter().for_each(assert_closed);
    let mut users = vec![0; meshes.len()];
    for object in &made.generated.scene.objects {
        users[object.mesh.0 as usize] += 1;
    }
    assert!(users.iter().all(|users| *users > 0), "{users:?}");
    for wanted in ["hall 4", "gear box", "conveyor", "robot cell", "gear train"] {
        assert!(made.parts.nodes.iter().any(|node| node.name == wanted), "{wanted}");
    }
}

#[test]
fn the_parts_of_an_assembly_do_not_meet() {
    let Assembly { generated, .. } = assembly(1_400, 5).unwrap();
    let scene = &generated.scene;
    let shape = |object| Shape::new(scene.mesh_of(object).unwrap(), object.transform);
    let shapes: Vec<Shape> = scene.objects.iter().map(shape).collect();
    let pairs = shapes.iter().enumerate().flat_map(|(place, part)| {
        let meets = |other: &&Shape| part.meets(other);
        shapes[..place].iter().filter(meets).map(|other| (&*part.name, &*other.name))
    });
    let met: std::collections::BTreeSet<(&str, &str)> = pairs.collect();
    assert_eq!(met, std::collections::BTreeSet::new());
}
