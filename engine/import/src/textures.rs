//! Which image each texture takes: of those it offers, one whose format is known.

use gltf::json::{Root, Texture};
use serde_json::Value;

use crate::error::Reason;
use crate::notes::Notes;

const WEBP: &str = "EXT_texture_webp";

/// The image that glTF itself names.
pub(crate) fn plain_source(texture: &Texture) -> Option<usize> {
    // So `gltf` says that there is none.
    const NONE: usize = u32::MAX as usize;
    Some(texture.source.value()).filter(|&source| source != NONE)
}

/// The image that `EXT_texture_webp` names.
pub(crate) fn webp_source(texture: &Texture) -> Result<Option<usize>, Reason> {
    let extension = texture.extensions.as_ref().and_then(|extensions| extensions.others.get(WEBP));
    let Some(source) = extension.and_then(|extension| extension.get("source")) else {
        return Ok(None);
    };
    let index = source.as_u64().and_then(|index| usize::try_from(index).ok());
    index
        .map(Some)
        .ok_or_else(|| Reason::malformed(format!("the source of its {WEBP} is no index")))
}

/// The image of each texture. Those without one are noted.
pub(crate) fn images_of(root: &Root, notes: &mut Notes) -> Vec<Option<usize>> {
    let mut chosen = Vec::with_capacity(root.textures.len());
    for (index, texture) in root.textures.iter().enumerate() {
        let image = webp_source(texture).ok().flatten().or(plain_source(texture));
        if image.is_none() {
            notes.add(|| {
                format!("texture {index} has no image that can be read{}", offered(texture))
            });
        }
        chosen.push(image);
    }
    chosen
}

/// The textures that materials show, some of them several times.
pub(crate) fn shown(root: &Root) -> impl Iterator<Item = usize> {
    root.materials.iter().flat_map(|material| {
        let pbr = &material.pbr_metallic_roughness;
        [
            pbr.base_color_texture.as_ref().map(|it| it.index),
            pbr.metallic_roughness_texture.as_ref().map(|it| it.index),
            material.normal_texture.as_ref().map(|it| it.index),
            material.occlusion_texture.as_ref().map(|it| it.index),
            material.emissive_texture.as_ref().map(|it| it.index),
        ]
        .into_iter()
        .flatten()
        .map(|texture| texture.value())
    })
}

/// By which extensions a texture offers images.
fn offered(texture: &Texture) -> String {
    let others = texture.extensions.iter().flat_map(|extensions| &extensions.others);
    let names: Vec<String> = others
        .filter(|(_, value)| value.get("source").is_some_and(Value::is_u64))
        .map(|(name, _)| crate::error::quoted(name))
        .take(4)
        .collect();
    if names.is_empty() { String::new() } else { format!(": it has one by {}", names.join(", ")) }
}
