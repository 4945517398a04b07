//! Placeholders for images that cannot be read, and their notes.

use std::collections::{BTreeMap, BTreeSet};

use gltf::json::Root;
use scene::Image;

use crate::element::Kind;
use crate::error::quoted;
use crate::reach::{TextureSlot, texture_slots};
use crate::verdict::Verdict;

/// Returns an image that is clearly not part of the scene: a checkerboard of magenta and black.
pub(super) fn placeholder(index: usize) -> Image {
    const SIDE: u32 = 16;
    let texel = |place: u32| {
        let is_dark = (place % SIDE / 4 + place / SIDE / 4).is_multiple_of(2);
        if is_dark { [0, 0, 0, 255] } else { [255, 0, 255, 255] }
    };
    let rgba8 = (0..SIDE * SIDE).flat_map(texel).collect();
    Image::of_rgba8(format!("image {index} (missing)"), [SIDE; 2], rgba8)
}

/// Returns the slots of shown materials that use each image.
pub(super) fn slots_of_images(
    root: &Root,
    texture_images: &[Option<usize>],
    verdict: &Verdict,
) -> BTreeMap<usize, BTreeSet<TextureSlot>> {
    let mut slots: BTreeMap<usize, BTreeSet<TextureSlot>> = BTreeMap::new();
    let materials = root.materials.iter().enumerate();
    let shown = materials.filter(|(index, _)| verdict.is_used(Kind::Material.at(*index)));
    for (slot, texture) in shown.flat_map(|(_, material)| texture_slots(material)) {
        if let Some(image) = texture_images.get(texture).copied().flatten() {
            slots.entry(image).or_default().insert(slot);
        }
    }
    slots
}

/// Returns the replacement of an image that cannot be read, as a text. It depends on the slots that
/// use the image: in a slot that is not colour, checkers would not be recognisable.
pub(super) fn consequence(root: &Root, index: usize, slots: &BTreeSet<TextureSlot>) -> String {
    let uri = root.images.get(index).and_then(|image| image.uri.as_deref());
    let uri = uri.filter(|uri| !uri.starts_with("data:")).map(quoted);
    let image = format!("image {index}{}", uri.map(|uri| format!(" ({uri})")).unwrap_or_default());
    let numbers = slots.iter().filter(|slot| !slot.is_colour()).map(|slot| slot.name());
    let numbers = numbers.collect::<Vec<_>>().join(" and ");
    match (slots.iter().any(|slot| slot.is_colour()), numbers.is_empty()) {
        (false, false) => format!("{image} counts as a neutral {numbers}"),
        (true, false) => {
            format!(
                "checkers are shown for {image} as colour, and it counts as a neutral {numbers}"
            )
        }
        (_, true) => format!("checkers are shown for {image}"),
    }
}
