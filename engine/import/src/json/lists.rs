//! Lists in the place of objects: a reader of structures takes them for their fields in order.

use serde_json::Value;

use super::names::shown_key;
use crate::error::{Fault, Reason};

/// Returns true if a list may be an element of a list in the JSON: outside of extensions, glTF has
/// no such thing.
pub(super) fn may_be_in(json: &[u8]) -> bool {
    // Within an object a list follows a colon.
    let mut before = 0;
    json.iter().filter(|byte| !byte.is_ascii_whitespace()).any(|&byte| {
        let is_in_list = byte == b'[' && matches!(before, b'[' | b',');
        before = byte;
        is_in_list
    })
}

/// Fails at the first list that is an element of another one. Depth was limited by the reader of
/// the JSON.
pub(super) fn check(value: &Value) -> Result<(), Fault> {
    match value {
        Value::Object(entries) => {
            let is_own = |key: &str| key != "extras" && key != "extensions";
            for (key, value) in entries.iter().filter(|(key, _)| is_own(key)) {
                if value.as_array().is_some_and(|list| list.iter().any(Value::is_array)) {
                    let text = "one of its elements is a list, which none can be";
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_in_lists_are_found_wherever_they_stand() {
        for (json, is_found) in [
            (r#"{"a": [1, 2], "b": []}"#, false),
            (r#"{"a": [ [1]]}"#, true),
            (r#"{"a": [{}, [1]]}"#, true),
            (r#"{"a": [{"b": [1]}, {"b": [2]}]}"#, false),
        ] {
            assert_eq!(may_be_in(json.as_bytes()), is_found, "{json}");
            let value = serde_json::from_str(json).expect("JSON");
            assert_eq!(check(&value).is_err(), is_found, "{json}");
        }
    }
}
