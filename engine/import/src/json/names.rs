//! The names of JSON paths in messages.

use serde_path_to_error::Segment;

use crate::error::quoted;

/// Returns the name of a path in an object: "mesh 3, primitive 0, indices" for
/// `primitives[0].indices` in "mesh 3".
pub(super) fn object_name<'a>(mut name: String, path: impl Iterator<Item = &'a Segment>) -> String {
    for segment in path {
        let part = match segment {
            Segment::Map { key } => shown_key(key),
            Segment::Seq { index } => {
                let singular =
                    ONE_OF.iter().find_map(|(many, one)| Some((name.strip_suffix(many)?, one)));
                if let Some((before, one)) = singular {
                    name = format!("{before}{one}");
                }
                name.push_str(&format!(" {index}"));
                continue;
            }
            Segment::Enum { variant } => shown_key(variant),
            Segment::Unknown => continue,
        };
        if !name.is_empty() {
            name.push_str(", ");
        }
        name.push_str(&part);
    }
    if name.is_empty() { "JSON".to_owned() } else { name }
}

/// Returns a key as it is shown in messages.
pub(super) fn shown_key(key: &str) -> String {
    let is_plain = key.len() <= 40 && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if is_plain { key.to_owned() } else { quoted(key) }
}

/// The names of lists, in the plural and in the singular.
const ONE_OF: &[(&str, &str)] = &[
    ("accessors", "accessor"),
    ("animations", "animation"),
    ("bufferViews", "buffer view"),
    ("buffers", "buffer"),
    ("cameras", "camera"),
    ("channels", "channel"),
    ("children", "child"),
    ("images", "image"),
    ("joints", "joint"),
    ("lights", "light"),
    ("materials", "material"),
    ("meshes", "mesh"),
    ("nodes", "node"),
    ("primitives", "primitive"),
    ("samplers", "sampler"),
    ("scenes", "scene"),
    ("skins", "skin"),
    ("targets", "target"),
    ("textures", "texture"),
];
