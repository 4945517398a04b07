//! Tests of materials, textures and samplers of files.

use antumbra_import::GltfScene;
use serde_json::{Value, json};

use super::loading::{load, notes};
use gltf_files::files::{GltfFile, encoded};

/// Returns the triangle with a material of this JSON, and textures of three images.
fn with(material: Value) -> GltfFile {
    let mut scene = GltfFile::triangle();
    for format in [image::ImageFormat::Png, image::ImageFormat::Jpeg, image::ImageFormat::WebP] {
        let view = scene.view(&encoded(format));
        let count = scene.json["images"].as_array().map_or(0, Vec::len);
        if count == 0 {
            scene.set("/images", json!([]));
            scene.set("/textures", json!([]));
        }
        let kind = match format {
            image::ImageFormat::Jpeg => "image/jpeg",
            _ => "image/png",
        };
        scene.push("images", json!({ "bufferView": view, "mimeType": kind }));
        scene.push("textures", json!({ "source": count }));
    }
    scene.set("/materials", json!([material]));
    scene.set("/meshes/0/primitives/0/material", json!(0));
    scene
}

fn surfaces(imported: &GltfScene) -> &scene::Surfaces {
    imported.scene.surfaces.as_ref().expect("surfaces")
}

#[test]
fn every_value_of_a_material_is_read() {
    let mut scene = with(json!({
        "name": "brass", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
        "emissiveFactor": [1.0, 0.5, 0.0],
        "emissiveTexture": { "index": 2 },
        "normalTexture": { "index": 1, "scale": -0.5 },
        "occlusionTexture": { "index": 1, "strength": 0.75, "texCoord": 1 },
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.6, "roughnessFactor": 0.7,
            "baseColorTexture": { "index": 0 }, "metallicRoughnessTexture": { "index": 1 },
        },
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 4.0 } },
    }));
    scene.set("/extensionsUsed", json!(["KHR_materials_emissive_strength"]));
    let imported = load(&scene);
    let material = &surfaces(&imported).materials[0];
    assert_eq!(material.name, "brass");
    assert_eq!(material.base_colour, [0.1, 0.2, 0.3, 0.4]);
    assert_eq!((material.metallic, material.roughness), (0.6, 0.7));
    assert_eq!((material.normal_scale, material.occlusion_strength), (-0.5, 0.75));
    assert_eq!(material.emission, [4.0, 2.0, 0.0]);
    assert_eq!(material.alpha, scene::Alpha::Mask { cutoff: 0.25 });
    assert!(material.is_double_sided && !material.is_unlit);
    let occlusion = material.occlusion_texture.expect("a texture");
    let metallic = material.metallic_roughness_texture.expect("a texture");
    assert_eq!((occlusion.uv_set, metallic.uv_set), (1, 0));
    assert_eq!(occlusion.texture, metallic.texture, "one image, read in one way");
    let texture = |used: Option<scene::TextureUse>| {
        let used = used.expect("a texture");
        surfaces(&imported).textures[used.texture.0 as usize].encoding
    };
    assert_eq!(texture(material.base_colour_texture), scene::Encoding::Srgb);
    assert_eq!(texture(material.emission_texture), scene::Encoding::Srgb);
    assert_eq!(texture(material.normal_texture), scene::Encoding::Linear);
    assert_eq!(surfaces(&imported).images.len(), 3);
    assert!(surfaces(&imported).images.iter().all(|image| image.size == [16, 8]));
}

#[test]
fn defaults_are_those_of_the_specification() {
    let imported = load(&GltfFile::triangle());
    let expected = scene::Material { name: "default".to_owned(), ..Default::default() };
    assert_eq!(surfaces(&imported).materials, [expected]);
}

#[test]
fn numbers_out_of_range_are_brought_into_it() {
    let factors = json!({ "baseColorFactor": [2.0, -1.0, 0.5, 9.0], "metallicFactor": -1.0,
        "roughnessFactor": 7.0 });
    let scene = with(json!({ "pbrMetallicRoughness": factors, "emissiveFactor": [-1.0, 1e30, 1.0],
        "alphaMode": "MASK", "alphaCutoff": -3.0 }));
    let imported = load(&scene);
    let material = &surfaces(&imported).materials[0];
    assert_eq!(material.base_colour, [1.0, 0.0, 0.5, 1.0]);
    assert_eq!((material.metallic, material.roughness), (0.0, 1.0));
    assert_eq!(material.emission, [0.0, 65504.0, 1.0]);
    assert_eq!(material.alpha, scene::Alpha::Mask { cutoff: 0.0 });
}

#[test]
fn unlit_materials_are_unlit() {
    let mut scene = with(json!({ "extensions": { "KHR_materials_unlit": {} } }));
    scene.set("/extensionsRequired", json!(["KHR_materials_unlit"]));
    scene.set("/extensionsUsed", json!(["KHR_materials_unlit"]));
    assert!(surfaces(&load(&scene)).materials[0].is_unlit);
}

#[test]
fn one_image_read_in_two_ways_is_two_textures() {
    let scene = with(json!({ "emissiveTexture": { "index": 0 },
        "normalTexture": { "index": 0 }, "occlusionTexture": { "index": 0 } }));
    let imported = load(&scene);
    assert_eq!((surfaces(&imported).images.len(), surfaces(&imported).textures.len()), (1, 2));
}

#[test]
fn samplers_say_how_textures_are_looked_at() {
    use scene::{Filter, Wrap};
    let levels = [
        (9728, Filter::Nearest, None),
        (9729, Filter::Linear, None),
        (9984, Filter::Nearest, Some(Filter::Nearest)),
        (9985, Filter::Linear, Some(Filter::Nearest)),
        (9986, Filter::Nearest, Some(Filter::Linear)),
        (9987, Filter::Linear, Some(Filter::Linear)),
    ];
    for (filter, minified, between_levels) in levels {
        let mut scene = with(json!({ "emissiveTexture": { "index": 0 } }));
        let sampler =
            json!({ "minFilter": filter, "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 });
        scene.set("/samplers", json!([sampler]));
        scene.set("/textures/0/sampler", json!(0));
        let imported = load(&scene);
        let sampler = surfaces(&imported).textures[0].sampler;
        assert_eq!((sampler.minified, sampler.between_levels), (minified, between_levels));
        assert_eq!(
            (sampler.magnified, sampler.wrap),
            (Filter::Nearest, [Wrap::Clamp, Wrap::Mirror])
        );
    }
    let plain = load(&with(json!({ "emissiveTexture": { "index": 0 } })));
    assert_eq!(surfaces(&plain).textures[0].sampler, scene::Sampler::default());
}

#[test]
fn transforms_belong_to_each_use_of_a_texture() {
    let moved = json!({ "KHR_texture_transform": { "offset": [0.5, 0.25], "texCoord": 1 } });
    let mut scene = with(json!({
        "emissiveTexture": { "index": 0, "extensions": moved },
        "occlusionTexture": { "index": 0, "extensions": moved },
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
    }));
    scene.set("/extensionsUsed", json!(["KHR_texture_transform"]));
    let imported = load(&scene);
    let material = &surfaces(&imported).materials[0];
    for used in [material.emission_texture, material.occlusion_texture] {
        let used = used.expect("a texture");
        assert_eq!((used.uv_set, used.transform.translation.to_array()), (1, [0.5, 0.25]));
    }
    let plain = material.base_colour_texture.expect("a texture");
    assert_eq!((plain.uv_set, plain.transform.translation.to_array()), (0, [0.0, 0.0]));
}

#[test]
fn a_third_set_of_coordinates_is_told() {
    let scene = with(json!({
        "emissiveTexture": { "index": 0, "texCoord": 1 },
        "occlusionTexture": { "index": 0, "texCoord": 2 },
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
    }));
    let imported = load(&scene);
    assert!(notes(&imported, "it has a texture by a third set"), "{:?}", imported.notes);
}

#[test]
fn what_nothing_uses_is_not_kept() {
    let mut scene = with(json!({}));
    scene.set("/materials/1", json!({ "emissiveTexture": { "index": 2 } }));
    let imported = load(&scene);
    let surfaces = surfaces(&imported);
    assert_eq!(
        (surfaces.materials.len(), surfaces.textures.len(), surfaces.images.len()),
        (1, 0, 0)
    );
}
