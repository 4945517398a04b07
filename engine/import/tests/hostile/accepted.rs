//! Tests that valid files are accepted and read correctly: refusing too much is as bad as refusing
//! too little.

use antumbra_import::{LoadOptions, Source, read};
use serde_json::json;

use gltf_files::files::{F32, GltfFile, I16, U8, U32, encoded, everything, glb_of};

fn accept(name: &str, bytes: Vec<u8>) -> Source {
    read(bytes, None, &LoadOptions::default()).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn triangle_with(change: impl FnOnce(&mut GltfFile)) -> GltfFile {
    let mut scene = GltfFile::triangle();
    change(&mut scene);
    scene
}

type Change = fn(&mut GltfFile);

/// Changes of a triangle that keep the file valid.
const VALID: &[(&str, Change)] = &[
    ("nothing", |_| {}),
    ("no scene at all", |scene| {
        scene.remove("/scene");
        scene.remove("/scenes");
    }),
    ("a scene without nodes", |scene| scene.set("/scenes/1", json!({ "name": "empty" }))),
    ("a node in two scenes", |scene| scene.set("/scenes/1", json!({ "nodes": [0] }))),
    ("a node in no scene", |scene| scene.set("/nodes/1", json!({}))),
    ("no primitives use it", |scene| {
        scene.set("/nodes", json!([{}]));
        scene.set("/meshes", json!([]));
    }),
    ("no indices", |scene| scene.remove("/meshes/0/primitives/0/indices")),
    ("no positions", |scene| {
        let colour = scene.floats("VEC3", &[1.0; 9]);
        scene.set("/meshes/0/primitives/0/attributes", json!({ "COLOR_0": colour }));
    }),
    ("no min and max", |_| {}),
    ("min and max of integers", |scene| {
        scene.set("/accessors/0/min", json!([0, 0, 0]));
        scene.set("/accessors/0/max", json!([1, 1, 0]));
    }),
    ("extras of any kind", |scene| {
        scene.set("/extras", json!(5));
        scene.set("/nodes/0/extras", json!("text"));
        scene.set("/meshes/0/extras", json!([1, [2, null]]));
        scene.set("/asset/extras", json!({ "deep": { "deeper": [true] } }));
    }),
    ("an extension that is not known", |scene| {
        scene.set("/extensionsUsed", json!(["VENDOR_thing"]));
        scene.set("/extensions/VENDOR_thing", json!({ "nodes": [99] }));
        scene.set("/nodes/0/extensions/VENDOR_thing", json!({}));
    }),
    ("attributes of an application", |scene| {
        scene.set("/meshes/0/primitives/0/attributes/_HEAT", json!(0));
        scene.set("/meshes/0/primitives/0/attributes/VENDOR_THING", json!(0));
    }),
    ("unknown fields", |scene| scene.set("/nodes/0/future", json!({ "a": [1] }))),
    ("a matrix that cannot be inverted", |scene| {
        scene.set("/nodes/0/matrix", json!(vec![0.0; 16]))
    }),
    ("a scale of zero", |scene| scene.set("/nodes/0/scale", json!([0, 0, 0]))),
    ("a later version of the same major", |scene| scene.set("/asset/version", json!("2.1"))),
    ("a channel without a node", |scene| {
        scene.set(
            "/animations",
            json!([{
                "samplers": [{ "input": 1, "output": 0 }],
                "channels": [{ "sampler": 0, "target": { "path": "pointer" } }],
            }]),
        );
        let times = scene.floats("SCALAR", &[0.0, 1.0, 2.0]);
        scene.set("/animations/0/samplers/0/input", json!(times));
    }),
    ("an orthographic camera", |scene| {
        let camera = json!({ "xmag": 1.0, "ymag": 1.0, "znear": 0.0, "zfar": 10.0 });
        scene.set("/cameras", json!([{ "type": "orthographic", "orthographic": camera }]));
        scene.set("/nodes/0/camera", json!(0));
    }),
    ("a camera of the other type's values, too", |scene| {
        let camera = json!({ "xmag": 1.0, "ymag": 1.0, "znear": 0.0, "zfar": 10.0 });
        let unused = json!({ "yfov": 99, "znear": -1, "aspectRatio": -1 });
        scene.set(
            "/cameras",
            json!([{ "type": "orthographic", "orthographic": camera, "perspective": unused }]),
        );
        scene.set("/nodes/0/camera", json!(0));
    }),
    ("an infinite perspective camera", |scene| {
        scene.set(
            "/cameras",
            json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }]),
        );
    }),
    ("quantised positions", |scene| {
        let positions = scene.numbers(I16, "VEC3", 3, &[7; 8 + 8 + 6]);
        scene.set(&format!("/bufferViews/{positions}/byteStride"), json!(8));
        scene.set("/meshes/0/primitives/0/attributes/POSITION", json!(positions));
        scene.set("/extensionsRequired", json!(["KHR_mesh_quantization"]));
        scene.set("/extensionsUsed", json!(["KHR_mesh_quantization"]));
    }),
    ("a texture without an image", |scene| scene.set("/textures", json!([{}]))),
    ("an image that nothing uses and nobody has", |scene| {
        scene.set("/images", json!([{ "uri": "gone.png" }]));
    }),
    ("an optional image format that is not known", |scene| {
        let png = scene.view(&encoded(image::ImageFormat::Png));
        scene.set(
            "/images",
            json!([{ "bufferView": png, "mimeType": "image/png" }, { "uri": "a.ktx2" }]),
        );
        let basis = json!({ "KHR_texture_basisu": { "source": 1 } });
        scene.set(
            "/textures",
            json!([{ "source": 0, "extensions": basis }, { "extensions": basis }]),
        );
        scene.set("/extensionsUsed", json!(["KHR_texture_basisu"]));
    }),
    ("an image of compressed blocks", |scene| {
        let view = scene.view(&super::ktx2_images::file().packed().bytes());
        scene.set("/images", json!([{ "bufferView": view, "mimeType": "image/ktx2" }]));
        scene.show_images(1);
    }),
    ("lights without numbers", |scene| {
        scene.set("/extensions/KHR_lights_punctual/lights", json!([{ "type": "point" }]));
        scene.set("/nodes/0/extensions/KHR_lights_punctual/light", json!(0));
    }),
    ("a mesh without primitives on a node", |scene| {
        scene.set("/meshes/1", json!({ "primitives": [] }));
        scene.set("/nodes/1", json!({ "mesh": 1 }));
    }),
    ("strips of too few vertices", |scene| {
        scene.set("/meshes/0/primitives/0/mode", json!(5));
        scene.set("/accessors/1/count", json!(2));
    }),
];

#[test]
fn what_is_valid_is_accepted() {
    for (name, change) in VALID {
        let scene = triangle_with(change);
        accept(&format!("{name}, .glb"), scene.glb());
        accept(&format!("{name}, .gltf"), scene.gltf());
    }
    for mode in 0..=6 {
        accept(
            "mode",
            triangle_with(|scene| scene.set("/meshes/0/primitives/0/mode", json!(mode))).glb(),
        );
    }
}

#[test]
fn everything_is_read_from_glb_and_gltf_alike() {
    let scene = everything();
    for bytes in [scene.glb(), scene.gltf()] {
        let source = accept("everything", bytes);
        assert_eq!(source.notes, []);
        assert_eq!(source.texture_images, [Some(0), Some(1), Some(2)]);
        let sizes = source.images.iter().map(|image| image.as_ref().map(|image| image.size));
        assert_eq!(sizes.collect::<Vec<_>>(), [Some([16, 8]); 3]);
        let png = source.images[0].as_ref();
        let webp = source.images[2].as_ref();
        let [png, webp] = [png, webp].map(|image| image.expect("an image").rgba8());
        assert_eq!(png[..8], [0, 0, 77, 255, 16, 0, 77, 255]);
        assert_eq!(png, webp);
        let instancing = source.instancing[&0];
        assert_eq!(instancing.count, 2);
        let turns = source.floats::<4>(instancing.rotation.expect("turned")).expect("four floats");
        assert_eq!(turns, [[0.0, 0.0, 0.0, 1.0]; 2]);
        assert_eq!(source.document.animations().count(), 1);
    }
}

#[test]
fn sparse_and_absent_elements_are_read() {
    let mut scene = everything();
    let zeros =
        scene.push("accessors", json!({ "componentType": F32, "type": "VEC2", "count": 3 }));
    scene.set("/meshes/0/primitives/0/attributes/TEXCOORD_1", json!(zeros));
    let sparse = scene.json["meshes"][1]["primitives"][0]["targets"][0]["POSITION"]
        .as_u64()
        .expect("an index");
    let mut based = scene.json["accessors"][sparse as usize].clone();
    based["bufferView"] = json!(0);
    let based = scene.push("accessors", based);
    scene.set("/meshes/1/primitives/0/targets/0/NORMAL", json!(based));
    let source = accept("sparse", scene.glb());
    assert_eq!(source.floats::<2>(zeros), Some(vec![[0.0; 2]; 3]));
    let expected = vec![[0.0; 3], [0.0; 3], [1.0, 2.0, 3.0]];
    assert_eq!(source.floats::<3>(sparse as usize), Some(expected));
    let expected = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 2.0, 3.0]];
    assert_eq!(source.floats::<3>(based), Some(expected));
    assert_eq!(source.floats::<2>(based), None);
    assert_eq!(source.floats::<2>(9999), None);
    assert_eq!(source.integers::<3>(based), None);
}

#[test]
fn numbers_of_all_types_are_read_from_any_place() {
    let mut scene = GltfFile::triangle();
    // Three elements of three bytes, 5 bytes apart, beginning at an odd byte.
    let bytes = [0, 255, 128, 127, 9, 9, 129, 0, 1, 9, 9, 64, 32, 16];
    let view = scene.view(&bytes);
    scene.set(&format!("/bufferViews/{view}/byteStride"), json!(5));
    let mut expected: Vec<(usize, Vec<[f32; 3]>)> = Vec::new();
    let mut add = |component: u32, normalised: bool, convert: fn(u8) -> f32| {
        let at = scene.push(
            "accessors",
            json!({
                "bufferView": view, "byteOffset": 1, "componentType": component, "type": "VEC3",
                "count": 3, "normalized": normalised,
            }),
        );
        let element =
            |first: usize| [bytes[first], bytes[first + 1], bytes[first + 2]].map(convert);
        expected.push((at, vec![element(1), element(6), element(11)]));
    };
    add(U8, false, f32::from);
    add(U8, true, |byte| f32::from(byte) / 255.0);
    add(5120, false, |byte| f32::from(byte as i8));
    add(5120, true, |byte| (f32::from(byte as i8) / 127.0).max(-1.0));
    scene.set("/extensionsUsed", json!(["KHR_mesh_quantization"]));
    let mut primitives: Vec<_> = expected
        .iter()
        .map(|(accessor, _)| json!({ "attributes": { "POSITION": accessor } }))
        .collect();
    let many = json!({ "componentType": F32, "type": "VEC3", "count": 1 << 20 });
    let many = scene.push("accessors", many);
    let values = scene.numbers(U32, "SCALAR", 2, &[1, 0, 0, 0, 2, 0, 1, 0]);
    primitives.push(json!({ "attributes": { "POSITION": many }, "indices": values }));
    scene.set("/meshes/0/primitives", json!(primitives));
    let source = accept("numbers", scene.glb());
    for (accessor, values) in expected {
        assert_eq!(source.floats::<3>(accessor), Some(values), "accessor {accessor}");
    }
    assert_eq!(source.integers::<1>(values), Some(vec![[1], [65_538]]));
}

#[test]
fn containers_are_read_as_freely_as_they_are_written() {
    let scene = GltfFile::triangle();
    let marked = [b"\xEF\xBB\xBF".as_slice(), &scene.gltf()].concat();
    accept("a byte order mark", marked);
    let json = scene.gltf();
    accept("no binary chunk", glb_of(&[(b"JSON", &json)]));
    accept("another chunk", glb_of(&[(b"JSON", &json), (b"ABCD", b"anything")]));
    accept("an empty binary chunk", glb_of(&[(b"JSON", &json), (b"BIN\0", b"")]));
    let mut longer = scene.clone();
    longer.set("/buffers", json!([{ "byteLength": longer.binary.len() }]));
    longer.binary.extend([1, 2, 3]);
    accept("three bytes more", longer.glb());
    accept("bytes after the end", [scene.glb(), b"more".to_vec()].concat());
    let mut deep = json!(0);
    for _ in 0..100 {
        deep = json!([deep]);
    }
    accept("deep extras", triangle_with(|scene| scene.set("/extras", deep)).glb());
}

#[test]
fn what_is_not_understood_is_noted() {
    let unknown = triangle_with(|scene| scene.set("/extensionsUsed", json!(["VENDOR_thing"])));
    let notes = accept("unknown", unknown.glb()).notes;
    assert!(notes.iter().any(|note| note.object.contains("VENDOR_thing")), "{notes:?}");
    let mut basis = GltfFile::triangle();
    basis.show_images(1);
    basis.set("/textures", json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]));
    let notes = accept("basis", basis.glb()).notes;
    assert!(notes.iter().any(|note| note.reason.contains("KHR_texture_basisu")), "{notes:?}");
}

/// Returns files that contain all features, as seeds for the fuzzer.
pub fn seeds() -> Vec<(String, Vec<u8>)> {
    let mut seeds = vec![
        ("everything.glb".to_owned(), everything().glb()),
        ("everything.gltf".to_owned(), everything().gltf()),
    ];
    for (name, change) in VALID {
        let name = name.replace(' ', "_").replace(',', "");
        seeds.push((format!("{name}.glb"), triangle_with(change).glb()));
    }
    seeds
}
