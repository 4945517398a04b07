//! Lists in the place of objects: a typed reader would take their values for the fields in order.

use serde_json::Value;

use super::names::shown_key;
use crate::error::{Fault, Reason};

/// Returns true if a list may contain a list as an element: outside of extensions, glTF never does.
pub(super) fn may_be_in(json: &[u8]) -> bool {
    // In an object, a list follows a colon.
    memchr::memchr_iter(b'[', json).any(|at| {
        let before = json.get(..at).unwrap_or_default().trim_ascii_end();
        matches!(before.last(), Some(b'[' | b','))
    })
}

/// Fails at the first list that is an element of a list. The JSON reader has limited the depth.
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
