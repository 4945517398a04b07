//! The extensions that a file requires or uses.

use std::collections::BTreeSet;

use gltf::json::Root;

use crate::SUPPORTED_EXTENSIONS;
use crate::error::{Fault, Reason, quoted};
use crate::notes::{Note, Notes};

/// The loss in the rendered image without each extension.
const LACKING: &[(&str, &str)] = &[
    ("AGI_articulations", "articulated parts stay as they are"),
    ("CESIUM_primitive_outline", "outlines are not drawn"),
    ("EXT_lights_ies", "lights shine evenly within their cones"),
    ("EXT_lights_image_based", "the surroundings give even light from above and below"),
    ("EXT_mesh_features", NOTHING),
    ("EXT_mesh_manifold", NOTHING),
    ("EXT_structural_metadata", NOTHING),
    ("EXT_texture_avif", PLAIN_TEXTURES),
    ("FB_geometry_metadata", NOTHING),
    ("KHR_animation_pointer", "only nodes and morph targets move"),
    ("KHR_audio_emitter", "nothing is heard"),
    ("KHR_draco_mesh_compression", "compressed meshes are shown by their plain copies"),
    ("KHR_lights_image_based", "the surroundings give even light from above and below"),
    ("KHR_materials_anisotropy", "highlights of brushed surfaces are round"),
    ("KHR_materials_clearcoat", "clear coats do not shine"),
    ("KHR_materials_diffuse_transmission", "no light shines through thin surfaces"),
    ("KHR_materials_dispersion", "glass does not split light into colours"),
    ("KHR_materials_ior", "all surfaces mirror as with an index of refraction of 1.5"),
    ("KHR_materials_iridescence", "thin films have no colours of their own"),
    (
        "KHR_materials_pbrSpecularGlossiness",
        "materials without metallic-roughness values are white and matt",
    ),
    ("KHR_materials_sheen", "cloth has no sheen"),
    ("KHR_materials_specular", "highlights have their usual strength and colour"),
    ("KHR_materials_transmission", "glass is opaque unless it is also blended"),
    ("KHR_materials_variants", "the materials are the file's default ones"),
    ("KHR_materials_volume", "glass neither bends nor colours the light within it"),
    ("KHR_node_hoverability", NOTHING),
    ("KHR_node_selectability", NOTHING),
    ("KHR_node_visibility", "nodes that are hidden are shown"),
    ("KHR_physics_rigid_bodies", "nothing falls or collides"),
    ("KHR_texture_basisu", PLAIN_TEXTURES),
    ("KHR_xmp", NOTHING),
    ("KHR_xmp_json_ld", NOTHING),
    ("MSFT_lod", "the finest form is always shown"),
    ("MSFT_packing_normalRoughnessMetallic", PLAIN_TEXTURES),
    ("MSFT_packing_occlusionRoughnessMetallic", PLAIN_TEXTURES),
    ("MSFT_texture_dds", PLAIN_TEXTURES),
];

const NOTHING: &str = "the rendered image lacks nothing without it";
const PLAIN_TEXTURES: &str = "textures are shown by their plain copies";

/// The extension whose attributes readers without it would refuse or show wrongly.
pub(super) const QUANTISATION: &str = "KHR_mesh_quantization";

/// Refuses a file that requires unsupported extensions. Notes unsupported extensions that are only
/// used, and extensions of objects that are not listed as used.
pub(crate) fn required(
    root: &Root,
    of_objects: &BTreeSet<String>,
    notes: &mut Notes,
) -> Result<(), Fault> {
    let is_unknown = |name: &&String| !SUPPORTED_EXTENSIONS.contains(&name.as_str());
    let required = root.extensions_required.iter().filter(is_unknown);
    let required = required.map(|name| quoted(name)).take(16).collect::<Vec<_>>().join(", ");
    if !required.is_empty() {
        let reason = format!("it cannot be shown without {required}, which is not supported");
        return Err(Reason::unsupported(reason).of("extensionsRequired"));
    }
    let used: BTreeSet<&String> = root.extensions_used.iter().filter(is_unknown).collect();
    for name in used {
        notes.add(|| Note::new(format!("extension {}", quoted(name)), lacking(name)));
    }
    let is_named = |list: &[String], name: &str| list.iter().any(|named| named == name);
    let is_undeclared = |name: &&String| {
        !is_named(&root.extensions_used, name) && !is_named(&root.extensions_required, name)
    };
    for name in of_objects.iter().filter(is_undeclared) {
        let consequence =
            if is_unknown(&name) { lacking(name) } else { "shown all the same".to_owned() };
        let reason = format!("extensionsUsed must name it, but does not; {consequence}");
        notes.add(|| Note::new(format!("extension {}", quoted(name)), reason));
    }
    if is_named(&root.extensions_used, QUANTISATION)
        && !is_named(&root.extensions_required, QUANTISATION)
    {
        let what =
            "extensionsRequired must name it, but does not: its meshes are shown all the same";
        notes.add(|| Note::new(format!("extension {}", quoted(QUANTISATION)), what));
    }
    Ok(())
}

/// Returns the loss in the rendered image without an extension, for a message.
fn lacking(name: &str) -> String {
    match LACKING.binary_search_by_key(&name, |(known, _)| known) {
        Ok(place) => {
            LACKING.get(place).map_or(String::new(), |(_, text)| format!("ignored: {text}"))
        }
        Err(_) => "unknown, ignored".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_extension_that_is_ignored_says_what_the_image_lacks() {
        assert!(LACKING.is_sorted_by_key(|(name, _)| name), "or it is not found");
        assert_eq!(lacking("KHR_materials_sheen"), "ignored: cloth has no sheen");
        assert_eq!(lacking("AGI_articulations"), "ignored: articulated parts stay as they are");
        assert_eq!(lacking("ACME_sheen"), "unknown, ignored");
        for (name, _) in LACKING {
            assert!(!SUPPORTED_EXTENSIONS.contains(name), "{name}");
        }
    }
}
