//! Tests of places: nodes, scenes, instances, lights, cameras, and invalid places.

use std::f32::consts::FRAC_PI_2;

use antumbra_import::GltfScene;
use cull::Projection;
use glam::{Vec3, vec3};
use serde_json::json;

use super::loading::{counts, load, notes};
use gltf_files::files::{F32, GltfFile};

/// Returns the world position of each object's local point (1, 0, 0).
fn tips(imported: &GltfScene) -> Vec<Vec3> {
    let objects = imported.scene.objects.iter();
    objects.map(|object| object.transform.transform_point3(Vec3::X)).collect()
}

fn assert_near(found: &[Vec3], expected: &[Vec3]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!(found.distance(*expected) < 1e-5, "{found} is not {expected}");
    }
}

#[test]
fn transforms_go_down_the_tree_as_parts_and_as_matrices() {
    let mut scene = GltfFile::triangle();
    let half = 0.5_f32.sqrt();
    scene.set(
        "/nodes",
        json!([
            { "name": "root", "translation": [10, 0, 0], "children": [1, 2] },
            { "mesh": 0, "rotation": [0, 0, half * 3.0, half * 3.0], "scale": [2, 1, 1] },
            { "mesh": 0, "matrix": [0, 3, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1] },
        ]),
    );
    let imported = load(&scene);
    assert_near(&tips(&imported), &[vec3(10.0, 2.0, 0.0), vec3(10.0, 3.0, 5.0)]);
    let nodes = imported.rig.nodes();
    assert_eq!((nodes.len(), nodes[0].name.as_str(), nodes[0].parent), (3, "root", None));
    assert!(matches!(nodes[2].rest, animation::Rest::Matrix(_)));
    assert!(imported.placements.is_empty(), "nothing moves");
}

#[test]
fn only_the_chosen_scene_is_shown() {
    let mut scene = GltfFile::triangle();
    scene.set("/nodes", json!([{ "mesh": 0 }, { "mesh": 0, "translation": [5, 0, 0] }]));
    scene.set("/scenes", json!([{ "nodes": [0] }, { "nodes": [1] }]));
    scene.set("/scene", json!(1));
    let imported = load(&scene);
    assert_near(&tips(&imported), &[vec3(6.0, 0.0, 0.0)]);
    assert!(notes(&imported, "of 2 scenes, only scene 1"));
    scene.remove("/scene");
    assert_near(&tips(&load(&scene)), &[Vec3::X]);
    scene.set("/nodes/0/children", json!([1]));
    scene.remove("/scenes");
    assert_near(&tips(&load(&scene)), &[Vec3::X, vec3(6.0, 0.0, 0.0)]);
}

#[test]
fn a_hundred_thousand_nodes_deep_is_not_too_deep() {
    let count = 100_000;
    let mut scene = GltfFile::triangle();
    let node = |index: usize| {
        if index + 1 < count {
            json!({ "children": [index + 1], "translation": [0, 0.5, 0] })
        } else {
            json!({ "mesh": 0 })
        }
    };
    scene.set("/nodes", json!((0..count).map(node).collect::<Vec<_>>()));
    assert_near(&tips(&load(&scene)), &[vec3(1.0, 49999.5, 0.0)]);
}

#[test]
fn places_that_are_none_are_left_out_and_noted() {
    let mut scene = GltfFile::triangle();
    let huge = json!({ "scale": [1e30, 1e30, 1e30], "children": [2] });
    scene.set(
        "/nodes",
        json!([
            { "mesh": 0 },
            huge,
            { "mesh": 0, "scale": [1e30, 1, 1] },
            { "mesh": 0, "scale": [0, 0, 0] },
            { "mesh": 0, "scale": [1, 0, 0] },
            { "mesh": 0, "scale": [1, 1, 0] },
            { "mesh": 0, "translation": [1e16, 0, 0] },
            { "mesh": 0, "rotation": [0, 0, 0, 0], "translation": [0, 7, 0] },
        ]),
    );
    scene.set("/scenes/0/nodes", json!([0, 1, 3, 4, 5, 6, 7]));
    let imported = load(&scene);
    assert_near(&tips(&imported), &[Vec3::X, Vec3::X, vec3(1.0, 7.0, 0.0)]);
    for (object, reason, count) in [
        ("node 2", "its place is beyond all numbers, and it is left out", 1),
        ("node 3", "it is scaled to nothing, and left out", 2),
        ("node 6", "it reaches beyond all numbers, and is left out", 1),
        ("node", "its rotation is of length 0", 1),
    ] {
        assert!(counts(&imported, object, reason, count), "{reason}: {:?}", imported.notes);
    }
}

#[test]
fn instances_are_objects_each() {
    let mut scene = GltfFile::triangle();
    let places = scene.floats("VEC3", &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    let scales = scene.floats("VEC3", &[1.0, 1.0, 1.0, -3.0, 3.0, 3.0]);
    let turns = scene.floats("VEC4", &[0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    let attributes = json!({ "TRANSLATION": places, "SCALE": scales, "ROTATION": turns });
    scene.set("/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes", attributes);
    scene.set("/nodes/0/translation", json!([0, 0, 9]));
    scene.set("/extensionsUsed", json!(["EXT_mesh_gpu_instancing"]));
    let imported = load(&scene);
    assert_near(&tips(&imported), &[vec3(1.0, 1.0, 9.0), vec3(-1.0, 0.0, 9.0)]);
    assert_eq!(imported.scene.meshes.len(), 2, "the second is mirrored");
    assert!(notes(&imported, "an instance has a rotation of length 0"));
    // On a moving node, each instance moves with the node.
    animate(&mut scene, 0);
    let moving = load(&scene);
    let locals: Vec<Vec3> = moving
        .placements
        .iter()
        .map(|placement| placement.local.transform_point3(Vec3::X))
        .collect();
    assert_near(&locals, &[vec3(1.0, 1.0, 0.0), vec3(-1.0, 0.0, 0.0)]);
}

/// Animates the translation of a node.
fn animate(scene: &mut GltfFile, node: usize) {
    let times = scene.floats("SCALAR", &[0.0, 1.0]);
    let places = scene.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let channel = json!({ "sampler": 0, "target": { "node": node, "path": "translation" } });
    let sampler = json!({ "input": times, "output": places });
    scene.set("/animations", json!([{ "samplers": [sampler], "channels": [channel] }]));
}

#[test]
fn what_moves_is_told_and_what_stays_is_not() {
    let mut scene = GltfFile::triangle();
    scene.set(
        "/nodes",
        json!([
            { "children": [1] },
            { "mesh": 0, "scale": [0, 0, 0] },
            { "mesh": 0 },
            { "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [1, 2, 3] },
        ]),
    );
    scene.set("/scenes/0/nodes", json!([0, 2, 3]));
    scene.set("/extensions/KHR_lights_punctual/lights", json!([{ "type": "point" }]));
    scene.set("/extensionsUsed", json!(["KHR_lights_punctual"]));
    animate(&mut scene, 0);
    let imported = load(&scene);
    assert_eq!(imported.scene.objects.len(), 2, "what is nothing now may grow");
    let placed: Vec<_> =
        imported.placements.iter().map(|placement| (placement.node.0, placement.placed)).collect();
    assert_eq!(placed, [(1, antumbra_import::PlacedNode::Object(cull::ObjectId(0)))]);
    let light = imported.scene.surfaces.as_ref().expect("surfaces").lights[0];
    assert_eq!(light.position, vec3(1.0, 2.0, 3.0));
    assert_eq!(light.kind, scene::LightKind::Point);
    animate(&mut scene, 3);
    let placed: Vec<_> = load(&scene).placements.iter().map(|placement| placement.placed).collect();
    assert_eq!(placed, [antumbra_import::PlacedNode::Light(scene::LightId(0))]);
}

#[test]
fn cameras_have_the_names_of_their_nodes() {
    let mut scene = GltfFile::triangle();
    let lens = json!({ "yfov": 0.8, "znear": 0.25 });
    let broken = json!({ "yfov": 9.0, "znear": 0.0 });
    scene.set(
        "/cameras",
        json!([
            { "type": "perspective", "perspective": lens, "name": "lens" },
            { "type": "perspective", "perspective": broken },
        ]),
    );
    scene.set(
        "/nodes",
        json!([
            { "mesh": 0 },
            { "name": "walk", "camera": 0, "translation": [0, 0, 5],
              "rotation": [0, (FRAC_PI_2 / 2.0).sin(), 0, (FRAC_PI_2 / 2.0).cos()] },
            { "camera": 0 },
            { "camera": 1 },
        ]),
    );
    scene.set("/scenes/0/nodes", json!([0, 1, 2, 3]));
    let imported = load(&scene);
    let names: Vec<_> = imported.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["walk", "lens", "camera 1"]);
    let camera = &imported.cameras[0];
    let given = Projection::perspective(0.8);
    assert_eq!((camera.node.0, camera.projection, camera.near_m), (1, given, 0.25));
    let lens = imported.cameras[2].projection;
    assert!(matches!(lens, Projection::Perspective { fov_y } if fov_y < std::f32::consts::PI));
    assert!(imported.cameras[2].near_m > 0.0);
    let seen = imported.default_camera([400, 300]);
    assert!(seen.eye == vec3(0.0, 0.0, 5.0) && seen.forward.distance(Vec3::NEG_X) < 1e-6);
    assert_eq!((seen.projection, seen.near), (given, 0.25));
}

#[test]
fn without_a_camera_the_whole_scene_is_seen_and_without_a_light_there_is_one() {
    let mut scene = GltfFile::triangle();
    scene.set("/nodes/0/scale", json!([100, 100, 100]));
    let imported = load(&scene);
    let camera = imported.default_camera([400, 300]);
    let view = cull::CullView::new(&camera, [400, 300], 8);
    for corner in imported.bounds().corners() {
        let clip = view.view_proj * corner.extend(1.0);
        assert!(clip.w > 0.0 && clip.truncate().truncate().abs().max_element() < clip.w);
    }
    assert_eq!(imported.scene.surfaces.as_ref().expect("surfaces").lights.len(), 1);
    assert_eq!(imported.notes, [], "a light of our own is nothing to tell");
}

#[test]
fn lights_of_physical_strength_are_dimmed_unless_an_exposure_is_given() {
    let mut scene = GltfFile::triangle();
    scene.set("/nodes/0/extensions/KHR_lights_punctual/light", json!(0));
    let light = json!([{ "type": "directional", "intensity": 100_000 }]);
    scene.set("/extensions/KHR_lights_punctual/lights", light);
    scene.set("/extensionsUsed", json!(["KHR_lights_punctual"]));
    let lux = |imported: &antumbra_import::GltfScene| {
        let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
        (surfaces.lights[0].intensity, surfaces.exposure)
    };
    let dimmed = load(&scene);
    // A white surface reflects 1/pi of it.
    assert!((lux(&dimmed).0 - 0.5 * std::f32::consts::PI).abs() < 0.01, "{:?}", lux(&dimmed));
    assert!(notes(&dimmed, "the lights are too bright"), "{:?}", dimmed.notes);
    let options = antumbra_import::LoadOptions { exposure: Some(0.5), ..Default::default() };
    let go_on = &mut |_| std::ops::ControlFlow::Continue(());
    let given = antumbra_import::load_bytes(scene.glb(), None, &options, go_on).expect("loads");
    assert_eq!((lux(&given), given.notes.len()), ((100_000.0, 0.5), 0));
}

#[test]
fn cameras_are_in_the_order_of_the_file_and_called_by_their_numbers_there() {
    let mut scene = GltfFile::triangle();
    let camera =
        |yfov: f32| json!({ "type": "perspective", "perspective": { "yfov": yfov, "znear": 1 } });
    scene.set("/cameras", json!([camera(0.5), camera(0.0), camera(0.75)]));
    scene.set("/nodes", json!([{ "mesh": 0 }, { "camera": 2 }, { "camera": 1 }, { "camera": 0 }]));
    scene.set("/scenes/0/nodes", json!([0, 1, 2, 3]));
    let imported = load(&scene);
    let names: Vec<_> = imported.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["camera 0", "camera 1", "camera 2"]);
    let shown = imported.cameras[1].projection;
    let is_seen = matches!(shown, Projection::Perspective { fov_y } if fov_y > 0.5);
    assert!(is_seen, "an angle of 0 shows nothing");
    assert!(notes(&imported, "its yfov"), "{:?}", imported.notes);
}

#[test]
fn a_flood_of_zeros_is_no_flood_of_memory() {
    let mut scene = GltfFile::triangle();
    let zeros = json!({ "componentType": F32, "type": "VEC3", "count": 1_000_000 });
    let zeros = scene.push("accessors", zeros);
    scene.set("/meshes/0/primitives/0/attributes/POSITION", json!(zeros));
    let imported = load(&scene);
    assert_eq!(imported.scene.meshes[0].vertices.len(), 3);
}
