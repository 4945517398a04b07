//! The JSON of a file: weighed, read, and where `gltf` is stricter than glTF, brought into the form it reads.

mod weight;
mod wide;

use gltf::json::Root;
use serde_json::Value;
use serde_path_to_error::Segment;

use crate::Limits;
use crate::error::{Fault, Reason, quoted};
use crate::notes::Notes;

/// Reads the JSON of a file. What was left out of it is noted.
pub(crate) fn parse(json: &[u8], limits: &Limits, notes: &mut Notes) -> Result<Root, Fault> {
    // RFC 8259 lets a reader ignore a byte order mark, and chunks of a GLB may be padded.
    let json = json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json);
    let end = json.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    let json = json.get(..end).unwrap_or_default();

    weight::check(json, limits).map_err(|reason| reason.of("JSON"))?;
    if wide::may_be_in(json)
        && let Ok(value) = serde_json::from_slice::<Value>(json)
    {
        wide::check(&value)?;
    }
    let mut root = match serde_json::from_slice(json) {
        Ok(root) => root,
        Err(error) if error.is_data() => repaired(json, notes)?,
        Err(error) => return Err(Reason::malformed(error.to_string()).of("JSON")),
    };
    check_version(&root)?;
    strip(&mut root, notes);
    Ok(root)
}

fn check_version(root: &Root) -> Result<(), Fault> {
    let wanted = root.asset.min_version.as_ref().unwrap_or(&root.asset.version);
    if wanted == "2.0" || (root.asset.min_version.is_none() && wanted.starts_with("2.")) {
        return Ok(());
    }
    let reason = format!("it needs glTF {}, only 2.0 is known", quoted(wanted));
    Err(Reason::unsupported(reason).of("asset"))
}

/// Reads JSON again that `gltf` did not take, without what it is too strict about.
fn repaired(json: &[u8], notes: &mut Notes) -> Result<Root, Fault> {
    let mut value: Value = serde_json::from_slice(json)
        .map_err(|error| Reason::malformed(error.to_string()).of("JSON"))?;
    if let Some(version) = value.pointer("/asset/version").and_then(Value::as_str)
        && version.starts_with("1.")
    {
        let reason = format!("it needs glTF {}, only 2.0 is known", quoted(version));
        return Err(Reason::unsupported(reason).of("asset"));
    }
    name_nodes_of_scenes(&mut value);
    drop_channels_without_node(&mut value, notes);
    serde_path_to_error::deserialize(value).map_err(|error| {
        let object = object_name(error.path());
        Reason::malformed(error.into_inner().to_string()).of(object)
    })
}

fn name_nodes_of_scenes(root: &mut Value) {
    let scenes = root.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes.into_iter().flatten().filter_map(Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
    }
}

/// A target without a node is valid where an extension says what it animates.
fn drop_channels_without_node(root: &mut Value, notes: &mut Notes) {
    let animations = root.get_mut("animations").and_then(Value::as_array_mut);
    for (index, animation) in animations.into_iter().flatten().enumerate() {
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else {
            continue;
        };
        let before = channels.len();
        // Whatever is no object stays, and is refused for that.
        channels.retain(|channel| match channel.get("target").and_then(Value::as_object) {
            Some(target) => target.get("node").is_some_and(|node| !node.is_null()),
            None => true,
        });
        if channels.len() < before {
            let dropped = before - channels.len();
            notes.add(|| {
                format!("animation {index}: {dropped} channels without a node are not played")
            });
        }
    }
}

/// Removes what is allowed but means nothing here, and would make `gltf` panic.
fn strip(root: &mut Root, notes: &mut Notes) {
    use gltf::json::validation::Checked;
    for (mesh_index, mesh) in root.meshes.iter_mut().enumerate() {
        for (index, primitive) in mesh.primitives.iter_mut().enumerate() {
            if primitive.attributes.remove(&Checked::Invalid).is_some() {
                notes.add(|| {
                    format!("mesh {mesh_index}, primitive {index}: an attribute of unknown name")
                });
            }
        }
    }
    for image in &mut root.images {
        if image.buffer_view.is_some() && image.mime_type.is_none() {
            image.mime_type = Some(gltf::json::image::MimeType(String::new()));
        }
    }
}

/// "mesh 3, primitive 0, indices" for `meshes[3].primitives[0].indices`.
fn object_name(path: &serde_path_to_error::Path) -> String {
    let mut name = String::new();
    for segment in path.iter() {
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

fn shown_key(key: &str) -> String {
    let is_plain = key.len() <= 40 && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if is_plain { key.to_owned() } else { quoted(key) }
}

/// Names of lists, and of one of each.
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
