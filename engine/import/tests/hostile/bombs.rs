//! Tests that short files with large demands are refused quickly and before memory is allocated
//! (`memory.rs` measures the latter).

use std::time::{Duration, Instant};

use antumbra_import::{Cause, Limits, LoadOptions, read};
use serde_json::json;

use crate::strict;
use gltf_files::files::{F32, GltfFile, U16, everything};

/// Checks that a file is refused quickly because of its size.
fn too_large(bytes: Vec<u8>, expected: &[&str]) {
    let start = Instant::now();
    let error = read(bytes, None, &LoadOptions::default()).map(drop).expect_err("too large");
    let said = error.to_string();
    assert!(
        expected.iter().all(|part| said.contains(part)),
        "{said}\nlacks a part of {expected:?}"
    );
    assert_eq!(error.cause, Cause::TooLarge, "{said}");
    assert!(start.elapsed() < Duration::from_secs(20), "{said} took {:?}", start.elapsed());
}

#[test]
fn large_meshes_without_bytes_are_refused() {
    let mut scene = GltfFile::triangle();
    scene.set("/accessors/0", json!({ "componentType": F32, "type": "VEC3", "count": 1u64 << 40 }));
    too_large(scene.glb(), &["accessor 0", "elements up to it"]);

    // Each accessor is within the limit, both together are not.
    let mut scene = GltfFile::triangle();
    let half = Limits::default().elements / 2;
    scene.set("/accessors/0", json!({ "componentType": F32, "type": "VEC3", "count": half + 1 }));
    scene.set("/accessors/1", json!({ "componentType": U16, "type": "SCALAR", "count": half }));
    too_large(scene.glb(), &["accessor 1", "elements up to it"]);

    let mut scene = GltfFile::triangle();
    scene.set("/accessors/0", json!({ "componentType": F32, "type": "VEC3", "count": 1 << 26 }));
    too_large(scene.glb(), &["mesh 0, primitive 0", "vertices: 67108864, more than"]);

    let mut scene = GltfFile::triangle();
    scene.set("/accessors/1", json!({ "componentType": U16, "type": "SCALAR", "count": 1 << 28 }));
    too_large(scene.glb(), &["mesh 0", "corners of triangles up to it"]);
}

#[test]
fn meshes_that_are_named_often_are_refused() {
    let mut scene = GltfFile::triangle();
    scene.set("/accessors/0", json!({ "componentType": F32, "type": "VEC3", "count": 1 << 20 }));
    let primitive = json!({ "attributes": { "POSITION": 0 } });
    scene.set("/meshes", json!([{ "primitives": vec![primitive; 40] }]));
    too_large(scene.glb(), &["mesh 0", "vertices up to it"]);

    scene.set("/accessors/0/count", json!(1 << 24));
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": 1 });
    scene.set("/meshes", json!([{ "primitives": vec![primitive; 40] }]));
    too_large(scene.glb(), &["mesh 0", "vertices in accessors up to it"]);

    let mut scene = everything();
    scene.set("/nodes", json!(vec![json!({ "mesh": 1, "skin": 0 }); 600_000]));
    scene.set("/scenes", json!([]));
    scene.remove("/scene");
    scene.remove("/skins/0/inverseBindMatrices");
    scene.set("/skins/0/joints", json!([1, 2, 1, 2]));
    too_large(scene.glb(), &["node", "up to it"]);

    let mut scene = GltfFile::triangle();
    let primitive = scene.json["meshes"][0]["primitives"][0].clone();
    scene.set("/meshes/0/primitives", json!(vec![primitive; 5_000]));
    scene.set("/nodes", json!(vec![json!({ "mesh": 0 }); 5_000]));
    scene.set("/scenes/0/nodes", json!((0..5_000).collect::<Vec<_>>()));
    too_large(scene.glb(), &["node", "objects up to it"]);

    let mut scene = everything();
    let many = json!({ "componentType": F32, "type": "VEC3", "count": 1u64 << 28 });
    let many = scene.push("accessors", many);
    scene.set(
        "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes",
        json!({ "TRANSLATION": many }),
    );
    too_large(scene.glb(), &["node 0", "objects up to it"]);
}

#[test]
fn animations_without_end_are_refused() {
    let mut scene = everything();
    let times = scene
        .push("accessors", json!({ "componentType": F32, "type": "SCALAR", "count": 1 << 20 }));
    let turns =
        scene.push("accessors", json!({ "componentType": F32, "type": "VEC4", "count": 1 << 20 }));
    scene.set("/animations/0/samplers/0", json!({ "input": times, "output": turns }));
    let channel = json!({ "sampler": 0, "target": { "node": 2, "path": "rotation" } });
    scene.set("/animations/0/channels", json!(vec![channel; 100]));
    too_large(scene.glb(), &["animation 0, channel", "numbers in keys up to it"]);
}

#[test]
fn json_that_grows_in_memory_is_refused() {
    let nodes = "{},".repeat(3_000_000);
    let text = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{nodes}{{}}]}}");
    too_large(text.into_bytes(), &["JSON", "bytes of JSON in memory"]);
    let mut scene = GltfFile::triangle();
    scene.set("/nodes", json!(vec![json!({}); 50]));
    let limits = Limits { nodes: 49, ..Limits::default() };
    let limits = LoadOptions { limits, ..LoadOptions::default() };
    let error = read(scene.glb(), None, &limits).map(drop).expect_err("too many");
    assert!(error.to_string().contains("nodes: 50, more than the limit of 49"), "{error}");
}

#[test]
fn large_images_are_refused_by_their_heads() {
    for (width, height) in [(60_000, 60_000), (60_000, 1), (1, 16_385)] {
        let mut scene = GltfFile::triangle();
        let view = scene.view(&png_head(width, height));
        scene.set("/images", json!([{ "bufferView": view, "mimeType": "image/png" }]));
        scene.show_images(1);
        too_large(
            scene.glb(),
            &["image 0", "pixels along a side of", "more than the limit of 16384"],
        );
    }
    let mut scene = GltfFile::triangle();
    let view = scene.view(&png_head(0x7FFF_FFFF, 0x7FFF_FFFF));
    scene.set("/images", json!([{ "bufferView": view, "mimeType": "image/png" }]));
    scene.show_images(1);
    too_large(scene.glb(), &["image 0", "it cannot be decoded: Memory limit exceeded"]);
    let mut scene = GltfFile::triangle();
    let view = scene.view(&png_head(16_384, 16_384));
    let image = json!({ "bufferView": view, "mimeType": "image/png" });
    scene.set("/images", json!(vec![image; 3]));
    scene.show_images(3);
    too_large(scene.glb(), &["image 2", "bytes of pixels up to it"]);
}

/// Returns a PNG that claims this size but is almost empty.
pub fn png_head(width: u32, height: u32) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], data: &[u8]| {
        let mut body = kind.to_vec();
        body.extend_from_slice(data);
        let sum = checksum(&body);
        [&(data.len() as u32).to_be_bytes()[..], &body, &sum.to_be_bytes()].concat()
    };
    let size = [width.to_be_bytes(), height.to_be_bytes()].concat();
    let head = [&size[..], &[8, 6, 0, 0, 0]].concat();
    [
        &b"\x89PNG\r\n\x1A\n"[..],
        &chunk(b"IHDR", &head),
        &chunk(b"IDAT", &[0x78, 0x9C, 3, 0, 0, 0, 0, 1]),
    ]
    .concat()
}

/// Returns the CRC-32 of PNG.
fn checksum(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| {
            (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg())
        })
    })
}

#[test]
fn a_chain_of_nodes_may_be_as_deep_as_it_likes() {
    let depth = 100_000;
    let mut scene = GltfFile::triangle();
    let mut nodes: Vec<_> = (1..depth).map(|child| json!({ "children": [child] })).collect();
    nodes.push(json!({ "mesh": 0 }));
    scene.set("/nodes", json!(nodes));
    let start = Instant::now();
    let source =
        read(scene.glb(), None, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(source.document.nodes().len(), depth);
    let last = depth - 1;
    scene.set(&format!("/nodes/{last}/children"), json!([0]));
    let error = read(scene.glb(), None, &strict()).map(drop).expect_err("a circle");
    assert!(error.to_string().contains("its own ancestor"), "{error}");
    assert!(start.elapsed() < Duration::from_secs(20), "took {:?}", start.elapsed());
}
