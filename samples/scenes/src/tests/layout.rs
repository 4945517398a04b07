//! Tests that scenes have the requested number of objects and are reproducible, and that no objects
//! touch.

use cull::Aabb;
use glam::{Affine3A, Quat, Vec3, vec3};
use scene::{Object, Scene, SceneError};

use super::super::{GeneratedScene, GeneratorError, MAX_OBJECTS, city, field};
use super::{Boxes, is_ground};

const COUNTS: [u32; 18] =
    [1, 2, 3, 17, 18, 23, 34, 35, 36, 46, 92, 207, 500, 1000, 4321, 9999, 10_000, 60_000];

type Generator = fn(u32, u64) -> Result<GeneratedScene, GeneratorError>;

const GENERATORS: [Generator; 2] = [city, field];

#[test]
fn scenes_have_as_many_objects_as_asked_for_and_can_be_drawn() {
    for generate in GENERATORS {
        for count in COUNTS {
            let scene = generate(count, u64::from(count)).unwrap().scene;
            assert_eq!(scene.objects.len(), count as usize, "{}", scene.name);
            scene.validate().unwrap();
            assert!(scene.triangles() > 0);
        }
    }
}

#[test]
fn a_large_scene_is_made_and_one_beyond_the_limit_refused() {
    const LARGE: u32 = 2_000_000;
    for generate in GENERATORS {
        assert_eq!(generate(LARGE, 1).unwrap().scene.objects.len(), LARGE as usize);
        for asked in [0, MAX_OBJECTS + 1, u32::MAX] {
            assert_eq!(generate(asked, 1), Err(GeneratorError::ObjectCount { asked }));
        }
    }
}

#[test]
fn the_seed_decides_everything() {
    for generate in GENERATORS {
        let scene = generate(3000, 11).unwrap().scene;
        assert_eq!(scene, generate(3000, 11).unwrap().scene);
        let other = generate(3000, 12).unwrap().scene;
        let changed = scene.objects.iter().zip(&other.objects).filter(|(a, b)| a != b).count();
        assert!(changed > 2000, "{changed} of 3000 changed");
    }
}

#[test]
fn blocks_hold_what_a_city_needs() {
    let scene = city(20_000, 5).unwrap().scene;
    let is_high = |object: &&Object| scene.bounds_of(object).unwrap().max.y > 12.0;
    let grounds = scene.objects.iter().filter(|object| is_ground(&scene, object)).count();
    let buildings = scene.objects.iter().filter(is_high).count();
    let props = scene.objects.len() - grounds - buildings;
    let per_block = |count: usize| count as f64 / grounds as f64;
    assert!((5.0..=10.0).contains(&per_block(buildings)), "{} buildings", per_block(buildings));
    assert!((12.0..=18.0).contains(&per_block(props)), "{} props", per_block(props));
}

fn assert_apart(scene: &Scene) {
    // Enlarged by half of the least distance: objects are at least 0.2 m apart.
    let boxes = Boxes::new(scene, 0.1, |object| !is_ground(scene, object));
    let overlap = |a: &Aabb, b: &Aabb| a.min.cmplt(b.max).all() && b.min.cmplt(a.max).all();
    for numbers in boxes.cells.values() {
        for (position, &a) in numbers.iter().enumerate() {
            for &b in &numbers[position + 1..] {
                let a = &boxes.bounds[a as usize];
                let b = &boxes.bounds[b as usize];
                assert!(
                    !overlap(a, b),
                    "{} of {} objects: {a:?} and {b:?}",
                    scene.name,
                    scene.objects.len()
                );
            }
        }
    }
}

#[test]
fn no_two_objects_touch() {
    for generate in GENERATORS {
        for count in COUNTS {
            for seed in 0..4 {
                assert_apart(&generate(count, seed).unwrap().scene);
            }
        }
    }
}

/// Returns the height of the surface below an object: the road, or the pavement if the whole box is
/// over it. Returns `None` for an object over both.
fn carrier_m(scene: &Scene, bounds: &Aabb) -> Option<f32> {
    if scene.name == "field" {
        return Some(0.0);
    }
    let from_middle = |value: f32| (value.rem_euclid(64.0) - 32.0).abs();
    let corners = [bounds.min, bounds.max];
    let inside = corners.map(|corner| from_middle(corner.x).max(from_middle(corner.z)) < 26.0);
    let same_block = corners.map(|corner| (corner / 64.0).floor() * vec3(1.0, 0.0, 1.0));
    if inside == [true, true] && same_block[0] == same_block[1] {
        return Some(0.125);
    }
    // A box on the road must be completely on one side of each kerb.
    let beyond = |low: f32, high: f32| {
        let line = ((low + high) / 128.0).round() * 64.0;
        line - 6.0 < low && high < line + 6.0
    };
    let in_road = beyond(bounds.min.x, bounds.max.x) || beyond(bounds.min.z, bounds.max.z);
    in_road.then_some(0.0)
}

#[test]
fn things_hover_two_centimetres_over_what_carries_them() {
    for generate in GENERATORS {
        for count in [34, 500, 20_000] {
            let scene = generate(count, 3).unwrap().scene;
            for object in scene.objects.iter().filter(|object| !is_ground(&scene, object)) {
                let bounds = scene.bounds_of(object).unwrap();
                let carrier = carrier_m(&scene, &bounds).unwrap();
                let gap = bounds.min.y - carrier;
                assert!((gap - 0.02).abs() < 1e-4, "{gap} under {bounds:?}");
            }
        }
    }
}

#[test]
fn bounds_hold_every_transformed_vertex() {
    let mut scene = city(400, 2).unwrap().scene;
    for (number, object) in scene.objects.iter_mut().enumerate() {
        if number % 3 == 0 {
            let turn = Quat::from_euler(glam::EulerRot::YXZ, number as f32, 0.3, -0.2);
            let move_to = Vec3::splat(number as f32 * 7.3);
            object.transform =
                Affine3A::from_scale_rotation_translation(vec3(1.0, 2.0, 0.5), turn, move_to);
        }
    }
    for object in &scene.objects {
        let bounds = scene.bounds_of(object).unwrap();
        for vertex in &scene.mesh_of(object).unwrap().vertices {
            let point = object.transform.transform_point3(Vec3::from_array(vertex.position));
            assert!(point.cmpge(bounds.min).all() && point.cmple(bounds.max).all());
        }
    }
}

#[test]
fn what_cannot_be_drawn_is_named() {
    let scene = city(50, 1).unwrap().scene;
    let mut broken = scene.clone();
    broken.meshes[2].indices[0] = u32::MAX;
    assert!(matches!(broken.validate(), Err(SceneError::BrokenMesh { .. })));
    let mut broken = scene.clone();
    broken.objects[7].mesh.0 = 9999;
    assert!(matches!(broken.validate(), Err(SceneError::BrokenObject { index: 7, .. })));
    let mut broken = scene.clone();
    broken.objects[9].transform.translation.y = f32::NAN;
    assert!(matches!(broken.validate(), Err(SceneError::BrokenObject { index: 9, .. })));
    let mut broken = scene;
    broken.meshes[1].vertices[3].position[1] = f32::INFINITY;
    assert!(matches!(broken.validate(), Err(SceneError::BrokenMesh { .. })));
}
