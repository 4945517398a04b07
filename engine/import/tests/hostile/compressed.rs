//! Tests of views that `EXT_meshopt_compression` compresses. The encoded bytes come from
//! meshoptimizer 1.3's encoders, the decoded ones from its decoders.

use antumbra_import::{ImportError, Limits, LoadOptions, read};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::json;

use crate::strict;
use gltf_files::files::{GltfFile, U8};

const ATTRIBUTES: [&str; 2] = [
    "oAUAzDDAJgYiFjMAAAAKLgEAMwMDJiIwLgUADAMwCA4IAwAAABABDDAzMBoMKCgGBQPwM8wYDgQeKgg2MAAAAC4FMA/MDyokJg4MMjADAAAAEAUzPDAAHBwoDBI8AAAAJBwFM8AAzAoUCBI0AwAAADAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA4DFgAAAg==",
    "AAAOAxYAAAIAAA4DFhUOBwAADhAWFQ4HAAAOECIVHBETAA4QKRUcFRMTDhYrFTAVFhMSFisnNhUWJBIWKzo2FRYkEhYrQTYVJyQSKjpBPxUnJBIqOkc/FSc8GT5PRz8VMjwZPlNHPx4yPB1BU0c/HjI8HUFuYD84MlMdQW54PzgyUx1Bbng/ODdTHUGFeFE4N1MdQYV4XzhOUyVBhYBfUA==",
];
const TRIANGLES: [&str; 2] = [
    "4fAQIP9Q/0D+/xIBAf+6AWO8HgAAdodWZ3iphmWJaJgBaQAA",
    "AAAAAAEAAAACAAAAAgAAAAEAAAADAAAAAAAAAAIAAAAEAAAACQAAAAgAAAAHAAAAAgAAAAMAAAAFAAAAZAAAADIAAADQBwAABQAAAAMAAAAGAAAAAAAAAAEAAAACAAAA",
];
const INDICES: [&str; 2] = [
    "0QAEBAACCAQOCBwCAhIECJEDtAGxO7IBBgwWBAQAAAAA",
    "AAABAAIAAgABAAMABAAAAAIACQAIAAcAAgADAAUAZAAyANAHBQADAAYAAAABAAIA",
];
const OCTAHEDRAL8: &str =
    "oAE8AAAA/f4BPAAAAP1vAAE8AAAABAMAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAfwB/fw==";
const OCTAHEDRAL16: &str = "oAEkAAAAATwAAAANDgEsAAAA3QE8AAAADxgAAAE8AAAABAMBJAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAP8HAAD/B/9/";
const QUATERNIONS: &str = "oAEMAAAA/AEMAAAAtQE8AAAAxzMBPAAAANgjAQwAAAD8AQwAAAC1ARwAAAADAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAP9/";
const FLOATS: &str = "oAABMAAAAF8AAAABMAAAAKABIAAAAAEwAAAABgEwAAAA/wEwAAAA6wEQAAAAATAAAAANAAAAAAAAAAAAAAAAAAAAAAAAAAAAMADzAOD/8YA+APw=";

/// The parameters of a view's compression.
#[derive(Clone, Copy)]
struct View {
    mode: &'static str,
    filter: &'static str,
    count: usize,
    stride: usize,
}

const fn view(mode: &'static str, filter: &'static str, count: usize, stride: usize) -> View {
    View { mode, filter, count, stride }
}

const OF_ATTRIBUTES: View = view("ATTRIBUTES", "NONE", 20, 8);
const OF_TRIANGLES: View = view("TRIANGLES", "NONE", 24, 4);
const OF_INDICES: View = view("INDICES", "NONE", 24, 2);

/// Returns a file with a view of its second buffer, compressed to these bytes.
fn scene(encoded: &[u8], view: View) -> GltfFile {
    let mut scene = GltfFile::triangle();
    let at = scene.binary.len();
    scene.binary.extend_from_slice(encoded);
    let length = view.count * view.stride;
    scene.set("/buffers", json!([{ "byteLength": scene.binary.len() }, { "byteLength": length }]));
    let extension = json!({ "EXT_meshopt_compression": {
        "buffer": 0, "byteOffset": at, "byteLength": encoded.len(),
        "byteStride": view.stride, "count": view.count, "mode": view.mode, "filter": view.filter,
    } });
    let view = scene
        .push("bufferViews", json!({ "buffer": 1, "byteLength": length, "extensions": extension }));
    scene.set("/extensionsRequired", json!(["EXT_meshopt_compression"]));
    scene.set("/extensionsUsed", json!(["KHR_mesh_quantization"]));
    show_view(&mut scene, view);
    scene
}

/// Shows the first bytes of a view as a position.
fn show_view(scene: &mut GltfFile, view: usize) {
    let accessor = json!({ "bufferView": view, "componentType": U8, "type": "VEC3", "count": 1 });
    let positions = scene.push("accessors", accessor);
    let primitives = scene.json["meshes"][0]["primitives"].as_array_mut().expect("a list");
    primitives.push(json!({ "attributes": { "POSITION": positions } }));
}

fn bytes_of(text: &str) -> Vec<u8> {
    BASE64_STANDARD.decode(text).expect("it is base64")
}

fn decoded(encoded: &[u8], view: View) -> Result<Vec<u8>, ImportError> {
    read(scene(encoded, view).glb(), None, &strict()).map(|source| source.buffer(1).to_vec())
}

/// Returns seeds for the fuzzer.
pub fn seeds() -> Vec<(String, Vec<u8>)> {
    [
        ("attributes", ATTRIBUTES[0], OF_ATTRIBUTES),
        ("triangles", TRIANGLES[0], OF_TRIANGLES),
        ("indices", INDICES[0], OF_INDICES),
    ]
    .map(|(name, text, view)| {
        (format!("compressed_{name}.glb"), scene(&bytes_of(text), view).glb())
    })
    .to_vec()
}

#[test]
fn all_modes_are_decompressed() {
    for ([encoded, expected], view) in
        [(ATTRIBUTES, OF_ATTRIBUTES), (TRIANGLES, OF_TRIANGLES), (INDICES, OF_INDICES)]
    {
        assert_eq!(decoded(&bytes_of(encoded), view), Ok(bytes_of(expected)), "{}", view.mode);
    }
}

/// Returns the file with the name of the newer extension.
fn renamed(scene: &GltfFile) -> GltfFile {
    let text = scene.json.to_string().replace("EXT_meshopt", "KHR_meshopt");
    GltfFile { json: serde_json::from_str(&text).expect("it is JSON"), ..scene.clone() }
}

#[test]
fn the_newer_extension_has_all_of_the_older_one_and_more() {
    let read = |scene: &GltfFile| {
        read(scene.glb(), None, &strict()).map(|source| source.buffer(1).to_vec())
    };
    for ([encoded, expected], view) in
        [(ATTRIBUTES, OF_ATTRIBUTES), (TRIANGLES, OF_TRIANGLES), (INDICES, OF_INDICES)]
    {
        assert_eq!(read(&renamed(&scene(&bytes_of(encoded), view))), Ok(bytes_of(expected)));
    }
    // Attributes of version 1.
    let numbers: Vec<[u32; 4]> =
        (0..100).map(|index| [index, index * index, 7, u32::MAX - index]).collect();
    let encoded = meshopt::encode_vertex_buffer_level(&numbers, 2, Some(1)).expect("it is encoded");
    let newer = scene(&encoded, view("ATTRIBUTES", "NONE", 100, 16));
    assert_eq!(read(&renamed(&newer)), Ok(bytemuck::cast_slice(&numbers).to_vec()));
    let error = read(&newer).expect_err("the older one has no version 1").to_string();
    assert!(error.contains("it begins with 0xa1 and not with 0xa0"), "{error}");
    // Colours.
    let colours = [[1.0, 0.0, 0.0, 1.0], [0.2, 0.4, 0.6, 0.8], [0.0, 0.0, 0.0, 0.0]];
    let filtered = meshopt::encode_filter_color::<u8>(&colours, 8);
    let encoded = meshopt::encode_vertex_buffer(&filtered).expect("it is encoded");
    let coloured = scene(&encoded, view("ATTRIBUTES", "COLOR", 3, 4));
    let decoded = read(&renamed(&coloured)).expect("it is accepted");
    for (byte, part) in decoded.iter().zip(colours.as_flattened()) {
        assert!((f32::from(*byte) / 255.0 - part).abs() < 0.02, "{decoded:?}");
    }
    let error = read(&coloured).expect_err("the older one has no colours").to_string();
    assert!(error.contains("its filter COLOR is one of KHR_meshopt_compression"), "{error}");
}

#[test]
fn filters_give_what_was_filtered() {
    let get = |text, filter, count, stride| {
        decoded(&bytes_of(text), view("ATTRIBUTES", filter, count, stride)).expect("it is accepted")
    };
    let near = |numbers: Vec<i32>, expected: &[i32]| {
        let is_near = |(a, b): (&i32, &i32)| (a - b).abs() <= 1;
        assert!(
            numbers.iter().zip(expected).all(is_near) && numbers.len() == expected.len(),
            "{numbers:?}"
        );
    };
    let values = |bytes: Vec<u8>| -> Vec<i32> {
        bytes.chunks(2).map(|value| i32::from(i16::from_le_bytes([value[0], value[1]]))).collect()
    };
    let bytes = get(OCTAHEDRAL8, "OCTAHEDRAL", 3, 4);
    let signed = bytes.iter().map(|&byte| i32::from(byte as i8)).collect();
    near(signed, &[127, 0, 0, 127, 0, -127, 0, -127, 76, 0, -102, 127]);
    let numbers = values(get(OCTAHEDRAL16, "OCTAHEDRAL", 3, 8));
    for (number, expected) in
        numbers.iter().zip([1.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, -1.0, 0.6, 0.0, -0.8, 1.0])
    {
        assert!((*number as f32 / 32767.0 - expected).abs() < 1e-3, "{numbers:?}");
    }
    let numbers = values(get(QUATERNIONS, "QUATERNION", 3, 8));
    near(numbers, &[0, 0, 0, 32767, 19660, 0, 26213, 0, 16383, -16384, 16384, -16384]);
    let bytes = get(FLOATS, "EXPONENTIAL", 2, 12);
    let floats: Vec<f32> = bytes
        .chunks(4)
        .map(|value| f32::from_le_bytes([value[0], value[1], value[2], value[3]]))
        .collect();
    assert_eq!(floats, [1.5, -0.25, 1000.0, 0.0, 3.0, -7.0]);
}

#[test]
fn damaged_bytes_are_refused() {
    for ([encoded, _], view) in
        [(ATTRIBUTES, OF_ATTRIBUTES), (TRIANGLES, OF_TRIANGLES), (INDICES, OF_INDICES)]
    {
        let whole = bytes_of(encoded);
        for length in 0..whole.len() {
            let error = decoded(&whole[..length], view).expect_err("it is cut off");
            assert!(
                error.to_string().contains("buffer view 2, EXT_meshopt_compression"),
                "{error}"
            );
        }
        for place in 0..whole.len() {
            for value in [0, 1, 0x7F, 0x80, 0xFE, 0xFF] {
                let mut changed = whole.clone();
                changed[place] = value;
                // Some changes give other numbers; none may panic.
                let _ = decoded(&changed, view);
            }
        }
        let mut changed = whole.clone();
        changed[0] ^= 0x10;
        let error = decoded(&changed, view).expect_err("another header");
        assert!(error.to_string().contains("it begins with"), "{error}");
    }
}

#[test]
fn descriptions_that_do_not_fit_are_refused() {
    let extension = "/bufferViews/2/extensions/EXT_meshopt_compression";
    for (key, value, said) in [
        ("buffer", json!(9), "buffer 9 does not exist"),
        ("buffer", json!(1), "it ends beyond its buffer"),
        ("byteOffset", json!(u64::MAX), "ends beyond"),
        ("byteLength", json!(1 << 30), "ends beyond"),
        ("count", json!(21), "its view has 160 bytes, and not 21 elements of 8 bytes"),
        ("count", json!(-1), "its count is not a whole number"),
        ("count", json!(u64::MAX / 8 + 1), "its view has 160 bytes"),
        ("byteStride", json!(0), "does not allow 20 elements of 0 bytes"),
        ("byteStride", json!(10), "does not allow 20 elements of 10 bytes"),
        ("byteStride", json!(1024), "does not allow 20 elements of 1024 bytes"),
        ("mode", json!("BEST"), "mode does not exist"),
        ("mode", json!("TRIANGLES"), "does not allow 20 elements"),
        ("filter", json!("BEST"), "filter does not exist"),
        ("filter", json!(3), "filter does not exist"),
    ] {
        let mut scene = scene(&bytes_of(ATTRIBUTES[0]), OF_ATTRIBUTES);
        scene.set(&format!("{extension}/{key}"), value);
        let error = read(scene.glb(), None, &strict()).map(drop).expect_err(said);
        let text = error.to_string();
        assert!(
            text.contains("buffer view 2, EXT_meshopt_compression") && text.contains(said),
            "{text}"
        );
    }
    let mut from_itself = scene(&bytes_of(ATTRIBUTES[0]), OF_ATTRIBUTES);
    from_itself.set(&format!("{extension}/buffer"), json!(1));
    from_itself.set(&format!("{extension}/byteOffset"), json!(0));
    let error = read(from_itself.glb(), None, &strict()).map(drop).expect_err("a circle");
    assert!(error.to_string().contains("buffer 1 has no bytes of its own"), "{error}");
}

#[test]
fn many_views_of_few_bytes_are_refused() {
    let mut scene = scene(&bytes_of(ATTRIBUTES[0]), OF_ATTRIBUTES);
    let view = scene.json["bufferViews"][2].clone();
    let views = vec![view; 1000];
    scene.json["bufferViews"].as_array_mut().expect("a list").extend(views);
    (3..1003).for_each(|view| show_view(&mut scene, view));
    let limits = Limits { buffer_bytes: 100_000, ..Limits::default() };
    let limits = LoadOptions { limits, ..LoadOptions::default() };
    let error = read(scene.glb(), None, &limits).map(drop).expect_err("too much");
    assert!(error.to_string().contains("bytes decompressed up to it: 100160"), "{error}");
}

#[test]
fn bytes_that_are_there_are_not_decompressed() {
    let mut plain = scene(b"nothing of use", OF_ATTRIBUTES);
    plain.set("/buffers/1/uri", json!(format!("data:;base64,{}", ATTRIBUTES[1])));
    plain.remove("/extensionsRequired");
    let source =
        read(plain.glb(), None, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(source.buffer(1), bytes_of(ATTRIBUTES[1]));
    // A buffer that is marked as a fallback is not even opened.
    let mut marked = scene(&bytes_of(ATTRIBUTES[0]), OF_ATTRIBUTES);
    marked.set("/buffers/1/uri", json!("https://example.com/gone.bin"));
    marked.set("/buffers/1/extensions/EXT_meshopt_compression/fallback", json!(true));
    let source =
        read(marked.glb(), None, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(source.buffer(1), bytes_of(ATTRIBUTES[1]));
}
