//! Tests of files with faults without which their scene can be shown: a note names the object and
//! the reason.

use std::ops::ControlFlow;

use antumbra_import::{GltfScene, LoadOptions, load_bytes, read};
use serde_json::{Value, json};

use gltf_files::files::{GltfFile, I16, U16, encoded, everything};

use crate::refused::Case;
use crate::strict;

/// Faults without which the scene can be shown, and parts of the notes.
const LEFT_OUT: &[Case] = &[
    (
        |s| s.set("/animations/0/channels/0/sampler", json!(9)),
        &["animation 0, channel 0", "sampler 9"],
    ),
    (
        |s| s.set("/animations/0/channels/0/target/node", json!(9)),
        &["animation 0, channel 0", "node 9"],
    ),
    (
        |s| s.set("/animations/0/samplers/0/input", json!(99)),
        &["animation 0, sampler 0", "accessor 99"],
    ),
    (
        |s| s.set("/animations/0/samplers/1/output", json!(99)),
        &["animation 0, sampler 1", "accessor 99"],
    ),
    (
        |s| s.set("/animations/0/samplers/0/input", json!(0)),
        &["animation 0, sampler 0", "vectors of 3 floats"],
    ),
    (
        |s| s.set("/animations/0/samplers/0/interpolation", json!("BEST")),
        &["animation 0, sampler 0", "interpolation does not exist"],
    ),
    (
        |s| s.remove("/animations/0/samplers/0/interpolation"),
        &["animation 0, channel 0", "2 keys of 1 value each, but its output has 6"],
    ),
    (
        |s| s.set("/animations/0/channels/0/target/path", json!("scale")),
        &["animation 0, channel 0", "vectors of 4 floats"],
    ),
    (
        |s| s.set("/animations/0/channels/0/target/path", json!("colour")),
        &["animation 0, channel 0", "path does not exist"],
    ),
    (
        |s| s.set("/animations/0/channels/1/target/node", json!(0)),
        &["animation 0, channel 1", "node 0, which has no morph targets"],
    ),
    (|s| s.set("/images/0/bufferView", json!(99)), &["image 0", "buffer view 99"]),
    (|s| set_image(s, b"nonsense"), &["image 0", "not a PNG, JPEG, WebP or KTX2"]),
    (|s| set_image(s, b""), &["image 0", "not a PNG, JPEG, WebP or KTX2"]),
    (|s| set_image(s, b"GIF89a        "), &["image 0", "not a PNG, JPEG, WebP or KTX2"]),
    (|s| set_image(s, b"\xABKTX 20\xBB\r\n\x1A\n"), &["image 0", "KTX2 image that cannot be read"]),
    (|s| set_cut_image(s, image::ImageFormat::Png), &["image 0", "cannot be decoded"]),
    (|s| set_cut_image(s, image::ImageFormat::Jpeg), &["image 0", "cut off"]),
    (|s| set_cut_image(s, image::ImageFormat::WebP), &["image 0", "cannot be decoded"]),
    (|s| s.set("/images/0", json!({})), &["image 0", "neither a URI nor a buffer view"]),
    (|s| s.set("/images/0", json!({ "uri": "data:image/png" })), &["image 0", "no comma"]),
    (|s| s.set("/images/0", json!({ "uri": "a.png" })), &["image 0", "read without a folder"]),
];

#[test]
fn what_the_scene_can_do_without_is_left_out_and_named() {
    for &(change, expected) in LEFT_OUT {
        let mut scene = everything();
        change(&mut scene);
        let source = read(scene.glb(), None, &LoadOptions::default());
        let source = source.unwrap_or_else(|error| panic!("{expected:?}: {error}"));
        let texts: Vec<String> = source.notes.iter().map(ToString::to_string).collect();
        let is_noted = |text: &String| expected.iter().all(|part| text.contains(part));
        assert!(texts.iter().any(is_noted), "{texts:?}\nlack a part of {expected:?}");
        assert_eq!(texts.len(), 1, "{texts:?}");
        let is_image = texts[0].contains("checkers are shown for image 0");
        assert_eq!(source.placeholders.contains(&0), is_image, "{texts:?}");
        assert!(is_image || texts[0].contains("animation 0 is not played"), "{texts:?}");
    }
}

fn set_image(scene: &mut GltfFile, bytes: &[u8]) {
    let view = scene.view(bytes);
    scene.set("/images/0", json!({ "bufferView": view, "mimeType": "image/png" }));
}

fn set_cut_image(scene: &mut GltfFile, format: image::ImageFormat) {
    let whole = encoded(format);
    // PNG ends with a checksum and an empty chunk, so cutting less would leave a complete image.
    set_image(scene, &whole[..whole.len() - 24]);
}

/// Returns the scene of a file, and the texts of its notes.
fn load(scene: &GltfFile) -> (GltfScene, Vec<String>) {
    let go_on = &mut |_| ControlFlow::Continue(());
    let imported = load_bytes(scene.glb(), None, &LoadOptions::default(), go_on);
    let imported = imported.unwrap_or_else(|error| panic!("{error}"));
    let texts = imported.notes.iter().map(ToString::to_string).collect();
    (imported, texts)
}

fn is_refused(scene: &GltfFile, expected: &str) {
    let go_on = &mut |_| ControlFlow::Continue(());
    let refused = load_bytes(scene.glb(), None, &strict(), go_on).map(drop);
    let said = refused.expect_err("it is broken").to_string();
    assert!(said.contains(expected), "{said}");
}

// Some exporters write null for absent properties, anywhere.
#[test]
fn null_is_an_absent_property_everywhere() {
    let changes: [fn(&mut GltfFile); 3] = [
        |s| s.set("/animations", Value::Null),
        |s| {
            s.set("/meshes/0/primitives/0/mode", Value::Null);
            s.set("/meshes/0/primitives/0/targets", Value::Null);
        },
        |s| s.set("/extensionsUsed", Value::Null),
    ];
    let places = ["animations", "mesh 0, primitive 0, mode", "extensionsUsed"];
    for (change, place) in changes.into_iter().zip(places) {
        let mut scene = GltfFile::triangle();
        change(&mut scene);
        let (imported, texts) = load(&scene);
        assert_eq!(imported.scene.objects.len(), 1);
        let times = if place.contains("mode") { " (2 times, first here)" } else { "" };
        assert_eq!(texts, [format!("{place}: it is null, which is read as absent{times}")]);
    }
    // Nulls in optional properties are noted, too.
    let mut scene = GltfFile::triangle();
    scene.set("/nodes/0/skin", Value::Null);
    scene.set("/nodes/0/extras", json!({ "mine": null }));
    assert_eq!(load(&scene).1, ["node 0, skin: it is null, which is read as absent"]);
    scene.remove("/nodes/0/skin");
    assert_eq!(load(&scene).1, [""; 0]);
    // A required property is missing.
    scene.set("/asset", Value::Null);
    let error = read(scene.glb(), None, &LoadOptions::default()).map(drop).expect_err("no asset");
    assert!(error.to_string().contains("JSON: it has no asset"), "{error}");
}

// Real tiles of cities use the index that begins a new strip.
#[test]
fn an_index_that_restarts_a_strip_splits_it() {
    let mut scene = GltfFile::triangle();
    let indices = scene.numbers(U16, "SCALAR", 5, &[0, 0, 1, 0, 255, 255, 1, 0, 2, 0]);
    scene.set("/meshes/0/primitives/0/indices", json!(indices));
    scene.set("/meshes/0/primitives/0/mode", json!(3));
    let (imported, texts) = load(&scene);
    let sprites = &imported.scene.surfaces.as_ref().expect("surfaces").sprites;
    assert_eq!(sprites[0].count(), 2, "0 to 1 and 1 to 2");
    assert_eq!(texts.len(), 1, "{texts:?}");
    assert!(texts[0].contains("vertex 65535 does not exist, there are 3; read as"), "{texts:?}");
    is_refused(&scene, "vertex 65535 does not exist");
    // With other invalid indices, the primitive is left out, and with it the whole scene.
    let indices = scene.numbers(U16, "SCALAR", 4, &[0, 0, 1, 0, 255, 255, 9, 0]);
    scene.set("/meshes/0/primitives/0/indices", json!(indices));
    let go_on = &mut |_| ControlFlow::Continue(());
    let error = load_bytes(scene.glb(), None, &LoadOptions::default(), go_on).map(drop);
    let said = error.expect_err("nothing is left").to_string();
    assert!(said.contains("mesh 0, primitive 0, indices: vertex 9 does not exist"), "{said}");
}

#[test]
fn integers_in_place_of_positions_are_read_undeclared() {
    let mut scene = GltfFile::triangle();
    let positions = scene.numbers(I16, "VEC3", 3, &[7; 8 + 8 + 6]);
    scene.set(&format!("/bufferViews/{positions}/byteStride"), json!(8));
    let bound = json!([1799, 1799, 1799]);
    scene.set(&format!("/accessors/{positions}/min"), bound.clone());
    scene.set(&format!("/accessors/{positions}/max"), bound);
    scene.set("/meshes/0/primitives/0/attributes/POSITION", json!(positions));
    scene.set("/meshes/0/primitives/1", scene.json["meshes"][0]["primitives"][0].clone());
    let (imported, texts) = load(&scene);
    assert_eq!(imported.scene.meshes[0].vertices[0].position, [1799.0; 3]);
    let expected = "mesh 0, primitive 0, attribute POSITION: its elements may not be vectors of 3 \
                    signed 16-bit integers without KHR_mesh_quantization; read as if it were named \
                    (2 times, first here)";
    assert_eq!(texts, [expected]);
    is_refused(&scene, "without KHR_mesh_quantization");
}

#[test]
fn what_a_broken_part_needs_no_more_is_not_looked_at() {
    let mut scene = everything();
    let used = scene.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"].as_u64();
    assert_eq!(used, Some(3), "the first mesh");
    scene.set("/accessors/3/count", json!(9999));
    scene.remove("/animations");
    let (imported, texts) = load(&scene);
    assert_eq!(
        imported.scene.surfaces.as_ref().map(|surface| surface.images.len()),
        Some(0),
        "{texts:?}"
    );
}

#[test]
fn an_image_that_is_missing_is_told_by_its_uses() {
    let mut scene = everything();
    scene.set("/images/1", json!({ "uri": "gone.png" }));
    let metallic = "/materials/0/pbrMetallicRoughness/metallicRoughnessTexture";
    scene.set(metallic, json!({ "index": 1 }));
    scene.remove("/materials/0/normalTexture");
    let told = |scene: &GltfFile| load(scene).1.concat();
    let neutral = "; image 1 (\"gone.png\") counts as a neutral metallic-roughness texture";
    assert!(told(&scene).contains(neutral), "{}", told(&scene));
    scene.set("/materials/0/emissiveTexture/index", json!(1));
    let both =
        "; checkers are shown for image 1 (\"gone.png\") as colour, and it counts as a neutral";
    assert!(told(&scene).contains(both), "{}", told(&scene));
    scene.remove(metallic);
    assert!(told(&scene).ends_with("; checkers are shown for image 1 (\"gone.png\")"));
}

#[test]
fn extensions_that_are_used_but_not_named_are_noted() {
    let mut scene = everything();
    let coat = json!({ "KHR_materials_transmission": { "transmissionFactor": 1 } });
    scene.set("/materials/0/extensions", coat);
    let texts = load(&scene).1;
    let name = "extension \"KHR_materials_transmission\": ";
    let said = "extensionsUsed must name it, but does not; ignored: glass is opaque";
    assert!(texts.iter().any(|text| text.contains(&format!("{name}{said}"))), "{texts:?}");
    assert_eq!(texts.len(), 1, "{texts:?}");
    // Supported ones are shown.
    let mut scene = everything();
    let objects = load(&scene).0.scene.objects.len();
    scene.set("/extensionsUsed", json!(["KHR_lights_punctual", "EXT_texture_webp"]));
    let (imported, texts) = load(&scene);
    assert_eq!(imported.scene.objects.len(), objects, "its instances");
    assert_eq!(texts.len(), 2, "{texts:?}");
    assert!(texts.iter().all(|text| text.ends_with("but does not; shown all the same")));
}

#[test]
fn what_no_camera_can_show_is_told() {
    let mut scene = GltfFile::triangle();
    scene.set("/nodes/0/scale", json!([1e-12, 1e-12, 1e-12]));
    let texts = load(&scene).1;
    assert!(
        texts.concat().contains("it is 1.0e-12 m large, and shown from no nearer"),
        "{texts:?}"
    );
    scene.set("/nodes/0/scale", json!([1e-3, 1e-3, 1e-3]));
    assert_eq!(load(&scene).1, [""; 0]);
    // A light and a camera without a direction.
    let mut scene = everything();
    scene.set("/nodes/3/scale", json!([0, 0, 0]));
    let texts = load(&scene).1.concat();
    assert!(texts.contains("its light is under a scale of 0"), "{texts}");
    assert!(texts.contains("\"camera 0\": it is under a scale of 0"), "{texts}");
}

/// Returns a triangle in a file without scenes, with these nodes and another one that shows it.
fn without_scenes(mut nodes: Vec<Value>) -> GltfFile {
    let mut scene = GltfFile::triangle();
    scene.remove("/scene");
    scene.remove("/scenes");
    nodes.push(json!({ "mesh": 0 }));
    scene.set("/nodes", json!(nodes));
    scene
}

// The children of a broken node then have no parent, and files without scenes mark roots in this
// way.
#[test]
fn what_is_below_a_broken_node_does_not_become_a_root() {
    let broken = json!({ "translation": [1e39, 0, 0], "children": [1] });
    let unreadable = json!({ "name": 5, "children": [1.0, "far", -1] });
    let place = [1e39, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let below = [
        json!({ "mesh": 0 }),
        json!({ "mesh": 99 }),
        json!({ "mesh": 0, "matrix": place }),
        json!({ "mesh": 0, "skin": 9, "camera": 9 }),
        // A child that is also shown below another node.
        json!({ "mesh": 0, "children": [2] }),
    ];
    for top in [broken, unreadable] {
        for below in &below {
            let adopts = json!({ "children": [2] });
            let file = without_scenes(vec![top.clone(), below.clone(), json!({}), adopts]);
            let (imported, texts) = load(&file);
            let context = format!("{top} {below}: {texts:?}");
            gltf_files::loaded::check(&imported);
            assert_eq!(imported.scene.objects.len(), 1, "{context}");
            assert_eq!(imported.rig.nodes().len(), 4, "{context}");
            let told = |text: &String| {
                text.starts_with("node 0") && text.ends_with("it is left out with all below it")
            };
            assert_eq!(texts.iter().filter(|text| told(text)).count(), 1, "{context}");
            let source = read(file.glb(), None, &LoadOptions::default());
            let json = source.unwrap_or_else(|error| panic!("{error}")).document.into_json();
            assert_eq!(json.nodes.len(), 5);
            for node in &json.nodes[..2] {
                assert!(node.children.iter().flatten().next().is_none(), "{context}");
                assert!(node.mesh.is_none() && node.skin.is_none(), "{context}");
                assert!(node.camera.is_none() && node.matrix.is_none(), "{context}");
            }
        }
    }
}

// Primitives that are left out do not determine the number of a node's weights.
#[test]
fn weights_of_nodes_fit_the_primitives_that_are_shown() {
    let mut file = GltfFile::triangle();
    let shown = json!({ "attributes": { "POSITION": 0 }, "targets": [{ "POSITION": 0 }] });
    let mut broken = shown.clone();
    broken["attributes"]["POSITION"] = json!(1);
    broken["targets"] = json!([{ "POSITION": 0 }, { "POSITION": 0 }]);
    file.set("/meshes/0/primitives", json!([broken, shown]));
    for (weights, kept) in [(json!([0.5, 0.5]), 0.0), (json!([0.5]), 0.5)] {
        file.set("/nodes/0/weights", weights);
        let (imported, texts) = load(&file);
        gltf_files::loaded::check(&imported);
        assert_eq!(imported.rig.nodes()[0].weights, [kept], "{texts:?}");
        assert!(!imported.scene.objects.is_empty(), "{texts:?}");
        let ignored = "node 0: it has 2 weights for 1 morph target; they are ignored";
        assert_eq!(texts.iter().any(|text| text == ignored), kept == 0.0, "{texts:?}");
        assert_eq!(texts.len(), if kept == 0.0 { 2 } else { 1 }, "{texts:?}");
    }
    // If a mesh cannot be read, the weights of its nodes are removed.
    file.set("/meshes/1", json!({ "primitives": 5 }));
    file.push("nodes", json!({ "mesh": 1, "weights": [0.5] }));
    file.set("/scenes/0/nodes", json!([0, 1]));
    let texts = load(&file).1;
    assert!(!texts.iter().any(|text| text.contains("node 1")), "{texts:?}");
}

#[test]
fn clips_lose_the_weights_of_nodes_that_are_left_out() {
    let mut scene = everything();
    scene.set("/nodes/1/scale", json!([1e39, 1, 1]));
    let texts = load(&scene).1;
    assert!(texts[0].starts_with("node 1: its scale is"), "{texts:?}");
    assert!(!texts.iter().any(|text| text.contains("morph targets")), "{texts:?}");
}
