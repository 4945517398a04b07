//! Indices beyond 32 bits, of which `gltf` keeps the lower half without a word.

use serde_json::Value;

use super::shown_key;
use crate::error::{Fault, Reason};

/// Keys of glTF whose value is an index, a choice or a set: whole numbers of at most 32 bits.
const NARROW: &[&str] = &[
    "buffer",
    "bufferView",
    "camera",
    "componentType",
    "index",
    "indices",
    "input",
    "inverseBindMatrices",
    "light",
    "magFilter",
    "material",
    "mesh",
    "minFilter",
    "mode",
    "node",
    "output",
    "sampler",
    "scene",
    "skeleton",
    "skin",
    "source",
    "target",
    "texCoord",
    "wrapS",
    "wrapT",
];

/// Keys whose value is a list or an object of indices.
const LISTS: &[&str] = &["attributes", "children", "joints", "nodes", "targets"];

/// Fails at the first such number that is wider. Depth was limited by the reader of the JSON.
pub(super) fn check(value: &Value) -> Result<(), Fault> {
    match value {
        Value::Object(entries) => {
            for (key, value) in entries.iter().filter(|(key, _)| *key != "extras") {
                let is_narrow = NARROW.contains(&key.as_str()) || LISTS.contains(&key.as_str());
                if is_narrow && let Some(number) = wide_number(value, 2) {
                    let text = format!("{number} is more than any index or choice can be");
                    return Err(Reason::malformed(text).of(shown_key(key)));
                }
                check(value)?;
            }
            Ok(())
        }
        Value::Array(values) => values.iter().try_for_each(check),
        _ => Ok(()),
    }
}

/// A number beyond 32 bits: this value, or one in it, `levels` deep at most (attributes of targets in a list).
fn wide_number(value: &Value, levels: u32) -> Option<u64> {
    match value {
        Value::Number(number) => number.as_u64().filter(|&number| number > u64::from(u32::MAX)),
        Value::Array(values) if levels > 0 => {
            values.iter().find_map(|value| wide_number(value, levels - 1))
        }
        Value::Object(entries) if levels > 0 => {
            // Objects in lists of nodes are nodes, whose numbers have keys of their own.
            let is_attributes = entries.values().all(Value::is_number);
            is_attributes
                .then(|| entries.values().find_map(|value| wide_number(value, levels - 1)))
                .flatten()
        }
        _ => None,
    }
}
