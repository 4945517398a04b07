//! Tests of files with a single fault each. If broken parts are refused, the error names the object
//! and the reason; otherwise a note does, if something is still visible.

use std::ops::ControlFlow;

use antumbra_import::{LoadOptions, load_bytes, read};
use serde_json::json;

use crate::strict;
use gltf_files::files::{F32, GltfFile, U8, U16, U32, everything};

/// A change of a file with all features, and parts of the expected error.
pub type Case = (fn(&mut GltfFile), &'static [&'static str]);

const POSITION: &str = "/meshes/0/primitives/0/attributes/POSITION";

const INDICES_OUT_OF_RANGE: &[Case] = &[
    (|s| s.set("/scene", json!(9)), &["default scene", "scene 9 does not exist"]),
    (|s| s.set("/scenes/0/nodes", json!([9])), &["scene 0", "node 9 does not exist"]),
    (|s| s.set("/nodes/0/mesh", json!(9)), &["node 0", "mesh 9 does not exist"]),
    (|s| s.set("/nodes/0/children", json!([9])), &["node 0", "child node 9 does not exist"]),
    (|s| s.set("/nodes/3/camera", json!(9)), &["node 3", "camera 9 does not exist"]),
    (|s| s.set("/nodes/1/skin", json!(9)), &["node 1", "skin 9 does not exist"]),
    (
        |s| s.set("/nodes/3/extensions/KHR_lights_punctual/light", json!(9)),
        &["node 3", "light 9 does not exist"],
    ),
    (|s| s.set("/skins/0/joints", json!([1, 9])), &["skin 0", "node 9 does not exist"]),
    (|s| s.set("/skins/0/skeleton", json!(9)), &["skin 0", "node 9 does not exist"]),
    (
        |s| s.set("/skins/0/inverseBindMatrices", json!(99)),
        &["skin 0", "accessor 99 does not exist"],
    ),
    (|s| s.set(POSITION, json!(99)), &["mesh 0, primitive 0, attribute POSITION", "accessor 99"]),
    (
        |s| s.set("/meshes/0/primitives/0/indices", json!(99)),
        &["mesh 0, primitive 0, indices", "accessor 99 does not exist, there are"],
    ),
    (
        |s| s.set("/meshes/0/primitives/0/material", json!(9)),
        &["mesh 0, primitive 0", "material 9"],
    ),
    (
        |s| s.set("/meshes/1/primitives/0/targets/0/POSITION", json!(99)),
        &["mesh 1, primitive 0, target 0", "accessor 99"],
    ),
    (
        |s| s.set("/accessors/0/bufferView", json!(99)),
        &["accessor 0", "buffer view 99 does not exist"],
    ),
    (|s| s.set("/bufferViews/0/buffer", json!(9)), &["buffer view 0", "buffer 9 does not exist"]),
    (|s| s.set("/textures/0/source", json!(9)), &["texture 0", "image 9 does not exist"]),
    (|s| s.set("/textures/0/sampler", json!(9)), &["texture 0", "sampler 9 does not exist"]),
    (
        |s| s.set("/textures/2/extensions/EXT_texture_webp/source", json!(9)),
        &["texture 2", "image 9 does not exist"],
    ),
    (
        |s| s.set("/textures/2/extensions/EXT_texture_webp/source", json!(-1)),
        &["texture 2", "EXT_texture_webp is not an index"],
    ),
    (|s| s.set("/materials/0/emissiveTexture/index", json!(9)), &["material 0", "texture 9"]),
    (|s| s.set("/materials/0/normalTexture/index", json!(9)), &["material 0", "texture 9"]),
    (
        |s| s.set("/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/TRANSLATION", json!(99)),
        &["node 0, EXT_mesh_gpu_instancing", "\"TRANSLATION\" is not an accessor"],
    ),
    (|s| s.set("/nodes/0/mesh", json!(-1)), &["node 0, mesh", "-1"]),
    (
        |s| s.set("/nodes/0/children", json!([4294967296u64])),
        &["children", "4294967296 is more than any index"],
    ),
    (
        |s| s.set("/meshes/1/primitives/0/targets/0/POSITION", json!(4294967296u64)),
        &["targets", "4294967296 is more than any index"],
    ),
    (
        |s| s.set("/nodes/0/mesh", json!(4294967296u64)),
        &["mesh", "4294967296 is more than any index"],
    ),
];

const SIZES: &[Case] = &[
    (
        |s| s.set("/buffers", json!([{ "byteLength": 1 << 20 }])),
        &["buffer 0", "byteLength is 1048576"],
    ),
    (
        |s| s.set("/buffers", json!([{ "byteLength": u64::MAX }])),
        &["buffer 0", "byteLength is 18446744073709551615"],
    ),
    (|s| s.set("/bufferViews/0/byteLength", json!(1 << 20)), &["buffer view 0", "it ends at byte"]),
    (
        |s| s.set("/bufferViews/0/byteOffset", json!(u64::MAX)),
        &["buffer view 0", "beyond all numbers"],
    ),
    (|s| s.set("/bufferViews/0/byteStride", json!(0)), &["buffer view 0", "byteStride 0"]),
    (|s| s.set("/bufferViews/0/byteStride", json!(u64::MAX)), &["buffer view 0", "byteStride"]),
    (|s| s.set("/bufferViews/0/byteStride", json!(8)), &["accessor 0", "12 bytes overlap"]),
    (|s| s.set("/bufferViews/0/byteStride", json!(252)), &["accessor 0", "it ends at byte 516"]),
    (|s| s.set("/accessors/0/count", json!(0)), &["accessor 0", "no elements"]),
    (|s| s.set("/accessors/0/count", json!(4)), &["accessor 0", "it ends at byte 48"]),
    (|s| s.set("/accessors/0/count", json!(u64::MAX)), &["accessor 0", "beyond all numbers"]),
    (|s| s.set("/accessors/0/count", json!(1u64 << 60)), &["accessor 0", "it ends"]),
    (|s| s.set("/accessors/0/byteOffset", json!(1)), &["accessor 0", "it ends at byte 37"]),
    (|s| s.set("/accessors/0/byteOffset", json!(u64::MAX)), &["accessor 0", "beyond all numbers"]),
    (|s| s.set("/accessors/0/count", json!(-3)), &["accessor 0, count", "-3"]),
    (|s| set_sparse(s, "count", json!(0)), &["accessor", "0 of 3 elements replaced"]),
    (|s| set_sparse(s, "count", json!(4)), &["accessor", "4 of 3 elements replaced"]),
    (|s| set_sparse(s, "count", json!(3)), &["accessor", "sparse indices"]),
    (|s| set_sparse(s, "indices/bufferView", json!(99)), &["accessor", "buffer view 99"]),
    (|s| set_sparse(s, "values/bufferView", json!(99)), &["accessor", "buffer view 99"]),
    (|s| set_sparse(s, "values/byteOffset", json!(u64::MAX)), &["accessor", "beyond all numbers"]),
    (|s| set_sparse(s, "indices/componentType", json!(F32)), &["accessor", "sparse indices"]),
    (|s| set_bytes_of_sparse_index(s, 3), &["accessor", "sparse indices", "element 3 is replaced"]),
    (
        |s| {
            let length = s.binary.len();
            s.set("/buffers", json!([{ "byteLength": length, "uri": "data:;base64,!!!!" }]));
        },
        &["buffer 0", "not base64"],
    ),
];

const TYPES: &[Case] = &[
    (
        |s| s.set("/accessors/0/componentType", json!(1)),
        &["accessor 0", "componentType does not exist"],
    ),
    (|s| s.set("/accessors/0/type", json!("VEC5")), &["accessor 0", "type does not exist"]),
    (|s| s.set("/accessors/0/type", json!(3)), &["accessor 0, type"]),
    (
        |s| s.set(POSITION, json!(1)),
        &["mesh 0, primitive 0, attribute POSITION", "unsigned 16-bit integers"],
    ),
    (
        |s| s.set("/meshes/0/primitives/0/indices", json!(0)),
        &["mesh 0, primitive 0, indices", "vectors of 3 floats"],
    ),
    (
        |s| {
            let bytes = s.numbers(U8, "VEC3", 3, &[0; 9]);
            s.set(POSITION, json!(bytes));
        },
        &[
            "attribute POSITION",
            "vectors of 3 unsigned 8-bit integers without KHR_mesh_quantization",
        ],
    ),
    (
        |s| {
            let weights = s.floats("VEC4", &[0.0; 12]);
            s.set("/meshes/1/primitives/0/attributes/JOINTS_0", json!(weights));
        },
        &["mesh 1, primitive 0, attribute JOINTS_0", "vectors of 4 floats"],
    ),
    (
        |s| s.remove("/meshes/1/primitives/0/attributes/WEIGHTS_0"),
        &["mesh 1, primitive 0, attribute JOINTS_0", "without WEIGHTS_0"],
    ),
    (
        |s| {
            let more = s.floats("VEC3", &[0.0; 12]);
            s.set("/meshes/0/primitives/0/attributes/NORMAL", json!(more));
        },
        &["attribute NORMAL", "it has 4 elements"],
    ),
    (
        |s| {
            let more = s.floats("VEC3", &[0.0; 12]);
            s.set("/meshes/1/primitives/0/targets/0/NORMAL", json!(more));
        },
        &["mesh 1, primitive 0, target 0", "it has 4 elements"],
    ),
    (
        |s| s.set("/meshes/1/weights", json!([1.0, 2.0])),
        &["mesh 1", "2 weights for 1 morph target"],
    ),
    (|s| s.set("/nodes/1/weights", json!([1.0, 2.0])), &["node 1", "2 weights for 1 morph target"]),
    (
        |s| s.set("/meshes/1/primitives/1", json!({ "attributes": { "POSITION": 0 } })),
        &["mesh 1, primitive 1", "0 morph targets", "before it have 1"],
    ),
    (
        |s| s.set("/meshes/0/primitives/0/mode", json!(7)),
        &["mesh 0, primitive 0", "mode does not exist"],
    ),
    (
        |s| s.set("/meshes/0/primitives", json!({})),
        &["mesh 0, primitives", "it must be a list, and is an object"],
    ),
    (|s| s.remove("/meshes/0/primitives"), &["mesh 0", "it has no primitives"]),
    (|s| s.set("/skins/0/joints", json!([])), &["skin 0", "no joints"]),
    (|s| s.set("/skins/0/inverseBindMatrices", json!(0)), &["skin 0", "vectors of 3 floats"]),
    (
        |s| s.set("/skins/0/joints", json!([1, 2, 0])),
        &["skin 0", "3 joints, but 2 inverse bind matrices"],
    ),
    (
        |s| {
            s.set("/skins/0/joints", json!([1]));
        },
        &["node 1", "mesh 1 hangs on joint 1, but skin 0 has 1 joint"],
    ),
    (
        |s| s.set("/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/SCALE", json!(0)),
        &["node 0, EXT_mesh_gpu_instancing", "different numbers of elements"],
    ),
    (
        |s| s.set("/nodes/0/extensions/EXT_mesh_gpu_instancing", json!({})),
        &["node 0, EXT_mesh_gpu_instancing", "no attributes"],
    ),
    (|s| s.set("/cameras/0/type", json!("fisheye")), &["camera 0", "type does not exist"]),
    (|s| s.set("/cameras/0/type", json!("orthographic")), &["camera 0", "no values for its type"]),
    (
        |s| s.set("/extensions/KHR_lights_punctual/lights/0/type", json!("area")),
        &["light 0", "type does not exist"],
    ),
    (|s| s.remove("/extensions/KHR_lights_punctual/lights/0/spot"), &["light 0", "without a cone"]),
    (
        |s| s.set("/materials/0/alphaMode", json!("GLASS")),
        &["material 0", "alphaMode does not exist"],
    ),
    (|s| s.set("/samplers/0/wrapS", json!(1)), &["sampler 0", "does not exist"]),
    (|s| s.set("/bufferViews/0/target", json!(1)), &["buffer view 0", "target does not exist"]),
    (|s| s.set("/nodes/0/matrix", json!([1.0])), &["node 0, matrix"]),
    (|s| s.set("/nodes/2/translation", json!([1e39, 0, 0])), &["node 2", "translation is beyond"]),
    (|s| s.set("/asset/version", json!("1.0")), &["asset", "needs glTF \"1.0\""]),
    (|s| s.set("/asset/minVersion", json!("2.5")), &["asset", "needs glTF \"2.5\""]),
    (|s| s.remove("/asset"), &["JSON", "it has no asset"]),
    (
        |s| {
            s.set(
                "/extensionsRequired",
                json!(["KHR_lights_punctual", "KHR_draco_mesh_compression"]),
            )
        },
        &["extensionsRequired", "without \"KHR_draco_mesh_compression\", which is not supported"],
    ),
    (
        |s| s.set("/extensionsRequired", json!(["KHR_texture_basisu"])),
        &["extensionsRequired", "\"KHR_texture_basisu\""],
    ),
];

const VALUES: &[Case] = &[
    (
        |s| set_index(s, 3),
        &["mesh 0, primitive 0, indices", "vertex 3 does not exist, there are 3"],
    ),
    (|s| set_index(s, 65535), &["mesh 0, primitive 0, indices", "vertex 65535 does not exist"]),
    (
        |s| {
            let indices =
                s.numbers(U32, "SCALAR", 3, &[0, 0, 0, 0, 1, 0, 0, 0, 255, 255, 255, 255]);
            s.set("/meshes/0/primitives/0/indices", json!(indices));
        },
        &["mesh 0, primitive 0, indices", "vertex 4294967295"],
    ),
    (
        |s| {
            let joints = s.numbers(U16, "VEC4", 3, &[9; 24]);
            s.set("/meshes/1/primitives/0/attributes/JOINTS_0", json!(joints));
        },
        &["node 1", "joint 2313"],
    ),
];

const NODES: &[Case] = &[
    (|s| s.set("/nodes/2/children", json!([2])), &["node 2", "child of node"]),
    (|s| s.set("/nodes/0/children", json!([0])), &["node 0", "its own ancestor"]),
    (|s| s.set("/nodes/2/children", json!([1])), &["its own ancestor"]),
    (
        |s| s.set("/nodes/0/children", json!([2])),
        &["node 1, children", "node 2 is a child of node 0 already"],
    ),
    (
        |s| s.set("/nodes/0/children", json!([3, 3])),
        &["node 0, children", "node 3 is a child of node 0"],
    ),
    (|s| s.set("/scenes/0/nodes", json!([0, 0])), &["scene 0", "node 0 is in it twice"]),
];

#[test]
fn every_broken_rule_is_named() {
    let lists = [INDICES_OUT_OF_RANGE, SIZES, TYPES, VALUES, NODES];
    for &(change, expected) in lists.into_iter().flatten() {
        let mut scene = everything();
        change(&mut scene);
        let Err(error) = read(scene.glb(), None, &strict()) else {
            panic!("accepted, but should be refused for {expected:?}");
        };
        let said = error.to_string();
        assert!(
            expected.iter().all(|part| said.contains(part)),
            "{said}\nlacks a part of {expected:?}"
        );
        assert!(said.starts_with("scene in memory: "), "{said}");
    }
}

#[test]
fn the_rest_of_a_scene_is_shown_without_its_broken_parts() {
    let mut shown = 0;
    let mut refused = 0;
    for &(change, expected) in
        [INDICES_OUT_OF_RANGE, SIZES, TYPES, VALUES, NODES].into_iter().flatten()
    {
        let mut scene = everything();
        change(&mut scene);
        let go_on = &mut |_| ControlFlow::Continue(());
        let said = match load_bytes(scene.glb(), None, &LoadOptions::default(), go_on) {
            Ok(imported) => {
                gltf_files::loaded::check(&imported);
                assert!(!imported.scene.objects.is_empty(), "{expected:?}");
                shown += 1;
                gltf_files::playback::play(imported.clone());
                imported.notes.iter().map(|note| format!("{note}\n")).collect()
            }
            // Both meshes have the same positions.
            Err(error) => {
                refused += 1;
                error.to_string()
            }
        };
        assert!(
            expected.iter().all(|part| said.contains(part)),
            "{said}\nlacks a part of {expected:?}"
        );
    }
    assert!(shown > 60 && refused < 40, "{shown} are shown, {refused} refused");
}

/// Changes the sparse accessor.
fn set_sparse(scene: &mut GltfFile, key: &str, value: serde_json::Value) {
    let accessors = scene.json["accessors"].as_array().expect("a list");
    let index = accessors
        .iter()
        .position(|accessor| accessor["sparse"].is_object())
        .expect("one is sparse");
    scene.set(&format!("/accessors/{index}/sparse/{key}"), value);
}

fn set_bytes_of_sparse_index(scene: &mut GltfFile, index: u8) {
    let view = scene.view(&[index, 0]);
    set_sparse(scene, "indices/bufferView", json!(view));
}

fn set_index(scene: &mut GltfFile, index: u16) {
    let bytes = [0, 1, index].map(u16::to_le_bytes).concat();
    let indices = scene.numbers(U16, "SCALAR", 3, &bytes);
    scene.set("/meshes/0/primitives/0/indices", json!(indices));
}
