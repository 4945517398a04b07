//! Tests of the geometry of files: attributes of all types, topologies, normals, broken values.

use antumbra_import::GltfScene;
use serde_json::json;

use super::loading::{load, notes, refused};
use gltf_files::files::{F32, GltfFile, I16, U8, U16, U32};

pub const ATTRIBUTES: &str = "/meshes/0/primitives/0/attributes";

/// Returns the positions of the corners of a mesh's triangles.
pub fn corners(imported: &GltfScene, mesh: usize) -> Vec<[f32; 3]> {
    let mesh = &imported.scene.meshes[mesh];
    mesh.indices.iter().map(|&index| mesh.vertices[index as usize].position).collect()
}

pub fn normals(imported: &GltfScene, mesh: usize) -> Vec<[i16; 4]> {
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    surfaces.meshes[mesh].vertices.iter().map(|vertex| vertex.normal).collect()
}

const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn indices_of_all_types_and_none_mean_the_same() {
    for (component, bytes) in [
        (U8, vec![0, 1, 2]),
        (U16, vec![0, 0, 1, 0, 2, 0]),
        (U32, vec![0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]),
    ] {
        let mut scene = GltfFile::triangle();
        let indices = scene.numbers(component, "SCALAR", 3, &bytes);
        scene.set("/meshes/0/primitives/0/indices", json!(indices));
        assert_eq!(corners(&load(&scene), 0), CORNERS);
    }
    let mut scene = GltfFile::triangle();
    scene.remove("/meshes/0/primitives/0/indices");
    assert_eq!(corners(&load(&scene), 0), CORNERS);
}

#[test]
fn quantised_numbers_become_what_they_mean() {
    let mut scene = GltfFile::triangle();
    let words =
        |values: &[i16]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>();
    let positions = words(&[-32768, 0, 32767, 0, 16384, 0, 0, 0, 0, -32767, 0, 0]);
    let positions = scene.numbers(I16, "VEC3", 3, &positions);
    scene.set(&format!("/accessors/{positions}/normalized"), json!(true));
    scene.set(&format!("/bufferViews/{positions}/byteStride"), json!(8));
    let uvs = scene.numbers(U16, "VEC2", 3, &words(&[-1, 0, 5, 0, 0, 0]));
    let colours = scene.numbers(U8, "VEC3", 3, &[255, 51, 0, 9, 0, 0, 0, 9, 255, 255, 255]);
    scene.set(&format!("/accessors/{colours}/normalized"), json!(true));
    scene.set(&format!("/bufferViews/{colours}/byteStride"), json!(4));
    scene.set("/extensionsUsed", json!(["KHR_mesh_quantization"]));
    scene.set("/extensionsRequired", json!(["KHR_mesh_quantization"]));
    for (name, accessor) in [("POSITION", positions), ("TEXCOORD_0", uvs), ("COLOR_0", colours)] {
        scene.set(&format!("{ATTRIBUTES}/{name}"), json!(accessor));
    }
    textured(&mut scene, 0);
    let imported = load(&scene);
    let half = 16384.0 / 32767.0;
    assert_eq!(corners(&imported, 0), [[-1.0, 0.0, 1.0], [half, 0.0, 0.0], [0.0, -1.0, 0.0]]);
    let surface = &imported.scene.surfaces.as_ref().expect("surfaces").meshes[0];
    assert_eq!(surface.vertices[0].uv[0], [65535.0, 0.0], "not normalised");
    assert_eq!(surface.vertices[1].uv[0], [5.0, 0.0]);
    assert_eq!(surface.vertices[0].colour, [65535, 13107, 0, 65535]);
    assert_eq!(imported.scene.meshes[0].vertices[2].colour, 0x00FF_FFFF, "of the plain vertex too");
}

/// Gives the triangle a texture by a set of coordinates.
pub fn textured(scene: &mut GltfFile, set: u32) {
    let image = scene.view(&gltf_files::files::encoded(image::ImageFormat::Png));
    scene.set("/images", json!([{ "bufferView": image, "mimeType": "image/png" }]));
    scene.set("/textures", json!([{ "source": 0 }]));
    let texture = json!({ "baseColorTexture": { "index": 0, "texCoord": set } });
    scene.set("/materials", json!([{ "pbrMetallicRoughness": texture }]));
    scene.set("/meshes/0/primitives/0/material", json!(0));
}

#[test]
fn sparse_accessors_replace_what_they_name() {
    let mut scene = GltfFile::triangle();
    let indices = scene.view(&[2]);
    let values = scene.view(&[0.0f32, 5.0, 0.0].map(f32::to_le_bytes).concat());
    let sparse = json!({ "count": 1, "indices": { "bufferView": indices, "componentType": U8 },
        "values": { "bufferView": values } });
    scene.set("/accessors/0/sparse", sparse);
    assert_eq!(corners(&load(&scene), 0), [CORNERS[0], CORNERS[1], [0.0, 5.0, 0.0]]);
}

#[test]
fn the_sets_of_coordinates_that_a_material_uses_find_a_place() {
    let mut scene = GltfFile::triangle();
    let third = scene.floats("VEC2", &[0.0, 0.25, 0.5, 0.75, 1.0, 0.5]);
    let first = scene.floats("VEC2", &[9.0; 6]);
    scene.set(&format!("{ATTRIBUTES}/TEXCOORD_0"), json!(first));
    scene.set(&format!("{ATTRIBUTES}/TEXCOORD_1"), json!(first));
    scene.set(&format!("{ATTRIBUTES}/TEXCOORD_2"), json!(third));
    textured(&mut scene, 2);
    let imported = load(&scene);
    let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
    let used = surfaces.materials[0].base_colour_texture.expect("a texture");
    let uvs = surfaces.meshes[0].vertices.iter().map(|vertex| vertex.uv[usize::from(used.uv_set)]);
    assert_eq!(uvs.collect::<Vec<_>>(), [[0.0, 0.25], [0.5, 0.75], [1.0, 0.5]]);
}

#[test]
fn strips_and_fans_are_triangles_all_of_one_winding() {
    let square = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    for (mode, order) in [(5, [0, 1, 2, 3]), (6, [0, 1, 3, 2])] {
        let mut scene = GltfFile::triangle();
        let positions = scene.floats("VEC3", &square);
        let indices = scene.numbers(U8, "SCALAR", 4, &order);
        scene.set(&format!("{ATTRIBUTES}/POSITION"), json!(positions));
        scene.set("/meshes/0/primitives/0/indices", json!(indices));
        scene.set("/meshes/0/primitives/0/mode", json!(mode));
        let imported = load(&scene);
        assert_eq!(imported.scene.triangles(), 2);
        // By their flat normals, both triangles face +z; triangles in one plane share vertices.
        assert_eq!(normals(&imported, 0), [[0, 0, 32767, 0]; 4]);
    }
}

#[test]
fn points_and_lines_are_sprites_without_light() {
    for (mode, sprites) in [(0, 3), (1, 1), (2, 3), (3, 2)] {
        let mut scene = GltfFile::triangle();
        scene.set("/meshes/0/primitives/0/mode", json!(mode));
        let imported = load(&scene);
        let surfaces = imported.scene.surfaces.as_ref().expect("surfaces");
        assert_eq!(surfaces.sprites[0].count(), sprites, "mode {mode}");
        assert_eq!(imported.scene.triangles(), 2 * sprites as u64);
        assert!(surfaces.materials[0].is_unlit);
        let bounds = imported.bounds();
        assert!(bounds.max.x < 1.01 && bounds.min.z < 0.0 && bounds.min.z > -0.01, "{bounds:?}");
        let normal = scene.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
        scene.set(&format!("{ATTRIBUTES}/NORMAL"), json!(normal));
        let lit = load(&scene);
        assert!(!lit.scene.surfaces.as_ref().expect("surfaces").materials[0].is_unlit);
        let sprites = &lit.scene.surfaces.as_ref().expect("surfaces").sprites[0];
        assert_eq!(sprites.normals, vec![[0.0, 0.0, 1.0]; sprites.ends.len()]);
    }
}

#[test]
fn points_that_are_blended_are_solids_unless_they_are_a_crowd() {
    let cloud = |count: usize| {
        let mut scene = GltfFile::triangle();
        let places: Vec<f32> = (0..count * 3).map(|place| place as f32).collect();
        let places = scene.floats("VEC3", &places);
        let material = json!({ "alphaMode": "BLEND",
            "pbrMetallicRoughness": { "baseColorFactor": [0, 1, 0, 0.5] } });
        scene.set("/materials", json!([material]));
        let primitive = json!({ "attributes": { "POSITION": places }, "mode": 0, "material": 0 });
        scene.set("/meshes/0/primitives", json!([primitive]));
        load(&scene)
    };
    let few = cloud(3);
    let surfaces = few.scene.surfaces.as_ref().expect("surfaces");
    assert_eq!((surfaces.transparent.len(), surfaces.sprites.len()), (3, 0));
    let crowd = cloud(70_000);
    let surfaces = crowd.scene.surfaces.as_ref().expect("surfaces");
    assert_eq!(surfaces.transparent.len(), 0);
    let count: usize = surfaces.sprites.iter().map(scene::Sprites::count).sum();
    assert_eq!(count, 70_000);
    assert_eq!(surfaces.sprites[0].ends[0].colour, 65_280.0, "the material's green");
    assert!(notes(&crowd, "it has too many points or lines to blend"), "{:?}", crowd.notes);
}

#[test]
fn points_in_one_place_are_one_point() {
    let mut scene = GltfFile::triangle();
    let nowhere = json!({ "componentType": F32, "type": "VEC3", "count": 2_000_000 });
    let nowhere = scene.push("accessors", nowhere);
    let primitive = json!({ "attributes": { "POSITION": nowhere }, "mode": 0 });
    scene.set("/meshes/0/primitives", json!([primitive]));
    let imported = load(&scene);
    let sprites = &imported.scene.surfaces.as_ref().expect("surfaces").sprites;
    assert_eq!((sprites.len(), sprites[0].count(), imported.scene.objects.len()), (1, 1, 1));
}

#[test]
fn vertices_that_no_triangle_names_are_dropped_whatever_they_are() {
    let mut scene = GltfFile::triangle();
    let mut places = vec![f32::NAN; 6];
    places.extend(CORNERS.as_flattened());
    let positions = scene.floats("VEC3", &places);
    let indices = scene.numbers(U8, "SCALAR", 3, &[2, 3, 4]);
    scene.set(&format!("{ATTRIBUTES}/POSITION"), json!(positions));
    scene.set("/meshes/0/primitives/0/indices", json!(indices));
    let imported = load(&scene);
    assert_eq!(corners(&imported, 0), CORNERS);
    assert_eq!(imported.scene.meshes[0].vertices.len(), 3);
}

#[test]
fn positions_that_are_no_numbers_are_refused_by_name() {
    for wrong in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut scene = GltfFile::triangle();
        let positions = scene.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, wrong, 0.0]);
        scene.set(&format!("{ATTRIBUTES}/POSITION"), json!(positions));
        scene.set("/meshes/0/name", json!("broken"));
        let said = refused(&scene);
        assert!(said.contains("mesh 0 (\"broken\"), primitive 0"), "{said}");
        assert!(said.contains("the position of vertex 2 is not a finite number"), "{said}");
    }
}

#[test]
fn other_attributes_that_are_no_numbers_are_repaired_and_noted() {
    let mut scene = GltfFile::triangle();
    let inf = f32::INFINITY;
    let normal = scene.floats("VEC3", &[f32::NAN, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 9.0]);
    let uv = scene.floats("VEC2", &[f32::NAN, 0.0, 1e30, -inf, 0.5, -1e30]);
    let colour =
        scene.floats("VEC4", &[0.5, 0.5, 0.5, 0.5, f32::NAN, 0.0, 0.0, 1.0, 7.0, -7.0, 0.0, 0.0]);
    let tangent =
        scene.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, -1.0, inf, 0.0, 0.0, 1.0]);
    for (name, accessor) in
        [("NORMAL", normal), ("TEXCOORD_0", uv), ("COLOR_0", colour), ("TANGENT", tangent)]
    {
        scene.set(&format!("{ATTRIBUTES}/{name}"), json!(accessor));
    }
    textured(&mut scene, 0);
    let imported = load(&scene);
    assert_eq!(normals(&imported, 0), [[0, 0, 32767, 0]; 3]);
    let surface = &imported.scene.surfaces.as_ref().expect("surfaces").meshes[0];
    let uvs: Vec<_> = surface.vertices.iter().map(|vertex| vertex.uv[0]).collect();
    assert_eq!(uvs, [[0.0, 0.0], [0.0, 0.0], [0.5, -1e6]]);
    assert_eq!(surface.vertices[1].colour, [65535; 4]);
    assert_eq!(surface.vertices[2].colour, [65535, 0, 0, 0]);
    assert_eq!(surface.vertices[1].tangent, [32767, 0, 0, -32767]);
    for note in [
        "a normal has no",
        "a tangent has no",
        "a texture coordinate is",
        "a vertex has a colour that",
    ] {
        assert!(notes(&imported, note), "{note}: {:?}", imported.notes);
    }
}

#[test]
fn primitives_without_positions_draw_nothing() {
    let mut scene = GltfFile::triangle();
    let colour = scene.floats("VEC4", &[1.0; 12]);
    scene.set(ATTRIBUTES, json!({ "COLOR_0": colour }));
    let imported = load(&scene);
    assert!(imported.scene.objects.is_empty() && notes(&imported, "it has no positions"));
}
