//! Tests of clips that move too far, limits that only renderers have, and odd but valid files.

use std::ops::ControlFlow;

use antumbra_import::{
    Cause, GltfScene, ImportError, Limits, LoadOptions, SceneAnimator, Stage, load_bytes, read,
};
use serde_json::{Value, json};

use gltf_files::chains::chains;
use gltf_files::files::{F32, GltfFile, U8, encoded};
use gltf_files::loaded;
use gltf_files::playback::play;

fn load_with(scene: &GltfFile, limits: Limits) -> Result<GltfScene, ImportError> {
    let options = LoadOptions { limits, ..LoadOptions::default() };
    load_bytes(scene.glb(), None, &options, &mut |_| ControlFlow::Continue(()))
}

fn load(scene: &GltfFile) -> GltfScene {
    let imported = load_with(scene, Limits::default()).unwrap_or_else(|error| panic!("{error}"));
    loaded::check(&imported);
    imported
}

/// Returns a clip that animates translations or scales of nodes between these values.
fn clip(scene: &mut GltfFile, name: &str, channels: &[(usize, &str, [f32; 6])]) -> Value {
    let times = scene.floats("SCALAR", &[0.0, 1.0]);
    let mut samplers = Vec::new();
    let mut list = Vec::new();
    for (number, (node, path, values)) in channels.iter().enumerate() {
        let output = scene.floats("VEC3", values);
        samplers.push(json!({ "input": times, "output": output }));
        list.push(json!({ "sampler": number, "target": { "node": node, "path": path } }));
    }
    json!({ "name": name, "samplers": samplers, "channels": list })
}

const GROWS: [f32; 6] = [1.0, 1.0, 1.0, 1e9, 1e9, 1e9];
const LEAVES: [f32; 6] = [0.0, 0.0, 0.0, 1e9, 0.0, 0.0];

/// Returns a triangle on a node (1) below another (0).
fn arm() -> GltfFile {
    let mut scene = GltfFile::triangle();
    scene.set("/nodes", json!([{ "children": [1] }, { "mesh": 0, "name": "hand" }, { "mesh": 0 }]));
    scene.set("/scenes/0/nodes", json!([0, 2]));
    scene
}

#[test]
fn a_clip_that_goes_too_far_is_not_played_and_the_others_are() {
    let mut scene = arm();
    let far = clip(&mut scene, "far", &[(0, "scale", GROWS), (1, "translation", LEAVES)]);
    let near = clip(&mut scene, "near", &[(1, "translation", [0.0, 0.0, 0.0, 1.0, 0.0, 0.0])]);
    scene.set("/animations", json!([far, near]));
    let imported = load(&scene);
    let names: Vec<&str> = imported.clips.iter().map(|clip| clip.name.as_str()).collect();
    assert_eq!(names, ["near"]);
    let note = imported.notes.iter().find(|note| note.reason.contains("not played"));
    let object = &note.expect("a note").object;
    assert!(object.contains("\"far\"") && object.contains("hand"), "{object}");
    play(imported);
}

#[test]
fn clips_that_go_too_far_only_together_do_not_play_together() {
    let mut scene = arm();
    let grows = clip(&mut scene, "grows", &[(0, "scale", GROWS)]);
    let leaves = clip(&mut scene, "leaves", &[(1, "translation", LEAVES)]);
    scene.set("/animations", json!([grows, leaves]));
    let imported = load(&scene);
    assert_eq!(imported.clips.len(), 1, "while one fades into the other, it would be at 1e18");
    play(imported);
    // Each clip alone is allowed.
    scene.set("/animations/0/channels/0/target/node", json!(2));
    let imported = load(&scene);
    assert_eq!(imported.clips.len(), 2, "{:?}", imported.notes);
    play(imported);
}

#[test]
fn long_chains_of_matrices_are_not_too_far() {
    let mut scene = GltfFile::triangle();
    let turned = [0.6, 0.8, 0.0, 0.0, -0.8, 0.6, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let link = |child: usize| json!({ "children": [child], "matrix": turned });
    let mut nodes: Vec<Value> = (1..300).map(link).collect();
    nodes.push(json!({ "mesh": 0 }));
    scene.set("/nodes", json!(nodes));
    let near = clip(&mut scene, "near", &[(299, "translation", [0.0, 0.0, 0.0, 1.0, 0.0, 0.0])]);
    scene.set("/animations", json!([near]));
    let imported = load(&scene);
    assert_eq!(imported.clips.len(), 1, "{:?}", imported.notes);
    play(imported);
}

/// Returns several places of a mesh with a morph target that a clip animates.
fn instanced(count: usize) -> GltfFile {
    let mut scene = GltfFile::triangle();
    scene.set("/meshes/0/primitives/0/targets", json!([{ "POSITION": 0 }]));
    let places = json!({ "componentType": F32, "type": "VEC3", "count": count });
    let places = scene.push("accessors", places);
    scene.set(
        "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes",
        json!({ "TRANSLATION": places }),
    );
    scene.set("/extensionsUsed", json!(["EXT_mesh_gpu_instancing"]));
    let times = scene.floats("SCALAR", &[0.0, 1.0]);
    let weights = scene.floats("SCALAR", &[0.0, 2.0]);
    let sampler = json!({ "input": times, "output": weights });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "weights" } });
    scene.set("/animations", json!([{ "samplers": [sampler], "channels": [channel] }]));
    scene
}

#[test]
fn progress_is_told_within_a_node_and_instances_reach_equally_far() {
    let scene = instanced(2000);
    let mut told = 0;
    let options = LoadOptions::default();
    let imported = load_bytes(scene.glb(), None, &options, &mut |progress| {
        told += usize::from(progress.stage == Stage::Meshes);
        ControlFlow::Continue(())
    });
    let imported = imported.unwrap_or_else(|error| panic!("{error}"));
    assert!(told >= 7, "told {told} times");
    assert_eq!(imported.placements.len(), 2000);
    let first = imported.placements[0].reach;
    assert!(imported.placements.iter().all(|placement| placement.reach == first));
    assert!((first.max.x - 3.0).abs() < 0.1, "{first:?}");
    loaded::check(&imported);
    play(imported);
    let mut left = 3;
    let error = load_bytes(scene.glb(), None, &options, &mut |_| {
        left -= 1;
        if left > 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    assert_eq!(error.map(drop).expect_err("broken off").cause, Cause::GivenUp);
}

#[test]
fn lights_are_counted_where_the_file_has_a_name() {
    let mut scene = GltfFile::triangle();
    scene.set("/extensionsUsed", json!(["KHR_lights_punctual"]));
    scene.set("/extensions/KHR_lights_punctual/lights", json!([{ "type": "point" }]));
    let light = json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    scene.set("/nodes", json!(vec![light; 20]));
    scene.set("/scenes/0/nodes", json!((0..20).collect::<Vec<_>>()));
    assert_eq!(load(&scene).scene.surfaces.expect("surfaces").lights.len(), 20);
    let error = load_with(&scene, Limits { lights: 19, ..Limits::default() }).map(drop);
    let error = error.expect_err("too many").to_string();
    assert!(
        error.contains("node 19: lights in the scene: 20, more than the limit of 19"),
        "{error}"
    );
}

#[test]
fn bones_are_counted_once_for_all_that_hangs_on_them() {
    let scene = chains(2, 50, 30, 1);
    let limits = |bones| Limits { bones, ..Limits::default() };
    assert_eq!(load(&scene).placements.len(), 30);
    load_with(&scene, limits(100)).unwrap_or_else(|error| panic!("{error}"));
    let error = load_with(&scene, limits(99)).map(drop).expect_err("100 bones").to_string();
    assert!(error.contains("mesh 0, primitive 0: bones up to it"), "{error}");
    assert!(error.contains("100, more than the limit of 99"), "{error}");
    // Several skins have separate bones.
    let several = chains(2, 50, 30, 3);
    load_with(&several, limits(300)).unwrap_or_else(|error| panic!("{error}"));
    assert!(load_with(&several, limits(250)).is_err());
    play(load(&several));
}

#[test]
fn joints_without_weight_may_be_any_and_others_must_be_there() {
    let skinned = |joints: [u8; 12]| {
        let mut scene = GltfFile::triangle();
        let joints = scene.numbers(U8, "VEC4", 3, &joints);
        let weights = scene.floats("VEC4", &[[1.0, 0.0, 0.0, 0.0]; 3].concat());
        scene.set("/meshes/0/primitives/0/attributes/JOINTS_0", json!(joints));
        scene.set("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(weights));
        scene.set("/nodes", json!([{ "mesh": 0, "skin": 0 }, {}]));
        scene.set("/scenes/0/nodes", json!([0, 1]));
        scene.set("/skins", json!([{ "joints": [1] }]));
        scene
    };
    let imported = load(&skinned([0, 255, 255, 255, 0, 9, 1, 7, 0, 0, 0, 1]));
    assert_eq!(imported.scene.surfaces.expect("surfaces").skinned_meshes.len(), 1);
    let error = load_with(&skinned([0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]), Limits::default());
    let error = error.map(drop).expect_err("there is no joint 1").to_string();
    assert!(error.contains("node 0: mesh 0 hangs on joint 1, but skin 0 has 1 joint"), "{error}");
}

#[test]
fn jpegs_without_their_end_are_taken_if_nothing_else_is_missing() {
    let whole = encoded(image::ImageFormat::Jpeg);
    let read = |bytes: &[u8]| {
        let mut scene = GltfFile::triangle();
        let view = scene.view(bytes);
        scene.set("/images", json!([{ "bufferView": view, "mimeType": "image/jpeg" }]));
        scene.show_images(1);
        read(scene.glb(), None, &LoadOptions::default()).map(|source| source.images[0].clone())
    };
    let decoded = read(&whole).expect("an image");
    for missing in [1, 2] {
        let cut = read(&whole[..whole.len() - missing]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(cut, decoded, "{missing} bytes are missing");
    }
    let mut cut_off = 0;
    for missing in 4..60 {
        let image = read(&whole[..whole.len() - missing]).unwrap_or_else(|error| panic!("{error}"));
        let image = image.expect("a placeholder");
        assert_eq!((image.name.as_str(), image.size), ("image 0 (missing)", [16, 16]));
        cut_off += 1;
    }
    assert_eq!(cut_off, 56);
}

#[test]
fn what_is_no_scene_is_told_from_a_broken_one() {
    let said = |bytes: &[u8]| {
        let error = read(bytes.to_vec(), None, &LoadOptions::default()).map(drop);
        error.expect_err("no scene").to_string()
    };
    let png = encoded(image::ImageFormat::Png);
    for (bytes, expected) in [
        (&b""[..], "file: it is empty (choose a .gltf, .glb, .stl or .obj file"),
        (b"glT", "GLB header: cut off after 3 bytes (the file is damaged"),
        (&png, "file: it is neither a GLB nor JSON"),
        (b"hello", "file: it is neither a GLB nor JSON"),
        (b"\xEF\xBB\xBF ", "file: it is neither a GLB nor JSON"),
        (b" {", "JSON: it ends too early"),
        (br#"{"asset":{"version":"1.0"}}"#, "only 2.0 is known (export it again as glTF 2.0"),
    ] {
        assert!(said(bytes).contains(expected), "{}", said(bytes));
    }
    let folder = std::env::temp_dir();
    for (path, expected) in [
        (folder.as_path(), "file: it is not a file, but a folder (check that"),
        (&folder.join("antumbra is not here.glb"), "here.glb: file: it cannot be read: No such"),
    ] {
        let error =
            antumbra_import::open(path, &LoadOptions::default()).map(drop).expect_err("none");
        assert!(error.to_string().contains(expected), "{error}");
    }
}

#[test]
fn colours_beyond_one_are_told() {
    let mut scene = GltfFile::triangle();
    let colours = scene.floats("VEC3", &[2.0, 0.5, 0.5, 1.0, 1.0, 1.0, -0.5, 0.0, 0.0]);
    scene.set("/meshes/0/primitives/0/attributes/COLOR_0", json!(colours));
    let imported = load(&scene);
    let cut = imported.notes.iter().find(|note| note.reason.contains("above 1, cut off there"));
    let told = cut.is_some_and(|note| note.count == 2);
    assert!(told, "{:?}", imported.notes);
}

#[test]
fn what_plays_is_asked_for_by_its_file() {
    // An animator without clips changes nothing.
    let (_, mut animator, _, _) = SceneAnimator::of(load(&arm()));
    assert!(animator.changes(1.0).is_empty());
}

#[test]
fn what_clips_mirror_at_times_is_there_from_both_sides() {
    let turns = [1.0, 1.0, 1.0, -1.0, 1.0, 1.0];
    let shrinks = [1.0, 1.0, 1.0, 0.0, 1.0, 1.0];
    // The object is visible neither at rest nor while the clip fades in.
    let away = [-1.0, 1.0, 1.0, -1.0, 1.0, 1.0];
    let grows = [1.0, 1.0, 1.0, 2.0, 2.0, 2.0];
    for (path, values, is_turning) in [
        ("scale", turns, true),
        ("scale", away, true),
        ("scale", shrinks, false),
        ("translation", turns, false),
    ] {
        let mut scene = arm();
        let channels = [(0, path, values), (1, "scale", grows), (2, "scale", grows)];
        let clip = clip(&mut scene, "turn", &channels);
        scene.set("/animations", json!([clip]));
        let imported = load(&scene);
        let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
        let of = |object: usize| imported.scene.objects[object].mesh.0 as usize;
        let triangles = |object| &imported.scene.meshes[of(object)].indices;
        let sides = |object| surfaces.meshes[of(object)].vertices[0].normal[3];
        assert_eq!((triangles(1).len(), sides(1)), (3, 0), "it hangs on nothing that mirrors");
        let expected = if is_turning { (6, i16::MAX) } else { (3, 0) };
        assert_eq!((triangles(0).len(), sides(0)), expected, "{path} {values:?}");
        if is_turning {
            assert_eq!(triangles(0), &[0, 1, 2, 3, 5, 4]);
            let normals: Vec<[i16; 4]> =
                surfaces.meshes[of(0)].vertices.iter().map(|vertex| vertex.normal).collect();
            assert_eq!(normals[0][2], -normals[3][2], "{normals:?}");
        }
        let told = imported
            .notes
            .iter()
            .any(|note| note.reason.contains("seen from both sides") && note.count == 1);
        assert_eq!(told, is_turning, "{:?}", imported.notes);
        play(imported);
    }
}
