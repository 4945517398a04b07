//! Chains of nodes that skins hang on: short files that cost much to load.

use serde_json::{Value, json};

use crate::files::{GltfFile, U8};

/// Returns a file of `chains` chains of `depth` nodes each, and `meshes` nodes whose mesh hangs on
/// the ends of all chains, by `skins` different skins.
pub fn chains(chains: usize, depth: usize, meshes: usize, skins: usize) -> GltfFile {
    let mut scene = GltfFile::triangle();
    let joints = scene.numbers(U8, "VEC4", 3, &[0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0]);
    let weights = scene.floats("VEC4", &[[0.5, 0.5, 0.0, 0.0]; 3].concat());
    scene.set("/meshes/0/primitives/0/attributes/JOINTS_0", json!(joints));
    scene.set("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(weights));
    let count = chains * depth;
    let link = |node: usize| {
        if node % depth == depth - 1 { json!({}) } else { json!({ "children": [node + 1] }) }
    };
    let mut nodes: Vec<Value> = (0..count).map(link).collect();
    nodes.extend((0..meshes).map(|mesh| json!({ "mesh": 0, "skin": mesh % skins })));
    let roots = (0..chains).map(|chain| chain * depth).chain(count..nodes.len());
    scene.set("/scenes/0/nodes", json!(roots.collect::<Vec<_>>()));
    scene.set("/nodes", json!(nodes));
    let ends: Vec<usize> = (1..=chains).map(|chain| chain * depth - 1).collect();
    scene.set("/skins", json!(vec![json!({ "joints": ends }); skins]));
    scene
}
