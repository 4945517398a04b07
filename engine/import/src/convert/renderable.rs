//! Checks the limits of a renderer while loading, where errors can name the file.

use std::collections::HashSet;

use scene::limits::{MAX_LAYERS, MAX_LIGHTS, MAX_PAGES, MAX_TEXTURE_TRANSFORMS};
use scene::{Encoding, Material, Sampler, Surfaces, TextureUse};

use super::lights::PlacedLight;
use super::nodes::Tree;
use crate::{Cause, ImportError, Limits, Source};

fn too_many(source: &Source, object: String, what: &str, count: usize, limit: u64) -> ImportError {
    let reason = format!("{what}: {count}, more than the limit of {limit}");
    source.error(Cause::TooLarge, object, reason)
}

/// Refuses more lights than a renderer supports.
pub(super) fn check_lights(
    source: &Source,
    tree: &Tree,
    lights: &[PlacedLight],
    limits: &Limits,
) -> Result<(), ImportError> {
    let limit = limits.lights.min(MAX_LIGHTS as u64);
    let Some(light) = lights.get(limit as usize) else { return Ok(()) };
    let object = light.node.map_or_else(|| "lights".to_owned(), |node| tree.name(node));
    Err(too_many(source, object, "lights in the scene", lights.len(), limit))
}

/// Refuses more textures and texture transforms than a renderer supports.
pub(super) fn check_textures(source: &Source, surfaces: &Surfaces) -> Result<(), ImportError> {
    let mut transforms = HashSet::from([glam::Affine2::IDENTITY.to_cols_array().map(f32::to_bits)]);
    let mut textures: HashSet<(u32, Encoding, Sampler)> = HashSet::new();
    for (index, material) in surfaces.materials.iter().enumerate() {
        for used in uses_of(material) {
            transforms.insert(used.transform.to_cols_array().map(f32::to_bits));
            if let Some(texture) = surfaces.textures.get(used.texture.0 as usize) {
                textures.insert((texture.image.0, texture.encoding, texture.sampler));
            }
        }
        let most_transforms = MAX_TEXTURE_TRANSFORMS;
        let most_textures = MAX_PAGES * MAX_LAYERS as usize;
        for (what, count, limit) in [
            ("different texture transforms up to it", transforms.len() - 1, most_transforms),
            ("different textures up to it", textures.len(), most_textures),
        ] {
            if count > limit {
                let object = format!("material {index} of the scene");
                return Err(too_many(source, object, what, count, limit as u64));
            }
        }
    }
    Ok(())
}

fn uses_of(material: &Material) -> impl Iterator<Item = &TextureUse> {
    let uses = [
        &material.base_colour_texture,
        &material.metallic_roughness_texture,
        &material.normal_texture,
        &material.occlusion_texture,
        &material.emission_texture,
    ];
    uses.into_iter().flatten()
}
