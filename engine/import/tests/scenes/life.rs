//! Tests of animation: clips, skins, morph targets, and their reach.

use std::ops::ControlFlow;

use animation::{Interpolation, Pose, Skeleton, Values};
use antumbra_import::{GltfScene, Limits, LoadOptions, PlacedNode, load_bytes};
use glam::{Affine3A, Quat, Vec3, vec3};
use serde_json::{Value, json};

use super::geometry::ATTRIBUTES;
use super::loading::{counts, load, notes, refused};
use gltf_files::files::{GltfFile, U8, U16};

/// Returns the triangle with one channel on its node, whose sampler has these keys.
fn animated(
    path: &str,
    times: &[f32],
    kind: &str,
    values: &[f32],
    interpolation: &str,
) -> GltfFile {
    let mut scene = GltfFile::triangle();
    let input = scene.floats("SCALAR", times);
    let output = scene.floats(kind, values);
    let sampler = json!({ "input": input, "output": output, "interpolation": interpolation });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": path } });
    let animation = json!({ "name": "it", "samplers": [sampler], "channels": [channel] });
    scene.set("/animations", json!([animation]));
    scene
}

#[test]
fn tracks_have_the_values_of_the_file() {
    let places = [0.0, 0.0, 0.0, 1.0, 2.0, 3.0];
    let imported = load(&animated("translation", &[0.5, 2.0], "VEC3", &places, "STEP"));
    let clip = &imported.clips[0];
    assert_eq!((clip.name.as_str(), clip.channels[0].node.0), ("it", 0));
    let track = &clip.channels[0].track;
    assert_eq!((track.interpolation, &track.times_s), (Interpolation::Step, &vec![0.5, 2.0]));
    assert_eq!(track.values, Values::Translation(vec![Vec3::ZERO, vec3(1.0, 2.0, 3.0)]));
    assert!(matches!(imported.placements[0].placed, PlacedNode::Object(_)));

    let turns = [0.0, 0.0, 0.0, 9.0, 0.0, 3.0, 0.0, 0.0];
    let imported = load(&animated("rotation", &[0.0, 1.0], "VEC4", &turns, "LINEAR"));
    let expected = Values::Rotation(vec![Quat::IDENTITY, Quat::from_xyzw(0.0, 1.0, 0.0, 0.0)]);
    assert_eq!(imported.clips[0].channels[0].track.values, expected);

    let scales: Vec<f32> = (0..18).map(|value| value as f32).collect();
    let imported = load(&animated("scale", &[0.0, 1.0], "VEC3", &scales, "CUBICSPLINE"));
    let track = &imported.clips[0].channels[0].track;
    assert_eq!(track.interpolation, Interpolation::Cubic);
    let Values::Scale(values) = &track.values else { panic!("{:?}", track.values) };
    assert_eq!((values.len(), values[5]), (6, vec3(15.0, 16.0, 17.0)));
}

#[test]
fn normalised_rotations_are_rotations_and_cubic_tangents_stay_as_they_are() {
    let mut scene = animated("rotation", &[0.0, 1.0], "VEC4", &[0.0; 8], "LINEAR");
    let bytes: Vec<u8> = [0i16, 0, 0, 32767, 0, -32767, 0, 0].map(i16::to_le_bytes).concat();
    let turns = scene.numbers(gltf_files::files::I16, "VEC4", 2, &bytes);
    scene.set(&format!("/accessors/{turns}/normalized"), json!(true));
    scene.set("/animations/0/samplers/0/output", json!(turns));
    let expected = Values::Rotation(vec![Quat::IDENTITY, Quat::from_xyzw(0.0, -1.0, 0.0, 0.0)]);
    assert_eq!(load(&scene).clips[0].channels[0].track.values, expected);

    let keys = [[5.0, 0.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0], [0.0, 7.0, 0.0, 0.0]];
    let cubic = animated("rotation", &[0.0], "VEC4", keys.as_flattened(), "CUBICSPLINE");
    let imported = load(&cubic);
    let Values::Rotation(values) = &imported.clips[0].channels[0].track.values else { panic!() };
    assert_eq!((values[0].x, values[1].z, values[2].y), (5.0, 1.0, 7.0));
}

#[test]
fn clips_with_keys_that_are_no_keys_are_left_out_by_name() {
    let two = [0.0; 6];
    for (times, values, word) in [
        ([1.0, 1.0], two, "key 1 is at 1 s, not later"),
        ([1.0, 0.5], two, "key 1 is at 0.5 s, not later"),
        ([0.0, f32::NAN], two, "key 1 is at NaN s"),
        ([0.0, f32::INFINITY], two, "key 1 is at inf s"),
        ([0.0, 1.0], [0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0], "value 1 is not finite"),
        ([0.0, 1.0], [f32::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0], "value 0 is not finite"),
    ] {
        let imported = load(&animated("translation", &times, "VEC3", &values, "LINEAR"));
        assert_eq!((imported.clips.len(), imported.scene.objects.len()), (0, 1), "{word}");
        let object = "animation 0 (\"it\"), sampler 0";
        assert!(counts(&imported, object, word, 1), "{word}: {:?}", imported.notes);
    }
    let imported = load(&animated("rotation", &[0.0], "VEC4", &[f32::NAN; 4], "LINEAR"));
    assert!(notes(&imported, "value 0 is not finite; the animation is not played"));
    let early = load(&animated("translation", &[-1.0, 0.5], "VEC3", &two, "LINEAR"));
    assert_eq!(early.clips.len(), 1);
    assert!(notes(&early, "a key is before 0 s"));
    let zero = load(&animated("rotation", &[0.0], "VEC4", &[0.0; 4], "LINEAR"));
    assert!(notes(&zero, "a key is a rotation of length 0"));
}

#[test]
fn channels_beyond_what_can_be_played_are_left_out_and_noted() {
    for (times, far) in [([0.0, 1.0], 2e9), ([0.0, 1e10], 1.0)] {
        let values = [0.0, 0.0, 0.0, far, 0.0, 0.0];
        let imported = load(&animated("translation", &times, "VEC3", &values, "LINEAR"));
        assert_eq!((imported.clips.len(), imported.scene.objects.len()), (0, 1));
        let note = "a channel has times or values beyond 1e9, and is left out";
        assert!(notes(&imported, note), "{:?}", imported.notes);
    }
}

#[test]
fn channels_that_cannot_be_are_left_out_and_noted() {
    let places = [0.0, 0.0, 0.0, 1.0, 2.0, 3.0];
    let mut scene = animated("translation", &[0.0, 1.0], "VEC3", &places, "LINEAR");
    let channel =
        |node: u32, path: &str| json!({ "sampler": 0, "target": { "node": node, "path": path } });
    scene.set("/nodes/1", json!({ "name": "elsewhere" }));
    let twice = channel(0, "translation");
    scene.set("/animations/0/channels", json!([twice, twice, channel(1, "translation")]));
    scene.set(
        "/animations/1",
        json!({ "samplers": scene.json["animations"][0]["samplers"],
        "channels": [channel(1, "translation")] }),
    );
    let imported = load(&scene);
    assert_eq!((imported.clips.len(), imported.clips[0].channels.len()), (1, 1));
    for (object, reason, count) in [
        ("animation 0", "a channel moves a node that is not in the scene", 2),
        ("animation 0", "a channel moves what another one moves", 1),
        ("\"animation 1\"", "it moves nothing in the scene", 1),
    ] {
        assert!(counts(&imported, object, reason, count), "{reason}: {:?}", imported.notes);
    }
}

/// Returns a leg of two joints: the root at x = 10, and the foot 2 above it. The triangle's corners
/// follow both.
fn leg(weights: &[f32]) -> GltfFile {
    let mut scene = GltfFile::triangle();
    scene.set(
        "/nodes",
        json!([
            { "mesh": 0, "skin": 0, "translation": [77, 0, 0] },
            { "translation": [10, 0, 0], "children": [2] },
            { "translation": [0, 2, 0], "children": [3] },
            { "translation": [0, 2, 0] },
        ]),
    );
    scene.set("/scenes/0/nodes", json!([0, 1]));
    let bind =
        |y: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -y, 0.0, 1.0];
    let binds = scene.floats("MAT4", [bind(0.0), bind(2.0)].as_flattened());
    scene.set("/skins", json!([{ "joints": [2, 3], "inverseBindMatrices": binds }]));
    let joints = scene.numbers(U8, "VEC4", 3, &[0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 1, 1]);
    let weights = scene.floats("VEC4", weights);
    scene.set(&format!("{ATTRIBUTES}/JOINTS_0"), json!(joints));
    scene.set(&format!("{ATTRIBUTES}/WEIGHTS_0"), json!(weights));
    scene
}

const WEIGHTS: [f32; 12] = [1.0, 0.0, 0.0, 0.0, 0.5, 1.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

/// Returns the world positions of the first skinned object's vertices in a pose.
fn skinned(imported: &GltfScene, pose: &Pose) -> Vec<Vec3> {
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    let placement = &imported.placements[0];
    let (skinned_mesh, skin) = placement.skinned_mesh.expect("a skinned mesh");
    let weights = surfaces.skinned_meshes[skinned_mesh.0 as usize].skin.as_ref().expect("a skin");
    let skin = &imported.skins[skin.expect("a skin")];
    let used: Vec<bool> = (0..weights.joint_count as u16)
        .map(|joint| {
            let named = weights.joints.as_flattened().iter().zip(weights.weights.as_flattened());
            named.into_iter().any(|(named, weight)| *named == joint && *weight > 0.0)
        })
        .collect();
    let skeleton = Skeleton::new(&imported.rig, skin, &used).expect("a skeleton");
    let mut worlds = Vec::new();
    imported.rig.world(pose, &mut worlds);
    let space = skeleton.space().map_or(Affine3A::IDENTITY, |node| worlds[node.0 as usize]);
    let mut matrices = Vec::new();
    skeleton.joint_matrices(&imported.rig, pose, &mut matrices);
    let mesh =
        &imported.scene.meshes[surfaces.skinned_meshes[skinned_mesh.0 as usize].mesh.0 as usize];
    let vertices = mesh.vertices.iter().enumerate();
    let moved = vertices.map(|(place, vertex)| {
        let row = weights.joints[place].iter().zip(&weights.weights[place]);
        let at = Vec3::from_array(vertex.position);
        let sum: Vec3 = row.map(|(j, w)| matrices[usize::from(*j)].transform_point3(at) * *w).sum();
        assert!(placement.reach.contains_point(sum), "{sum} {:?}", placement.reach);
        space.transform_point3(sum)
    });
    moved.collect()
}

#[test]
fn skinned_objects_are_where_their_joints_are() {
    let imported = load(&leg(&WEIGHTS));
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    let skin = surfaces.skinned_meshes[0].skin.as_ref().expect("a skin");
    assert_eq!((skin.joint_count, skin.sets), (2, 1));
    assert_eq!(skin.weights[1], [0.25, 0.75, 0.0, 0.0], "1 together");
    assert_eq!(skin.joints[2], [1, 0, 0, 0], "joints without weight are none");
    assert_eq!(imported.placements[0].node.0, 0, "the node that has the mesh");
    assert_eq!(imported.skins[0].joints.iter().map(|joint| joint.0).collect::<Vec<_>>(), [2, 3]);
    let pose = Pose::new(&imported.rig);
    // The bind pose is 2 below the rest pose: all vertices are lifted by 2 and moved by the root.
    let expected = [vec3(10.0, 2.0, 0.0), vec3(11.0, 2.0, 0.0), vec3(10.0, 3.0, 0.0)];
    assert_eq!(skinned(&imported, &pose), expected);
    // The object is in the space of the topmost joint.
    let translation = Vec3::from(imported.scene.objects[0].transform.translation);
    assert_eq!(translation, vec3(10.0, 2.0, 0.0));
    let bounds = imported.bounds();
    assert!(bounds.min.distance(vec3(10.0, 2.0, 0.0)) < 1e-4, "{bounds:?}");
    assert!(bounds.max.distance(vec3(11.0, 3.0, 0.0)) < 1e-4, "{bounds:?}");
}

#[test]
fn broken_weights_are_repaired_and_noted() {
    let mut broken = WEIGHTS;
    broken[..4].copy_from_slice(&[f32::NAN, 0.0, -1.0, f32::INFINITY]);
    broken[4..8].copy_from_slice(&[0.0; 4]);
    let imported = load(&leg(&broken));
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    let skin = surfaces.skinned_meshes[0].skin.as_ref().expect("a skin");
    assert_eq!(skin.weights[..2], [[1.0, 0.0, 0.0, 0.0]; 2]);
    assert!(notes(&imported, "a vertex has no weight"), "{:?}", imported.notes);
}

#[test]
fn two_sets_of_joints_are_both_used() {
    let mut scene = leg(&WEIGHTS);
    let joints = scene.numbers(U16, "VEC4", 3, &[1, 0, 0, 0, 0, 0, 0, 0].repeat(3));
    let weights = scene.floats("VEC4", &[3.0, 0.0, 0.0, 0.0].repeat(3));
    scene.set(&format!("{ATTRIBUTES}/JOINTS_1"), json!(joints));
    scene.set(&format!("{ATTRIBUTES}/WEIGHTS_1"), json!(weights));
    let imported = load(&scene);
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    let skin = surfaces.skinned_meshes[0].skin.as_ref().expect("a skin");
    assert_eq!((skin.sets, skin.joints.len()), (2, 6));
    assert_eq!(skin.weights[..2], [[0.25, 0.0, 0.0, 0.0], [0.75, 0.0, 0.0, 0.0]]);
    assert_eq!(skin.joints[..2], [[0; 4], [1, 0, 0, 0]]);
}

#[test]
fn skins_that_hold_nothing_are_left_out() {
    let mut scene = leg(&WEIGHTS);
    scene.set("/scenes/0/nodes", json!([0]));
    let said = "skin 0: it has joints outside of the scene or matrices that are not finite";
    assert!(refused(&scene).contains(said), "{}", refused(&scene));
    let mut scene = leg(&WEIGHTS);
    let binds = scene.floats("MAT4", &[f32::NAN; 32]);
    scene.set("/skins/0/inverseBindMatrices", json!(binds));
    assert!(refused(&scene).contains(said), "{}", refused(&scene));
    // Other meshes are still shown.
    scene.push("nodes", json!({ "mesh": scene.json["meshes"].as_array().map_or(0, Vec::len) }));
    scene.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": 0 } }] }));
    let node = scene.json["nodes"].as_array().map_or(0, Vec::len) - 1;
    scene.json["scenes"][0]["nodes"].as_array_mut().expect("roots").push(json!(node));
    let imported = load(&scene);
    assert!(imported.scene.objects.len() == 1 && notes(&imported, "it has joints outside"));
    let mut scene = leg(&WEIGHTS);
    let binds = scene.floats("MAT4", &[0.0; 32]);
    scene.set("/skins/0/inverseBindMatrices", json!(binds));
    assert_eq!(load(&scene).scene.objects.len(), 1, "a point is something that may grow");
}

#[test]
fn skinned_meshes_are_not_shared_and_mirrored_joints_turn_their_winding() {
    let mut scene = leg(&WEIGHTS);
    scene.set("/nodes/4", json!({ "mesh": 0, "skin": 0 }));
    scene.set("/nodes/5", json!({ "mesh": 0 }));
    scene.set("/scenes/0/nodes", json!([0, 1, 4, 5]));
    let imported = load(&scene);
    let meshes: Vec<u32> = imported.scene.objects.iter().map(|object| object.mesh.0).collect();
    assert_eq!((meshes, imported.skins.len()), (vec![0, 1, 2], 1));
    assert_eq!(imported.placements.len(), 2, "the last hangs on no skin");
    let plain = imported.scene.meshes[0].indices.clone();
    scene.set("/nodes/1/scale", json!([-1, 1, 1]));
    let mirrored = load(&scene);
    assert_ne!(mirrored.scene.meshes[0].indices, plain);
    assert_eq!(mirrored.scene.meshes[2].indices, plain);
}

/// Returns the triangle with two morph targets: the first lifts its last corner, the second turns
/// its normals.
fn morphed(change: Value) -> GltfFile {
    let mut scene = GltfFile::triangle();
    let lift = scene.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0]);
    let normal = scene.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let turn = scene.floats("VEC3", &[0.5, 0.0, 0.0].repeat(3));
    scene.set(&format!("{ATTRIBUTES}/NORMAL"), json!(normal));
    scene.set("/meshes/0/primitives/0/targets", json!([{ "POSITION": lift }, { "NORMAL": turn }]));
    let node = scene.json["nodes"][0].as_object_mut().expect("a node");
    node.extend(change.as_object().expect("an object").clone());
    scene
}

#[test]
fn morph_targets_that_count_make_a_mesh_of_its_own() {
    let plain = load(&morphed(json!({})));
    assert_eq!(plain.scene.surfaces.as_ref().expect("surfaces").skinned_meshes.len(), 0);
    assert_eq!(plain.rig.nodes()[0].weights, [0.0, 0.0]);
    let imported = load(&morphed(json!({ "weights": [0.5, 0.0] })));
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    let targets = &surfaces.skinned_meshes[0].targets;
    assert_eq!(targets[0].positions[2], [0.0, 3.0, 0.0]);
    assert_eq!((targets[0].normals.len(), targets[1].positions.len()), (0, 0));
    assert_eq!(targets[1].normals, [[0.5, 0.0, 0.0]; 3]);
    assert_eq!(imported.rig.nodes()[0].weights, [0.5, 0.0]);
    let placement = &imported.placements[0];
    assert!((placement.seen_at_rest.max.y - 2.5).abs() < 1e-5, "{placement:?}");
    assert!(placement.reach.contains(&placement.seen_at_rest), "{placement:?}");
    assert_eq!(imported.bounds(), placement.seen_at_rest);
}

#[test]
fn what_is_blended_and_changes_its_form_is_where_it_is_seen() {
    let mut scene = morphed(json!({ "weights": [0.5, 0.0] }));
    let mut primitive = scene.json["meshes"][0]["primitives"][0].clone();
    primitive["material"] = json!(0);
    scene.set("/materials", json!([{ "alphaMode": "BLEND" }]));
    scene.set("/meshes/0/primitives/0", primitive.clone());
    // Two opaque objects precede it, far away from it.
    primitive.as_object_mut().expect("an object").retain(|key, _| key == "attributes");
    scene.set("/meshes/1", json!({ "primitives": [primitive] }));
    scene.set("/nodes/1", json!({ "mesh": 1, "translation": [-5, 0, 0] }));
    scene.set("/nodes/2", json!({ "mesh": 1, "translation": [5, 0, 0] }));
    scene.set("/scenes/0/nodes", json!([0, 1, 2]));
    let imported = load(&scene);
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    assert_eq!((imported.scene.objects.len(), surfaces.transparent.len()), (2, 1));
    let bounds = imported.bounds();
    assert!((bounds.min.x + 5.0).abs() < 0.01 && (bounds.max.x - 6.0).abs() < 0.01, "{bounds:?}");
    assert!((bounds.max.y - 2.5).abs() < 0.01, "{bounds:?}");
}

#[test]
fn vertices_that_change_their_form_are_limited_where_the_file_has_a_name() {
    let mut scene = morphed(json!({ "weights": [0.5, 0.0] }));
    let node = scene.json["nodes"][0].clone();
    scene.set("/nodes/1", node);
    scene.set("/nodes/1/name", json!("second"));
    scene.set("/scenes/0/nodes", json!([0, 1]));
    let limited = |skinned_vertices| {
        let limits = Limits { skinned_vertices, ..Limits::default() };
        let options = LoadOptions { limits, ..LoadOptions::default() };
        load_bytes(scene.glb(), None, &options, &mut |_| ControlFlow::Continue(()))
    };
    assert!(limited(6).is_ok());
    let said = limited(5).expect_err("two triangles have six vertices").to_string();
    assert!(said.contains("node 1 (\"second\")"), "{said}");
    assert!(said.contains("more than 5 vertices of meshes that change their form"), "{said}");
}

#[test]
fn clips_of_weights_reach_as_far_as_they_say() {
    let mut scene = morphed(json!({}));
    let times = scene.floats("SCALAR", &[0.0, 1.0]);
    let weights = scene.floats("SCALAR", &[0.0, 0.0, 2.0, 0.0]);
    let sampler = json!({ "input": times, "output": weights });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "weights" } });
    scene.set("/animations", json!([{ "samplers": [sampler], "channels": [channel] }]));
    let imported = load(&scene);
    let placement = &imported.placements[0];
    assert!((placement.reach.max.y - 7.0).abs() < 0.01, "{placement:?}");
    assert!((placement.seen_at_rest.max.y - 1.0).abs() < 1e-5, "{placement:?}");
    assert!(placement.reach.contains(&placement.seen_at_rest));
    // The mesh's weights are used if the node has none.
    scene.set("/meshes/0/weights", json!([0.25, 0.5]));
    assert_eq!(load(&scene).rig.nodes()[0].weights, [0.25, 0.5]);
}

#[test]
fn morph_targets_that_are_no_numbers_are_refused_by_name() {
    let mut scene = morphed(json!({ "weights": [0.5, 0.0] }));
    let wrong = scene.floats("VEC3", &[f32::INFINITY; 9]);
    scene.set("/meshes/0/primitives/0/targets/0/POSITION", json!(wrong));
    let said = refused(&scene);
    assert!(said.contains("mesh 0, primitive 0: morph target 0 moves vertex 0"), "{said}");
}

#[test]
fn what_grows_beyond_all_numbers_is_left_out() {
    let mut scene = morphed(json!({ "weights": [0.5, 0.0] }));
    let huge = scene.floats("VEC3", &[1e30; 9]);
    scene.set("/meshes/0/primitives/0/targets/0/POSITION", json!(huge));
    let imported = load(&scene);
    assert!(imported.scene.objects.is_empty());
    assert!(notes(&imported, "it reaches beyond all numbers"), "{:?}", imported.notes);
}
