//! Indices beyond 32 bits, which `gltf` silently truncates to the lower half.

use serde_json::Value;

use super::names::shown_key;
use crate::error::{Fault, Reason};

/// The keys of glTF whose value is an index, an enumerator or a set: integers of at most 32 bits.
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

/// The keys whose value is a list or an object of indices.
const LISTS: &[&str] = &["attributes", "children", "joints", "nodes", "targets"];

/// The number of digits of the least integer beyond 32 bits.
const WIDE_DIGITS: usize = 10;

/// Returns true if the JSON may contain an integer beyond 32 bits: a row of [`WIDE_DIGITS`] digits
/// that does not follow a decimal point. Any such row has a digit at a multiple of this length.
pub(super) fn may_be_in(json: &[u8]) -> bool {
    let is_digit = |byte: &u8| byte.is_ascii_digit();
    let starts_wide = |at: usize| {
        let before = json.get(..at).unwrap_or_default();
        let first = before.iter().rposition(|byte| !is_digit(byte));
        let digits = before.len() - first.map_or(0, |first| first + 1);
        let is_fraction = first.is_some_and(|first| before.get(first) == Some(&b'.'));
        let after = json.get(at..).unwrap_or_default().iter().take(WIDE_DIGITS);
        !is_fraction && digits + after.take_while(|byte| is_digit(byte)).count() >= WIDE_DIGITS
    };
    let places = (0..json.len()).step_by(WIDE_DIGITS);
    places.into_iter().any(|at| json.get(at).is_some_and(is_digit) && starts_wide(at))
}

/// Fails at the first index beyond 32 bits. The JSON reader has limited the depth.
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

/// Returns a number beyond 32 bits: this value, or one in it, at most `levels` deep (attributes of
/// targets in a list).
fn wide_number(value: &Value, levels: u32) -> Option<u64> {
    match value {
        Value::Number(number) => number.as_u64().filter(|&number| number > u64::from(u32::MAX)),
        Value::Array(values) if levels > 0 => {
            values.iter().find_map(|value| wide_number(value, levels - 1))
        }
        Value::Object(entries) if levels > 0 => {
            // Objects in lists of nodes are nodes, whose numbers have their own keys.
            let is_attributes = entries.values().all(Value::is_number);
            is_attributes
                .then(|| entries.values().find_map(|value| wide_number(value, levels - 1)))
                .flatten()
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::may_be_in;

    #[test]
    fn wide_numbers_are_found_wherever_they_are() {
        for lead in 0..25 {
            let lead = " ".repeat(lead);
            for wide in ["4294967296", "18446744073709551615", "-9999999999", "[1,4294967296]"] {
                assert!(may_be_in(format!("{lead}{wide}").as_bytes()), "{lead}{wide}");
                assert!(may_be_in(format!("{lead}{wide}, 0.5").as_bytes()), "{lead}{wide}");
            }
            for narrow in ["429496729", "0.70710678118654752", "[123456789,987654321]", ""] {
                assert!(!may_be_in(format!("{lead}{narrow}").as_bytes()), "{lead}{narrow}");
            }
        }
    }
}
