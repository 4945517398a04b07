//! Tests that an animator allocates at creation and when clips change, but never in the frame loop.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::ops::ControlFlow;

use allocation_counter::measure;
use antumbra_import::{LoadOptions, SceneAnimator, load_bytes};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

/// Returns a triangle on a sliding node, and another one that is morphed.
fn scene() -> Vec<u8> {
    let numbers: [f32; 28] = [
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, // positions
        0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, // what the target adds
        0.0, 1.0, // times
        0.0, 0.0, 0.0, 5.0, 0.0, 0.0, // places
        0.0, 1.0, // weights
    ];
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    let accessor = |first: usize, kind: &str, count: usize| {
        json!({
            "bufferView": 0, "byteOffset": first * 4, "componentType": 5126, "type": kind,
            "count": count, "min": vec![0.0; if kind == "VEC3" { 3 } else { 1 }],
            "max": if kind == "VEC3" { vec![5.0, 1.0, 1.0] } else { vec![1.0] },
        })
    };
    let clip = |node: usize, path: &str, output: usize| {
        json!({
            "samplers": [{"input": 2, "output": output}],
            "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
        })
    };
    let document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"mesh": 1}],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0}}]},
            {"primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 1}]}]},
        ],
        "animations": [clip(0, "translation", 3), clip(1, "weights", 4)],
        "accessors": [
            accessor(0, "VEC3", 3), accessor(9, "VEC3", 3), accessor(18, "SCALAR", 2),
            accessor(20, "VEC3", 2), accessor(26, "SCALAR", 2),
        ],
        "bufferViews": [{"buffer": 0, "byteLength": bytes.len()}],
        "buffers": [{"byteLength": bytes.len(), "uri": uri}],
    });
    document.to_string().into_bytes()
}

#[test]
fn the_loop_does_not_allocate() {
    let go_on = &mut |_| ControlFlow::Continue(());
    let imported = load_bytes(scene(), None, &LoadOptions::default(), go_on).unwrap();
    let (_, mut animator, _, _) = SceneAnimator::of(imported);
    animator.play(&animator.compatible(None), 0.0, 0.0);
    assert_eq!(animator.compatible(None).len(), 2);
    assert!(!animator.changes(0.0).is_empty());
    let mut walk = || {
        for frame in 0..200 {
            let changes = animator.changes(f64::from(frame) / 60.0);
            assert!(changes.objects.len() <= 2 && changes.poses.len() <= 1);
        }
    };
    walk();
    assert_eq!(measure(walk).count_total, 0);
}
