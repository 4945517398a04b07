//! Tests of short files with few parts and many pairs of parts: the cost of loading and playing is
//! bounded by the parts. The process has a single test, since its allocator counts.

#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use antumbra_import::{GltfScene, LoadOptions, load_bytes};
use gltf_files::files::{F32, GltfFile};
use gltf_files::{chains, loaded, playback};
use peak_alloc::PeakAlloc;
use serde_json::{Value, json};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

const MIB: usize = 1 << 20;
/// A time far above the time for any of these files, and far below the time for their pairs.
const LONGEST: Duration = Duration::from_secs(30);

fn load(scene: &GltfFile) -> GltfScene {
    let options = LoadOptions::default();
    let imported = load_bytes(scene.glb(), None, &options, &mut |_| ControlFlow::Continue(()));
    imported.unwrap_or_else(|error| panic!("{error}"))
}

/// Adds a clip of one key for each of these nodes, of weights or translations.
fn clips(scene: &mut GltfFile, targets: impl Iterator<Item = (usize, &'static str)>) {
    let times = scene.floats("SCALAR", &[0.0, 1.0]);
    let moves = scene.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let weighs = scene.floats("SCALAR", &[0.0, 1.0]);
    let clip = |(node, path): (usize, &'static str)| {
        let output = if path == "weights" { weighs } else { moves };
        let sampler = json!({ "input": times, "output": output });
        let channel = json!({ "sampler": 0, "target": { "node": node, "path": path } });
        json!({ "samplers": [sampler], "channels": [channel] })
    };
    scene.set("/animations", json!(targets.map(clip).collect::<Vec<Value>>()));
}

fn roots(scene: &mut GltfFile, nodes: Vec<Value>) {
    scene.set("/scenes/0/nodes", json!((0..nodes.len()).collect::<Vec<_>>()));
    scene.set("/nodes", json!(nodes));
}

/// Returns many morphed nodes, and many clips for other nodes.
fn morphs_and_clips(count: usize) -> GltfFile {
    let mut scene = GltfFile::triangle();
    scene.set("/meshes/0/primitives/0/targets", json!([{ "POSITION": 0 }]));
    scene.set("/meshes/0/weights", json!([0.5]));
    let mut nodes = vec![json!({ "mesh": 0 }); count];
    nodes.push(json!({}));
    roots(&mut scene, nodes);
    clips(&mut scene, (0..count).map(|_| (count, "translation")));
    scene
}

/// Returns many morphed nodes, and a clip for each of them.
fn morphs_with_clips(count: usize) -> GltfFile {
    let mut scene = morphs_and_clips(count);
    clips(&mut scene, (0..count).map(|node| (node, "weights")));
    scene
}

/// Returns chains of joints with a clip each, and many meshes on them.
fn skins_and_channels(depth: usize, meshes: usize) -> GltfFile {
    let mut scene = chains::chains(2, depth, meshes, 1);
    clips(&mut scene, (0..2 * depth).map(|node| (node, "translation")));
    scene
}

/// Returns many instances with many lights among them.
fn instances_and_lights(count: usize) -> GltfFile {
    let mut scene = GltfFile::triangle();
    let places = json!({ "componentType": F32, "type": "VEC3", "count": count });
    let places = scene.push("accessors", places);
    scene.set("/extensionsUsed", json!(["EXT_mesh_gpu_instancing", "KHR_lights_punctual"]));
    scene.set("/extensions/KHR_lights_punctual/lights", json!([{ "type": "point" }]));
    let light = json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    let mut nodes = vec![light; count];
    let attributes = json!({ "attributes": { "TRANSLATION": places } });
    nodes.push(json!({ "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": attributes } }));
    roots(&mut scene, nodes);
    scene
}

/// Returns `count` points, all at one place or all at different places.
fn points(count: usize, are_apart: bool) -> GltfFile {
    let mut scene = GltfFile::triangle();
    let mut places = json!({ "componentType": F32, "type": "VEC3", "count": count });
    if are_apart {
        let numbers: Vec<u8> = (0..3 * count)
            .flat_map(|number| ((number * 7919 % 1_000_003) as f32).to_le_bytes())
            .collect();
        places["bufferView"] = json!(scene.view(&numbers));
    }
    let places = scene.push("accessors", places);
    let primitive = json!({ "attributes": { "POSITION": places }, "mode": 0 });
    scene.set("/meshes/0/primitives", json!([primitive]));
    scene
}

#[test]
fn pairs_cost_what_their_parts_cost() {
    for (what, scene, most_bytes) in [
        // A box per pair would take 384 MB.
        ("4,000 morphed nodes, 4,000 clips of others", morphs_and_clips(4000), 64 * MIB),
        ("4,000 morphed nodes, a clip for each", morphs_with_clips(4000), 64 * MIB),
        // A skeleton per mesh would take more than 1 GB.
        ("2,000 meshes on chains of 20,000", chains::chains(2, 10_000, 2000, 1), 64 * MIB),
        ("300 skins on chains of 20,000", chains::chains(2, 10_000, 300, 300), 640 * MIB),
        ("1,000 meshes, 4,000 joints and clips", skins_and_channels(2000, 1000), 64 * MIB),
        ("20,000 instances, 20,000 lights", instances_and_lights(20_000), 128 * MIB),
        // Solids would take gigabytes.
        ("2,000,000 points in one place", points(2_000_000, false), 160 * MIB),
        ("1,000,000 points", points(1_000_000, true), 160 * MIB),
    ] {
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        let began = Instant::now();
        let imported = load(&scene);
        loaded::check(&imported);
        playback::play(imported);
        let took = began.elapsed();
        let peak = ALLOCATOR.peak_usage() - before;
        eprintln!("{what}: {} MiB at most, {took:?}", peak / MIB);
        assert!(peak < most_bytes, "{what}: {} MiB", peak / MIB);
        assert!(took < LONGEST, "{what}: {took:?}");
    }
}
