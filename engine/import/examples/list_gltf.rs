//! Lists the contents of a glTF file: `list_gltf [FILE]`. Without a file it lists a triangle in
//! memory.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

use antumbra_import::{LoadOptions, SceneAnimator, load, load_bytes};
use cull::Projection;

/// A file of one triangle, "sail", on a node that a clip moves up within a second.
const TRIANGLE: &[u8] = br#"{
    "asset": { "version": "2.0" },
    "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "name": "sail", "mesh": 0 }],
    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
    "animations": [{ "name": "hoist", "samplers": [{ "input": 1, "output": 2 }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }] }],
    "accessors": [
        { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
          "min": [0, 0, 0], "max": [1, 1, 0] },
        { "bufferView": 0, "byteOffset": 8, "componentType": 5126, "count": 2, "type": "SCALAR",
          "min": [0], "max": [1] },
        { "bufferView": 0, "componentType": 5126, "count": 2, "type": "VEC3" }],
    "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
    "buffers": [{ "byteLength": 36,
        "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }]
}"#;

fn main() -> Result<(), Box<dyn Error>> {
    let options = LoadOptions::default();
    let progress = &mut |_| ControlFlow::Continue(());
    let loaded = match std::env::args_os().nth(1) {
        Some(file) => load(Path::new(&file), &options, progress)?,
        None => load_bytes(TRIANGLE.to_vec(), None, &options, progress)?,
    };
    let bounds = loaded.bounds();
    let scene = &loaded.scene;
    let meshes = scene.meshes.len() as u64;
    let objects = scene.objects.len() as u64;
    let triangles = scene.triangles();
    println!("{}: {meshes} meshes, {objects} objects, {triangles} triangles", scene.name);
    println!("from {} to {} m", bounds.min, bounds.max);
    if let Some(surfaces) = &scene.surfaces {
        let textures = surfaces.textures.len();
        let lights = surfaces.lights.len();
        println!("{} materials, {textures} textures, {lights} lights", surfaces.materials.len());
    }

    let (_, mut animator, cameras, notes) = SceneAnimator::of(loaded);
    for (number, clip) in animator.clips().iter().enumerate() {
        println!("clip {number}, {}: {:.2} s", clip.name, clip.duration_s());
    }
    for camera in &cameras {
        match camera.projection {
            Projection::Perspective { fov_y } => {
                println!("camera {}: {fov_y:.2} rad high", camera.name);
            }
            Projection::Orthographic { height, .. } => {
                println!("camera {}: orthographic, {height:.2} m high", camera.name);
            }
        }
    }
    for note in &notes {
        println!("note: {note}");
    }
    animator.play(&animator.compatible(None), 0.0, 0.0);
    let changed = animator.changes(0.5).objects.len();
    println!("half a second later: {changed} objects have moved");
    Ok(())
}
