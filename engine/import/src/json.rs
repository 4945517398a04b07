//! Reads the JSON of a file: its memory is estimated first. If `gltf` refuses the JSON, it is read
//! element by element.

mod extension_names;
mod huge;
mod lenient;
mod lists;
mod names;
mod nulls;
mod version;
mod weight;
mod wide;
mod words;

use std::collections::BTreeSet;

use gltf::Semantic;
use gltf::json::Root;
use serde_json::Value;

use crate::Limits;
use crate::error::{Fault, Reason};
use crate::notes::{Note, Notes};
pub(crate) use lenient::Parsed;

/// Reads the JSON of a file. Parts that are left out are noted.
pub(crate) fn parse(json: &[u8], limits: &Limits, notes: &mut Notes) -> Result<Parsed, Fault> {
    // RFC 8259 lets a reader ignore a byte order mark, and chunks of a GLB may be padded.
    let json = json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json);
    let end = json.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    let json = json.get(..end).unwrap_or_default();

    weight::check(json, limits).map_err(|reason| reason.of("JSON"))?;
    let read = serde_json::from_slice(json);
    if read.is_err()
        && let Some(bounded) = huge::bounded(json)
    {
        // The estimate stopped at the first such number.
        return parse(&bounded, limits, notes);
    }
    let mut parsed = match read {
        Ok(root) if !needs_elements(json) => {
            Parsed { root, faults: Vec::new(), extension_names: BTreeSet::new() }
        }
        Err(error) if !error.is_data() => return Err(syntax(&error).of("JSON")),
        read => {
            if read.is_err_and(|error| error.to_string().starts_with("duplicate field")) {
                notes
                    .add(|| Note::new("JSON", "a name occurs twice in an object: the last counts"));
            }
            by_elements(json, notes)?
        }
    };
    parsed.extension_names = extension_names::of(json);
    version::check(&parsed.root.asset, notes)?;
    strip(&mut parsed.root, notes);
    Ok(parsed)
}

/// Returns true if the JSON may contain values that a typed reader would misread.
fn needs_elements(json: &[u8]) -> bool {
    wide::may_be_in(json) || lists::may_be_in(json) || nulls::may_be_in(json)
}

/// Returns the reason why JSON cannot be read, with its line and column.
fn syntax(error: &serde_json::Error) -> Reason {
    let line = error.line();
    let column = error.column();
    if error.is_eof() {
        return Reason::malformed(format!("it ends too early, in line {line}, column {column}"));
    }
    let text = error.to_string();
    let what = text.split(" at line ").next().unwrap_or_default();
    Reason::malformed(format!("it is not JSON in line {line}, column {column}: {what}"))
}

/// Reads JSON again that `gltf` refused or may have read incompletely.
fn by_elements(json: &[u8], notes: &mut Notes) -> Result<Parsed, Fault> {
    let mut value: Value =
        serde_json::from_slice(json).map_err(|error| syntax(&error).of("JSON"))?;
    nulls::remove(&mut value, notes);
    // Files of other versions have another structure.
    if let Some(version) = value.pointer("/asset/version").and_then(Value::as_str) {
        version::refuse_older(version)?;
    }
    let Value::Object(object) = value else {
        return Err(Reason::malformed("it must be an object").of("JSON"));
    };
    lenient::parse(object, notes)
}

/// Removes entries that are valid and have no effect here, but would make `gltf` panic.
fn strip(root: &mut Root, notes: &mut Notes) {
    use gltf::json::validation::Checked;
    for (mesh_index, mesh) in root.meshes.iter_mut().enumerate() {
        for (index, primitive) in mesh.primitives.iter_mut().enumerate() {
            if primitive.attributes.remove(&Checked::Invalid).is_some() {
                notes.count("an attribute of unknown name is ignored", 1, || {
                    format!("mesh {mesh_index}, primitive {index}")
                });
            }
            let is_own =
                |name: &Checked<Semantic>| matches!(name, Checked::Valid(Semantic::Extras(_)));
            primitive.attributes.retain(|name, _| !is_own(name));
        }
    }
    for (index, node) in root.nodes.iter_mut().enumerate() {
        if node.mesh.is_none() && (node.skin.is_some() || node.weights.is_some()) {
            (node.skin, node.weights) = (None, None);
            let what = "it has a skin or weights, but no mesh: they are ignored";
            notes.count(what, 1, || format!("node {index}"));
        }
    }
    for image in &mut root.images {
        if image.buffer_view.is_some() && image.mime_type.is_none() {
            image.mime_type = Some(gltf::json::image::MimeType(String::new()));
        }
    }
}
