//! Which image each texture takes: of those it offers, one whose format is known.

use gltf::json::{Material, Root, Texture};
use serde_json::Value;

use crate::error::Reason;
use crate::json;
use crate::notes::Note;
use crate::reach::Kind;
use crate::verdict::Verdict;

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
    json::index(source)
        .map(Some)
        .ok_or_else(|| Reason::malformed(format!("the source of its {WEBP} is no index")))
}

/// Returns the image that is shown for a texture.
pub(crate) fn image_of(texture: &Texture) -> Option<usize> {
    webp_source(texture).ok().flatten().or(plain_source(texture))
}

/// Returns the image of each texture that is shown. Those without one are noted.
pub(crate) fn images_of(root: &Root, verdict: &mut Verdict) -> Vec<Option<usize>> {
    let mut chosen = Vec::with_capacity(root.textures.len());
    for (index, texture) in root.textures.iter().enumerate() {
        let is_used = verdict.is_used(Kind::Texture.at(index));
        let image = image_of(texture).filter(|_| is_used);
        if image.is_none() && is_used {
            verdict.notes.add(|| {
                let reason = format!("it has no image that can be read{}", offered(texture));
                Note::new(format!("texture {index}"), reason)
            });
        }
        chosen.push(image);
    }
    chosen
}

/// Returns the textures that a material shows, some of them perhaps several times.
pub(crate) fn shown(material: &Material) -> impl Iterator<Item = usize> {
    let pbr = &material.pbr_metallic_roughness;
    let slots = [
        pbr.base_color_texture.as_ref().map(|it| it.index),
        pbr.metallic_roughness_texture.as_ref().map(|it| it.index),
        material.normal_texture.as_ref().map(|it| it.index),
        material.occlusion_texture.as_ref().map(|it| it.index),
        material.emissive_texture.as_ref().map(|it| it.index),
    ];
    slots.into_iter().flatten().map(|texture| texture.value())
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
