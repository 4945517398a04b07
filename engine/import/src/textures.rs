//! The image of each texture: the first offered image with a supported format.

use gltf::json::{Root, Texture};
use serde_json::Value;

use crate::element::Kind;
use crate::extensions::image_of;
use crate::notes::Note;
use crate::verdict::Verdict;

/// Returns the image of each shown texture. Textures without an image are noted.
pub(crate) fn images_of(root: &Root, verdict: &mut Verdict) -> Vec<Option<usize>> {
    let mut chosen = Vec::with_capacity(root.textures.len());
    for (index, texture) in root.textures.iter().enumerate() {
        let is_used = verdict.is_used(Kind::Texture.at(index));
        let image = image_of(texture).filter(|_| is_used);
        if image.is_none() && is_used && !verdict.is_noted(Kind::Texture.at(index)) {
            verdict.notes.add(|| {
                let reason = format!("it has no image that can be read{}", offered(texture));
                Note::new(format!("texture {index}"), reason)
            });
        }
        chosen.push(image);
    }
    chosen
}

/// Returns the names of the extensions that offer images for a texture, for a message.
fn offered(texture: &Texture) -> String {
    let others = texture.extensions.iter().flat_map(|extensions| &extensions.others);
    let names: Vec<String> = others
        .filter(|(_, value)| value.get("source").is_some_and(Value::is_u64))
        .map(|(name, _)| crate::error::quoted(name))
        .take(4)
        .collect();
    if names.is_empty() { String::new() } else { format!(": it has one by {}", names.join(", ")) }
}
