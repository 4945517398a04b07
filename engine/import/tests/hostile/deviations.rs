//! Tests of spellings, versions, deviations of shown elements, and broken elements without which a
//! scene can be shown.

use serde_json::{Value, json};

use super::tolerated::{Outcome::*, Row, add, as_floats, elsewhere, keys, matrix, vendor};

/// Spellings and versions.
pub const SPELLINGS: &[Row] = &[
    ("nothing", |_| {}, Opens),
    ("whole numbers as 1.0", |s| as_floats(&mut s.json), Opens),
    ("vendors' properties", |s| vendor(&mut s.json), Opens),
    ("a minor version", |s| s.set("/asset/version", json!("2.1")), Opens),
    (
        "a minor version for any reader",
        |s| s.set("/asset", json!({ "version": "2.9", "minVersion": "2.0" })),
        Opens,
    ),
    (
        "a minor version for its readers",
        |s| s.set("/asset/minVersion", json!("2.1")),
        Refused(&["asset", "needs glTF \"2.1\""]),
    ),
    (
        "a version of one part",
        |s| s.set("/asset/version", json!("2")),
        Noted(&["\"2\" is read as 2.0"]),
    ),
    (
        "a version cut off",
        |s| s.set("/asset/version", json!("2.")),
        Noted(&["\"2.\" is read as 2.0"]),
    ),
    (
        "a version of three parts",
        |s| s.set("/asset/version", json!("2.0.0")),
        Noted(&["asset: its version \"2.0.0\" is read as 2.0"]),
    ),
    (
        "a least version of three parts",
        |s| s.set("/asset", json!({ "version": "2.1", "minVersion": "2.0.1" })),
        Noted(&["asset: its minVersion \"2.0.1\" is read as 2.0"]),
    ),
    ("a least version of earlier readers", |s| s.set("/asset/minVersion", json!("1.0")), Opens),
    (
        "a later version for any reader",
        |s| s.set("/asset", json!({ "version": "3.0", "minVersion": "2.0" })),
        Opens,
    ),
    (
        "an earlier version",
        |s| s.set("/asset/version", json!("1.0.1-dev")),
        Refused(&["asset", "needs glTF \"1.0.1-dev\""]),
    ),
    (
        "no version",
        |s| s.set("/asset/version", json!("two.zero")),
        Refused(&["asset: its version \"two.zero\" is not a version like 2.0"]),
    ),
    (
        "half a version",
        |s| s.set("/asset/version", json!("2.x")),
        Refused(&["asset: its version \"2.x\" is not a version like 2.0"]),
    ),
    (
        "a major version",
        |s| s.set("/asset/version", json!("3.0")),
        Refused(&["asset", "needs glTF \"3.0\""]),
    ),
    ("an extension", |s| s.set("/extensionsUsed/4", json!("VENDOR_x")), Noted(&["VENDOR_x"])),
    (
        "an extension for its readers",
        |s| s.set("/extensionsRequired", json!(["VENDOR_x"])),
        Refused(&["extensionsRequired", "VENDOR_x"]),
    ),
    (
        "an extension that is named twice",
        |s| {
            s.set("/extensionsUsed/4", json!("VENDOR_x"));
            s.set("/extensionsUsed/5", json!("VENDOR_x"))
        },
        Noted(&["VENDOR_x"]),
    ),
    (
        "a list that is an object",
        |s| s.set("/scenes/0", json!([null, null, null, [0]])),
        Refused(&["scene 0: it must be an object, and is a list"]),
    ),
    (
        "a list that is an object far below",
        |s| {
            s.set(
                "/meshes/0/primitives/0",
                json!([{ "POSITION": 0 }, null, null, null, null, 4, null]),
            )
        },
        Broken(&["mesh 0, primitives: one of its elements is a list"]),
    ),
    (
        "lists of lists of others",
        |s| {
            s.set("/nodes/0/extras", json!([[1], [2]]));
            s.set("/extensions/VENDOR_x", json!({ "a": [[1]] }))
        },
        Noted(&["VENDOR_x", "extensionsUsed must name it"]),
    ),
    ("no list", |s| s.set("/nodes", json!({})), Refused(&["nodes: it must be a list"])),
    (
        "half an index",
        |s| s.set("/nodes/0/mesh", json!(0.5)),
        Broken(&["node 0, mesh: it must be the index"]),
    ),
    (
        "a name that is a number",
        |s| s.set("/nodes/0/name", json!(5)),
        Broken(&["node 0, name: it must be text, and is 5"]),
    ),
    (
        "a used element that is null",
        |s| s.set("/meshes/0", Value::Null),
        Broken(&["mesh 0: it must be an object, and is null"]),
    ),
];

/// Deviations of shown elements.
pub const SHOWN: &[Row] = &[
    (
        "a child as root, its parent outside",
        |s| {
            s.remove("/animations");
            s.set("/scenes/0/nodes", json!([0, 2, 3]))
        },
        Noted(&["node 2: a root of the scene, although a child of node 1"]),
    ),
    (
        "a child as root, its parent inside",
        |s| s.set("/scenes/0/nodes", json!([2, 0, 1, 3])),
        Noted(&["node 2: a child of node 1 and a root", "shown once"]),
    ),
    (
        "a root of two parents",
        |s| s.set("/nodes/3/children", json!([2])),
        Broken(&["node 2 is a child of node 1 already"]),
    ),
    (
        "bounds that do not hold",
        |s| s.set("/accessors/0/max", json!([0.5, 0.5, 0])),
        Noted(&["accessor 0: its min and max do not hold"]),
    ),
    (
        "bounds of two numbers",
        |s| s.set("/accessors/0/min", json!([0, 0])),
        Noted(&["accessor 0: its min and max"]),
    ),
    (
        "bounds of text",
        |s| s.set("/accessors/0/min", json!("low")),
        Noted(&["accessor 0: its min and max"]),
    ),
    (
        "bounds that hold",
        |s| {
            s.set("/accessors/0/min", json!([0, 0, 0]));
            s.set("/accessors/0/max", json!([1.0, 1, 0]))
        },
        Opens,
    ),
    ("a matrix that shears", |s| matrix(s, 4, 0.5), Noted(&["node 0: its matrix shears"])),
    (
        "a matrix that projects",
        |s| matrix(s, 3, 0.5),
        Noted(&["node 0: its matrix is not a transform"]),
    ),
    (
        "a matrix and a place",
        |s| {
            matrix(s, 12, 0.5);
            s.set("/nodes/0/translation", json!([9, 9, 9]))
        },
        Noted(&["node 0: it has a matrix beside"]),
    ),
    (
        "a matrix that an animation moves",
        |s| {
            matrix(s, 12, 0.5);
            s.set("/animations/0/channels/0/target/node", json!(0))
        },
        Noted(&["node 0: animations move it"]),
    ),
    (
        "a long rotation",
        |s| s.set("/nodes/0/rotation", json!([0, 0, 0, 2])),
        Noted(&["node 0: its rotation is not of length 1"]),
    ),
    (
        "joints apart",
        |s| s.set("/skins/0/joints", json!([1, 0])),
        Noted(&["skin 0: its joints have no common root"]),
    ),
    (
        "a missing set of coordinates",
        |s| s.set("/materials/0/emissiveTexture/texCoord", json!(1)),
        Noted(&["mesh 0, primitive 0: it has no texture coordinates for a texture"]),
    ),
    (
        "a target of normals without normals",
        |s| s.set("/meshes/1/primitives/0/targets/0/NORMAL", json!(0)),
        Noted(&["mesh 1, primitive 0: a morph target has normals or tangents"]),
    ),
    (
        "a target of tangents without tangents",
        |s| {
            let normals = s.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
            s.set("/meshes/1/primitives/0/attributes/NORMAL", json!(normals));
            s.set("/meshes/1/primitives/0/targets/0/NORMAL", json!(0));
            s.set("/meshes/1/primitives/0/targets/0/TANGENT", json!(0))
        },
        Noted(&["mesh 1, primitive 0: a morph target has normals or tangents"]),
    ),
    (
        "quantised meshes that need not be known",
        |s| s.set("/extensionsUsed/4", json!("KHR_mesh_quantization")),
        Noted(&["KHR_mesh_quantization", "extensionsRequired must name it"]),
    ),
    (
        "quantised meshes that must be known",
        |s| {
            s.set("/extensionsUsed/4", json!("KHR_mesh_quantization"));
            s.set("/extensionsRequired", json!(["KHR_mesh_quantization"]))
        },
        Opens,
    ),
    (
        "bounds beyond 32 bits",
        |s| s.set("/accessors/0/max", json!([1e39, 1, 0])),
        Noted(&["accessor 0: its min and max"]),
    ),
    (
        "a broken light",
        |s| s.set("/extensions/KHR_lights_punctual/lights/0/type", json!("area")),
        Broken(&["light 0: its type"]),
    ),
    (
        "a broken accessor",
        |s| s.set("/accessors/0/count", json!("3")),
        Refused(&["accessor 0, count: it must be a whole number"]),
    ),
    (
        "a broken buffer",
        |s| s.set("/buffers", json!([{ "byteLength": 9999, "uri": "gone.bin" }])),
        Refused(&["buffer 0"]),
    ),
    (
        "a broken skin",
        |s| s.set("/skins/0/joints", json!([])),
        Broken(&["skin 0: it has no joints"]),
    ),
    ("a broken sampler", |s| s.set("/samplers/0/wrapS", json!(1)), Broken(&["sampler 0"])),
];

/// Animations and images without which a scene can be shown.
pub const LEFT_OUT: &[Row] = &[
    (
        "a clip that is a number",
        |s| s.set("/animations/0", json!(5)),
        Broken(&["animation 0: it must be an object, and is 5", "animation 0 is not played"]),
    ),
    (
        "a clip without samplers",
        |s| s.remove("/animations/0/samplers"),
        Broken(&["animation 0: it has no samplers", "not played"]),
    ),
    (
        "a clip of broken keys",
        |s| {
            let at = keys(s);
            s.set(&format!("/accessors/{at}/count"), json!(99))
        },
        Broken(&["it ends at byte", "animation 0 is not played"]),
    ),
    (
        "a clip of typed keys",
        |s| {
            let at = keys(s);
            s.set(&format!("/accessors/{at}/count"), json!("two"))
        },
        Broken(&["count: it must be a whole number", "not played"]),
    ),
    (
        "a clip in no file",
        |s| elsewhere(s, false),
        Broken(&["buffer 1", "animation 0 is not played"]),
    ),
    (
        "a clip that runs back",
        |s| {
            let at = s.floats("SCALAR", &[1.0, 0.0]);
            s.set("/animations/0/samplers/1/input", json!(at))
        },
        Broken(&["animation 0", "not later than the one before", "not played"]),
    ),
    (
        "a clip from before 0 s",
        |s| {
            let at = s.floats("SCALAR", &[-1.0, 1.0]);
            s.set("/animations/0/samplers/1/input", json!(at))
        },
        Noted(&["animation 0", "a key is before 0 s"]),
    ),
    (
        "a clip of what is not shown",
        |s| {
            add(s, "nodes", json!({}));
            s.set("/animations/0/channels/0/target/node", json!(4))
        },
        Noted(&["animation 0: a channel moves a node that is not in the scene"]),
    ),
    (
        "an image in no file",
        |s| s.set("/images/0", json!({ "uri": "gone.png" })),
        Broken(&["image 0", "checkers are shown for image 0 (\"gone.png\")"]),
    ),
    (
        "an image elsewhere",
        |s| s.set("/images/0", json!({ "uri": "../../secret.png" })),
        Broken(&["image 0", "leads out", "checkers"]),
    ),
    (
        "an image of another kind",
        |s| s.set("/images/0", json!({ "uri": "data:;base64,R0lGODlh" })),
        Broken(&["image 0: it is not a PNG, JPEG, WebP or KTX2"]),
    ),
    (
        "an image in no buffer",
        |s| elsewhere(s, true),
        Broken(&["buffer 1", "checkers are shown for image 0"]),
    ),
    (
        "an image of normals",
        |s| s.set("/images/1", json!({ "uri": "gone.jpg" })),
        Broken(&["image 1", "image 1 (\"gone.jpg\") counts as a neutral normal texture"]),
    ),
    (
        "an image that is a number",
        |s| s.set("/images/0", json!(1)),
        Broken(&["image 0: it must be an object"]),
    ),
];
