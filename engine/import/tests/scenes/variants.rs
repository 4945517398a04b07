//! Tests of the created meshes: shared ones, mirrored ones, backs, and transparent ones.

use serde_json::json;

use super::geometry::{ATTRIBUTES, corners, normals};
use super::loading::load;
use gltf_files::files::GltfFile;

#[test]
fn nodes_share_the_meshes_that_they_have() {
    let mut scene = GltfFile::triangle();
    scene.set("/nodes", json!([{ "mesh": 0 }, { "mesh": 0 }, { "mesh": 1 }, { "mesh": 2 }]));
    scene.set("/scenes/0/nodes", json!([0, 1, 2, 3]));
    let same = scene.json["meshes"][0]["primitives"][0].clone();
    let mut other = same.clone();
    other["material"] = json!(0);
    scene.set("/meshes/1", json!({ "name": "a copy", "primitives": [same, other.clone()] }));
    scene.set("/meshes/2", json!({ "primitives": [other] }));
    scene.set("/materials", json!([{ "name": "red" }]));
    let imported = load(&scene);
    let meshes: Vec<u32> = imported.scene.objects.iter().map(|object| object.mesh.0).collect();
    assert_eq!(meshes, [0, 0, 0, 1, 1]);
    let names: Vec<_> = imported.scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    assert_eq!(names, ["mesh 0", "a copy, 1"]);
    assert!(imported.scene.objects.iter().all(|object| object.tint == u32::MAX));
}

#[test]
fn mirrored_places_have_a_mesh_of_the_other_winding() {
    let mut scene = GltfFile::triangle();
    scene.set(
        "/nodes",
        json!([
            { "mesh": 0 },
            { "mesh": 0, "scale": [-1, 1, 1] },
            { "mesh": 0, "scale": [-1, -1, 1] },
            { "scale": [1, 1, -2], "children": [4, 5] },
            { "mesh": 0, "scale": [1, -1, 1] },
            { "mesh": 0 },
        ]),
    );
    scene.set("/scenes/0/nodes", json!([0, 1, 2, 3]));
    let imported = load(&scene);
    let meshes: Vec<u32> = imported.scene.objects.iter().map(|object| object.mesh.0).collect();
    assert_eq!(meshes, [0, 1, 0, 0, 1]);
    let a = [0.0, 0.0, 0.0];
    let b = [1.0, 0.0, 0.0];
    let c = [0.0, 1.0, 0.0];
    assert_eq!((corners(&imported, 0), corners(&imported, 1)), (vec![a, b, c], vec![a, c, b]));
    assert_eq!(normals(&imported, 0), normals(&imported, 1));
}

#[test]
fn blended_meshes_are_taken_apart_where_they_do_not_hang_together() {
    let mut scene = GltfFile::triangle();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let positions: Vec<f32> = (0..3)
        .flat_map(|card| corners.map(|[x, y, z]| [x, y, z - 2.0 * card as f32]))
        .flatten()
        .collect();
    let positions = scene.floats("VEC3", &positions);
    scene.set(&format!("{ATTRIBUTES}/POSITION"), json!(positions));
    scene.remove("/meshes/0/primitives/0/indices");
    scene.set("/meshes/0/primitives/0/material", json!(0));
    scene.set("/nodes", json!([{ "mesh": 0 }, { "mesh": 0, "translation": [5, 0, 0] }]));
    scene.set("/scenes/0/nodes", json!([0, 1]));
    for (mode, transparent) in [("BLEND", 6), ("OPAQUE", 0)] {
        scene.set("/materials", json!([{ "alphaMode": mode }]));
        let imported = load(&scene);
        let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
        assert_eq!(surfaces.transparent.len(), transparent, "{mode}");
        assert_eq!(
            imported.scene.meshes.len(),
            if transparent > 0 { 3 } else { 1 },
            "they are shared"
        );
    }
}

#[test]
fn double_sided_materials_have_backs_that_face_the_other_way() {
    let mut scene = GltfFile::triangle();
    scene.set("/materials", json!([{ "doubleSided": true }]));
    scene.set("/meshes/0/primitives/0/material", json!(0));
    let imported = load(&scene);
    let a = [0.0, 0.0, 0.0];
    let b = [1.0, 0.0, 0.0];
    let c = [0.0, 1.0, 0.0];
    assert_eq!(corners(&imported, 0), [a, b, c, a, c, b]);
    assert_eq!(imported.scene.triangles(), 1, "front and back are one");
    assert_eq!(normals(&imported, 0)[2..4], [[0, 0, 32767, 0], [0, 0, -32767, 0]]);
    scene.set("/materials/0/alphaMode", json!("BLEND"));
    let imported = load(&scene);
    assert_eq!(corners(&imported, 0), [a, c, b, a, b, c], "the far side first");
}

#[test]
fn blended_objects_are_apart_from_all_others() {
    let mut scene = GltfFile::triangle();
    scene.set("/materials", json!([{ "alphaMode": "BLEND" }, { "alphaMode": "MASK" }]));
    let primitive =
        |material: u32| json!({ "attributes": { "POSITION": 0 }, "material": material });
    scene.set("/meshes/0/primitives", json!([primitive(0), primitive(1)]));
    scene.set("/nodes/0/translation", json!([1, 2, 3]));
    let imported = load(&scene);
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    assert_eq!((imported.scene.objects.len(), surfaces.transparent.len()), (1, 1));
    let masked = &imported.scene.objects[0];
    let transparent = &surfaces.transparent[0];
    assert_eq!((transparent.mesh.0, masked.mesh.0), (0, 1));
    assert_eq!(masked.transform, transparent.transform);
}

#[test]
fn normal_textures_get_tangents() {
    let mut scene = GltfFile::triangle();
    let uv = scene.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
    scene.set(&format!("{ATTRIBUTES}/TEXCOORD_0"), json!(uv));
    super::geometry::textured(&mut scene, 0);
    scene.set("/materials/0/normalTexture", json!({ "index": 0 }));
    let tangents = |scene: &GltfFile| {
        let imported = load(scene);
        let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
        surfaces.meshes[0].vertices.iter().map(|vertex| vertex.tangent).collect::<Vec<_>>()
    };
    assert_eq!(tangents(&scene), [[32767, 0, 0, 32767]; 3]);
    let turned = json!({ "KHR_texture_transform": { "rotation": std::f32::consts::FRAC_PI_2 } });
    scene.set("/materials/0/normalTexture/extensions", turned);
    scene.set("/extensionsUsed", json!(["KHR_texture_transform"]));
    // u is the old v, which points down.
    assert_eq!(tangents(&scene), [[0, -32767, 0, 32767]; 3]);
}
