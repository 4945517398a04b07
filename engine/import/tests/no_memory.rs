//! Tests that loading without memory returns an error instead of ending the process. The process
//! has a single test, since its allocator has a limit.

#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

use std::alloc::System;
use std::ops::ControlFlow;

use antumbra_import::{Cause, ImportError, LoadOptions, load_bytes};
use cap::Cap;
use gltf_files::files::{F32, GltfFile};
use serde_json::json;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

const MIB: usize = 1 << 20;

/// Loads with `free_bytes` bytes of memory beyond those in use.
fn load_within(bytes: Vec<u8>, free_bytes: usize) -> Result<usize, ImportError> {
    let all = ALLOCATOR.allocated() + free_bytes;
    ALLOCATOR.set_limit(all).expect("less is in use");
    let options = LoadOptions::default();
    let loaded = load_bytes(bytes, None, &options, &mut |_| ControlFlow::Continue(()));
    ALLOCATOR.set_limit(usize::MAX).expect("there is no limit");
    loaded.map(|imported| imported.scene.objects.len())
}

fn with_image(side: u32) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels = image::RgbaImage::new(side, side);
    pixels.write_to(&mut bytes, image::ImageFormat::Png).expect("it can be encoded");
    let mut scene = GltfFile::triangle();
    let view = scene.view(&bytes.into_inner());
    scene.set("/images", json!([{ "bufferView": view, "mimeType": "image/png" }]));
    scene.set("/textures", json!([{ "source": 0 }]));
    scene.show_images(1);
    scene.glb()
}

fn with_vertices(count: usize) -> Vec<u8> {
    let mut scene = GltfFile::triangle();
    scene.set("/accessors/0", json!({ "componentType": F32, "type": "VEC3", "count": count }));
    scene.remove("/meshes/0/primitives/0/indices");
    scene.glb()
}

#[test]
fn what_there_is_no_memory_for_is_refused_by_name() {
    let cases = [
        (with_image(2048), 16 * MIB, "image 0"),
        (with_vertices(900_000), 48 * MIB, "mesh 0, primitive 0"),
    ];
    for (bytes, free_bytes, object) in cases {
        let refused = load_within(bytes.clone(), free_bytes).expect_err("it takes more");
        let said = refused.to_string();
        assert_eq!(refused.cause, Cause::NoMemory, "{said}");
        assert!(said.contains(object) && said.contains("there is no memory"), "{said}");
        load_within(bytes, 1024 * MIB).expect("there is enough");
    }
}
