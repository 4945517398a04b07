//! The image of each texture: of those it offers, one whose format is known.

use gltf::json::{Root, Texture};
use serde_json::Value;

use crate::element::Kind;
use crate::extensions::image_of;
use crate::notes::Note;
use crate::verdict::Verdict;

/// Returns the image of each texture that is shown. Textures without one are noted.
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

/// Returns the extensions by which a texture offers images, in words.
fn offered(texture: &Texture) -> String {
    let others = texture.extensions.iter().flat_map(|extensions| &extensions.others);
    let names: Vec<String> = others
        .filter(|(_, value)| value.get("source").is_some_and(Value::is_u64))
        .map(|(name, _)| crate::error::quoted(name))
        .take(4)
        .collect();
    if names.is_empty() { String::new() } else { format!(": it has one by {}", names.join(", ")) }
}
