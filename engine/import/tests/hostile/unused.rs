//! Tests of faults in elements that are not shown.

use serde_json::{Value, json};

use super::tolerated::{Outcome::*, Row, accessor, add, buffer, light};

/// Elements that are not shown.
pub const UNUSED: &[Row] = &[
    (
        "buffer without source",
        |s| buffer(s, json!({ "byteLength": 4 })),
        Unused("buffer 1: it has no URI"),
    ),
    (
        "buffer that is a list",
        |s| buffer(s, json!([4, null])),
        Unused("buffer 1: it must be an object, and is a list"),
    ),
    ("buffer in no file", |s| buffer(s, json!({ "byteLength": 4, "uri": "gone.bin" })), Opens),
    ("buffer elsewhere", |s| buffer(s, json!({ "byteLength": 4, "uri": "http://x/y" })), Opens),
    (
        "buffer of no length",
        |s| buffer(s, json!({ "byteLength": "four" })),
        Unused("buffer 1, byteLength: it must be"),
    ),
    (
        "view without buffer",
        |s| add(s, "bufferViews", json!({ "buffer": 9, "byteLength": 1 })),
        Unused("buffer 9 does not exist"),
    ),
    (
        "view too long",
        |s| add(s, "bufferViews", json!({ "buffer": 0, "byteLength": 1 << 30 })),
        Unused("it ends at byte"),
    ),
    (
        "view of odd target",
        |s| add(s, "bufferViews", json!({ "buffer": 0, "byteLength": 1, "target": 5 })),
        Unused("its target does not exist"),
    ),
    (
        "accessor of unknown type",
        |s| accessor(s, "type", json!("VEC5")),
        Unused("its type does not exist"),
    ),
    (
        "accessor of typed type",
        |s| accessor(s, "type", json!(3)),
        Unused("type: it must be one of"),
    ),
    (
        "accessor of unknown numbers",
        |s| accessor(s, "componentType", json!(1)),
        Unused("its componentType does not exist"),
    ),
    (
        "accessor of textual count",
        |s| accessor(s, "count", json!("many")),
        Unused("count: it must be a whole number from 0 on, and is the text \"many\""),
    ),
    (
        "accessor of half a count",
        |s| accessor(s, "count", json!(1.5)),
        Unused("count: it must be a whole number from 0 on, and is 1.5"),
    ),
    (
        "accessor below nothing",
        |s| accessor(s, "count", json!(-1)),
        Unused("count: it must be a whole number from 0 on, and is -1"),
    ),
    ("accessor of nothing", |s| accessor(s, "count", json!(0)), Unused("it has no elements")),
    ("accessor of very much", |s| accessor(s, "count", json!(1_u64 << 60)), Opens),
    (
        "accessor without view",
        |s| accessor(s, "bufferView", json!(99)),
        Unused("buffer view 99 does not exist"),
    ),
    (
        "accessor of a wide view",
        |s| accessor(s, "bufferView", json!(1_u64 << 32)),
        Unused("bufferView: 4294967296 is more than any index"),
    ),
    (
        "accessor that is a number",
        |s| add(s, "accessors", json!(7)),
        Unused("it must be an object, and is 7"),
    ),
    (
        "accessor that is null",
        |s| add(s, "accessors", Value::Null),
        Unused("it must be an object, and is null"),
    ),
    (
        "light of unknown kind",
        |s| light(s, json!({ "type": "area" })),
        Unused("light 1: its type does not exist"),
    ),
    ("light without kind", |s| light(s, json!({})), Unused("light 1: it has no type")),
    (
        "spot without cone",
        |s| light(s, json!({ "type": "spot" })),
        Unused("light 1: it is a spot light without a cone"),
    ),
    (
        "camera of unknown kind",
        |s| add(s, "cameras", json!({ "type": "fisheye" })),
        Unused("camera 1: its type does not exist"),
    ),
    (
        "camera without numbers",
        |s| add(s, "cameras", json!({ "type": "perspective" })),
        Unused("camera 1: it has no values"),
    ),
    (
        "material of glass",
        |s| add(s, "materials", json!({ "alphaMode": "GLASS" })),
        Unused("material 1: its alphaMode"),
    ),
    (
        "material without texture",
        |s| add(s, "materials", json!({ "emissiveTexture": { "index": 9 } })),
        Unused("texture 9 does not exist"),
    ),
    (
        "texture without image",
        |s| add(s, "textures", json!({ "source": 9 })),
        Unused("image 9 does not exist"),
    ),
    ("sampler of unknown ways", |s| add(s, "samplers", json!({ "wrapS": 1 })), Unused("sampler 1")),
    ("image of nothing", |s| add(s, "images", json!({})), Unused("image 3: it has neither")),
    ("image in no file", |s| add(s, "images", json!({ "uri": "gone.png" })), Opens),
    (
        "mesh without positions",
        |s| add(s, "meshes", json!({ "primitives": [{ "attributes": { "POSITION": 99 } }] })),
        Unused("accessor 99 does not exist"),
    ),
    (
        "mesh without primitives",
        |s| add(s, "meshes", json!({})),
        Unused("mesh 2: it has no primitives"),
    ),
    (
        "mesh of unknown mode",
        |s| add(s, "meshes", json!({ "primitives": [{ "attributes": {}, "mode": 9 }] })),
        Unused("its mode does not exist"),
    ),
    (
        "node without mesh",
        |s| add(s, "nodes", json!({ "mesh": 99 })),
        Unused("node 4: mesh 99 does not exist"),
    ),
    (
        "node of a short matrix",
        |s| add(s, "nodes", json!({ "matrix": [1] })),
        Unused("node 4, matrix: it must be"),
    ),
    (
        "node of a wide mesh",
        |s| add(s, "nodes", json!({ "mesh": 1_u64 << 40 })),
        Unused("1099511627776 is more than"),
    ),
    (
        "node of no child",
        |s| add(s, "nodes", json!({ "children": [99] })),
        Unused("child node 99 does not exist"),
    ),
    (
        "node that is its own child",
        |s| add(s, "nodes", json!({ "children": [4] })),
        Noted(&["node 4: it is its own ancestor", "not all of that is shown"]),
    ),
    (
        "node that adopts",
        |s| add(s, "nodes", json!({ "children": [2] })),
        Noted(&["node 2 is a child of node 1 already", "not all"]),
    ),
    (
        "node beyond 32 bits",
        |s| add(s, "nodes", json!({ "translation": [0, 1e39, 0] })),
        Unused("node 4: its translation is beyond"),
    ),
    (
        "camera beyond 32 bits",
        |s| {
            let lens = json!({ "yfov": 1, "znear": 1e39 });
            add(s, "cameras", json!({ "type": "perspective", "perspective": lens }))
        },
        Unused("camera 1: its projection is beyond"),
    ),
    (
        "light beyond 32 bits",
        |s| light(s, json!({ "type": "point", "intensity": 1e39 })),
        Unused("light 1: its intensity is beyond"),
    ),
    (
        "material beyond 32 bits",
        |s| add(s, "materials", json!({ "emissiveFactor": [1e39, 0, 0] })),
        Unused("material 1: its emissiveFactor is beyond"),
    ),
    (
        "skin without joints",
        |s| add(s, "skins", json!({ "joints": [] })),
        Unused("skin 1: it has no joints"),
    ),
    ("skin of nothing", |s| add(s, "skins", json!({})), Unused("skin 1: it has no joints")),
    (
        "skin of no nodes",
        |s| add(s, "skins", json!({ "joints": [99] })),
        Unused("node 99 does not exist"),
    ),
    (
        "application's attribute",
        |s| s.set("/meshes/0/primitives/0/attributes/_HEAT", json!(99)),
        Opens,
    ),
];

/// Other parts of a file that are not shown.
pub const ASIDE: &[Row] = &[
    (
        "another scene",
        |s| s.set("/scenes/1", json!({ "nodes": [99] })),
        Noted(&["scene 1: node 99 does not exist"]),
    ),
    (
        "a skin without a mesh",
        |s| s.set("/nodes/2/skin", json!(99)),
        Noted(&["node 2: it has a skin or weights, but no mesh"]),
    ),
    (
        "weights without a mesh",
        |s| s.set("/nodes/2/weights", json!([1])),
        Noted(&["node 2: it has a skin or weights"]),
    ),
    (
        "an extension's lights",
        |s| {
            s.remove("/nodes/3/extensions");
            s.set("/extensions/KHR_lights_punctual", json!(5))
        },
        Noted(&["KHR_lights_punctual: it is not an object"]),
    ),
    (
        "an extension of others",
        |s| s.set("/extensions/VENDOR_x", json!({ "a": [1.0, null] })),
        Noted(&["extension \"VENDOR_x\": extensionsUsed must name it, but does not; unknown"]),
    ),
    ("extras", |s| s.set("/nodes/0/extras", json!({ "mesh": -1.0, "wide": 1_u64 << 60 })), Opens),
];
