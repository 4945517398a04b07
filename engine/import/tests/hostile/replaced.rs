//! Tests that impossible values of shown elements, and values that make them invisible, are
//! replaced and noted once.

use serde_json::json;

use super::tolerated::{Outcome::*, Row};
use gltf_files::files::GltfFile;

fn light(scene: &mut GltfFile, key: &str, value: serde_json::Value) {
    scene.set(&format!("/extensions/KHR_lights_punctual/lights/0/{key}"), value);
}

fn camera(scene: &mut GltfFile, key: &str, value: serde_json::Value) {
    scene.set(&format!("/cameras/0/perspective/{key}"), value);
}

/// Changes the mode of the first mesh, and removes its indices.
fn mode(scene: &mut GltfFile, mode: u32) {
    scene.remove("/meshes/0/primitives/0/indices");
    scene.set("/meshes/0/primitives/0/mode", json!(mode));
}

/// Lights, cameras, bounds and topologies.
pub const REPLACED: &[Row] = &[
    (
        "a light that takes light away",
        |s| light(s, "intensity", json!(-1)),
        Noted(&["node 3: its light has an intensity below 0"]),
    ),
    (
        "a light of a negative colour",
        |s| light(s, "color", json!([1, -1, 1])),
        Noted(&["node 3: its light has a color that is not between"]),
    ),
    (
        "a light that ends before it begins",
        |s| light(s, "range", json!(0)),
        Noted(&["node 3: its light has a range that is not above 0"]),
    ),
    (
        "a light of an inverted cone",
        |s| light(s, "spot/innerConeAngle", json!(0.6)),
        Noted(&["node 3: its light has angles that are not"]),
    ),
    (
        "an image of no width",
        |s| camera(s, "aspectRatio", json!(0)),
        Noted(&["camera \"camera 0\": its width by height is not between"]),
    ),
    (
        "an image of negative width",
        |s| camera(s, "aspectRatio", json!(-1)),
        Noted(&["its width by height is not between"]),
    ),
    (
        "an image of hardly any width",
        |s| camera(s, "aspectRatio", json!(1e-30)),
        Noted(&["its width by height is not between"]),
    ),
    ("a tall image", |s| camera(s, "aspectRatio", json!(0.1)), Opens),
    (
        "a camera that begins behind all",
        |s| camera(s, "znear", json!(1e5)),
        Noted(&["camera \"camera 0\": it sees nothing of the scene at rest"]),
    ),
    (
        "a camera that looks away",
        |s| {
            s.set("/nodes/3/translation", json!([0, 0, 50]));
            s.set("/nodes/3/rotation", json!([0, 1, 0, 0]))
        },
        Noted(&["it sees nothing of the scene at rest"]),
    ),
    (
        "a camera that looks away from nothing",
        |s| {
            camera(s, "znear", json!(1e5));
            s.set("/scenes/0/nodes", json!([3]));
            s.remove("/animations")
        },
        Noted(&["there is nothing to see"]),
    ),
    (
        "a material that swallows light",
        |s| {
            s.set(
                "/materials/0/extensions/KHR_materials_emissive_strength",
                json!({ "emissiveStrength": -0.5 }),
            );
            s.set("/extensionsUsed/4", json!("KHR_materials_emissive_strength"))
        },
        Noted(&["it has a factor that is out of its range"]),
    ),
    (
        "a material of more than all colour",
        |s| s.set("/materials/0/pbrMetallicRoughness/baseColorFactor", json!([2, 1, 1, 1])),
        Noted(&["it has a factor that is out of its range"]),
    ),
    (
        "a skin of a mesh without joints",
        |s| {
            s.remove("/meshes/1/primitives/0/attributes/JOINTS_0");
            s.remove("/meshes/1/primitives/0/attributes/WEIGHTS_0")
        },
        Noted(&["node 1: its mesh has no joints, and its skin is ignored"]),
    ),
    (
        "positions without bounds",
        |s| s.remove("/accessors/0/min"),
        Noted(&["accessor 0: it has no min or no max, as positions"]),
    ),
    (
        "positions with neither",
        |s| {
            s.remove("/accessors/0/min");
            s.remove("/accessors/0/max")
        },
        Noted(&["accessor 0: it has no min or no max, as positions"]),
    ),
    (
        "times without bounds",
        |s| {
            let times = s.json["animations"][0]["samplers"][0]["input"].clone();
            s.remove(&format!("/accessors/{times}/max"))
        },
        Noted(&["it has no min or no max, as positions and times"]),
    ),
    (
        "lines of three vertices",
        |s| mode(s, 1),
        Noted(&["mesh 0, primitive 0: its last vertices make no whole line"]),
    ),
    ("a loop of three vertices", |s| mode(s, 2), Opens),
    (
        "triangles of two indices",
        |s| s.set("/accessors/1/count", json!(2)),
        Noted(&["mesh 0, primitive 0: its last vertices"]),
    ),
];
