//! Properties that are null, which some exporters write for absent ones. They are removed before
//! the JSON is interpreted.

use serde_json::Value;
use serde_path_to_error::Segment;

use super::names::object_name;
use crate::notes::Notes;

/// Returns true if a property in the JSON may be null.
pub(super) fn may_be_in(json: &[u8]) -> bool {
    let follows_colon = |at: usize| {
        let before = json.get(..at).unwrap_or_default().trim_ascii_end();
        before.last() == Some(&b':')
    };
    memchr::memmem::find_iter(json, b"null").any(follows_colon)
}

/// Removes all properties that are null, and notes their number. A null in a list is not an absent
/// property, so it stays. Everything in `extras` stays, too. The JSON reader has limited the depth.
pub(super) fn remove(value: &mut Value, notes: &mut Notes) {
    let mut nulls = Nulls::default();
    nulls.remove_from(value);
    nulls.path_of_first.reverse();
    notes.count("it is null, which is read as absent", nulls.count, || {
        object_name(String::new(), nulls.path_of_first.iter())
    });
}

/// The removed properties.
#[derive(Default)]
struct Nulls {
    count: usize,
    /// The path to the first one, from the inside outwards.
    path_of_first: Vec<Segment>,
}

impl Nulls {
    /// Removes the nulls in a value. Returns true if the first null of the file is among them.
    fn remove_from(&mut self, value: &mut Value) -> bool {
        let mut has_first = false;
        match value {
            Value::Object(entries) => entries.retain(|key, value| {
                if key == "extras" {
                    return true;
                }
                let is_null = value.is_null();
                let is_first = if is_null { self.count == 0 } else { self.remove_from(value) };
                self.count += usize::from(is_null);
                if is_first {
                    has_first = true;
                    self.path_of_first.push(Segment::Map { key: key.clone() });
                }
                !is_null
            }),
            Value::Array(values) => {
                for (index, value) in values.iter_mut().enumerate() {
                    if self.remove_from(value) {
                        has_first = true;
                        self.path_of_first.push(Segment::Seq { index });
                    }
                }
            }
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
        }
        has_first
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn nulls_are_found_wherever_a_property_is_one() {
        for (json, is_found) in [
            (r#"{"a": null}"#, true),
            ("{\"a\":\n\t null }", true),
            (r#"{"a":null}"#, true),
            (r#"{"a": [null, 1], "b": "null"}"#, false),
            ("null", false),
            ("", false),
        ] {
            assert_eq!(may_be_in(json.as_bytes()), is_found, "{json}");
        }
    }

    #[test]
    fn nulls_are_removed_but_those_of_lists_and_extras_and_the_first_is_named() {
        let mut value = json!({
            "a": 1,
            "extras": { "kept": null },
            "meshes": [null, { "primitives": [{ "mode": null, "indices": 3, "targets": null }] }],
            "nodes": null,
        });
        let mut notes = Notes::default();
        remove(&mut value, &mut notes);
        let expected = json!({
            "a": 1,
            "extras": { "kept": null },
            "meshes": [null, { "primitives": [{ "indices": 3 }] }],
        });
        assert_eq!(value, expected);
        let texts: Vec<String> = notes.finish().iter().map(ToString::to_string).collect();
        let expected =
            "mesh 1, primitive 0, mode: it is null, which is read as absent (3 times, first here)";
        assert_eq!(texts, [expected]);
    }
}
