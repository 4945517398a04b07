//! The names of extensions that objects of a file have, even if `extensionsUsed` does not list
//! them.

use std::collections::BTreeSet;
use std::fmt;

use memchr::memmem;
use serde::Deserializer;
use serde::de::{DeserializeSeed, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::value::RawValue;

/// The most names that are kept.
const MOST: usize = 64;

/// The key of the object whose keys are names of extensions, as it stands in the JSON.
const EXTENSIONS: &[u8] = b"\"extensions\"";

/// Returns the names of the extensions of objects outside of `extras`. The JSON has been read
/// before, so its depth is limited.
///
/// Most JSON has few of these objects, so they are searched by their key. This is exact unless the
/// JSON has `extras`, or spells letters as `\u0065`.
pub(super) fn of(json: &[u8]) -> BTreeSet<String> {
    let is_in_json = |text: &[u8]| memmem::find(json, text).is_some();
    if is_in_json(b"\"extras\"") || is_in_json(b"\\u") { walk(json) } else { search(json) }
}

/// Reads all of the JSON.
fn walk(json: &[u8]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let place = Place { names: &mut names, is_extensions: false };
    let _is_there = place.deserialize(&mut serde_json::Deserializer::from_slice(json));
    names
}

/// Reads only the values of the key.
fn search(json: &[u8]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let finder = memmem::Finder::new(EXTENSIONS);
    let mut rest = json;
    while let Some(at) = finder.find(rest) {
        let before = rest.get(..at).unwrap_or_default();
        rest = rest.get(at + EXTENSIONS.len()..).unwrap_or_default();
        // An escaped quote does not begin a key, and a text without a colon is a value.
        let is_key = before.last() != Some(&b'\\');
        let Some(value) = rest.trim_ascii_start().strip_prefix(b":").filter(|_| is_key) else {
            continue;
        };
        let mut values = serde_json::Deserializer::from_slice(value).into_iter::<&RawValue>();
        let Some(Ok(object)) = values.next() else { continue };
        let place = Place { names: &mut names, is_extensions: true };
        let _is_there = place.deserialize(&mut serde_json::Deserializer::from_str(object.get()));
        rest = value.get(values.byte_offset()..).unwrap_or_default();
    }
    names
}

/// A value of the JSON. Reading it returns true unless it is null.
struct Place<'a> {
    names: &'a mut BTreeSet<String>,
    /// True for the object whose keys are names of extensions.
    is_extensions: bool,
}

impl<'de> DeserializeSeed<'de> for Place<'_> {
    type Value = bool;

    fn deserialize<D: Deserializer<'de>>(self, reader: D) -> Result<bool, D::Error> {
        reader.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Place<'_> {
    type Value = bool;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_unit<E: Error>(self) -> Result<bool, E> {
        Ok(false)
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<bool, E> {
        Ok(true)
    }

    fn visit_i64<E: Error>(self, _: i64) -> Result<bool, E> {
        Ok(true)
    }

    fn visit_u64<E: Error>(self, _: u64) -> Result<bool, E> {
        Ok(true)
    }

    fn visit_f64<E: Error>(self, _: f64) -> Result<bool, E> {
        Ok(true)
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<bool, E> {
        Ok(true)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<bool, A::Error> {
        let names = self.names;
        while list.next_element_seed(Place { names, is_extensions: false })?.is_some() {}
        Ok(true)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<bool, A::Error> {
        let Self { names, is_extensions } = self;
        while let Some(key) = map.next_key_seed(Key { is_name: is_extensions })? {
            if matches!(key, KeyKind::Extras) {
                map.next_value::<IgnoredAny>()?;
                continue;
            }
            let is_extensions = matches!(key, KeyKind::Extensions);
            let is_there = map.next_value_seed(Place { names: &mut *names, is_extensions })?;
            if let KeyKind::Name(name) = key
                && is_there
                && names.len() < MOST
            {
                names.insert(name);
            }
        }
        Ok(true)
    }
}

/// The kind of a key.
enum KeyKind {
    /// The key of the object whose keys are names of extensions.
    Extensions,
    /// The key of application data.
    Extras,
    /// The name of an extension.
    Name(String),
    /// Another key.
    Other,
}

struct Key {
    is_name: bool,
}

impl<'de> DeserializeSeed<'de> for Key {
    type Value = KeyKind;

    fn deserialize<D: Deserializer<'de>>(self, reader: D) -> Result<KeyKind, D::Error> {
        reader.deserialize_str(self)
    }
}

impl Visitor<'_> for Key {
    type Value = KeyKind;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a key")
    }

    fn visit_str<E: Error>(self, key: &str) -> Result<KeyKind, E> {
        Ok(match key {
            _ if self.is_name => KeyKind::Name(key.to_owned()),
            "extensions" => KeyKind::Extensions,
            "extras" => KeyKind::Extras,
            _ => KeyKind::Other,
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::{Map, Value, json};

    use super::{of, search, walk};

    #[test]
    fn names_are_found_in_any_object_but_not_in_extras() {
        let json = br#"{
            "extensions": { "A_root": { "extensions": { "B_inner": 1 } }, "N_null": null },
            "nodes": [{ "extensions": { "C_node": {} }, "extras": { "extensions": { "D_own": {} } } }],
            "materials": [{ "pbr": { "texture": { "extensions": { "E_texture": { "n": [1.5, null] } } } } }]
        }"#;
        let names: Vec<String> = of(json).into_iter().collect();
        assert_eq!(names, ["A_root", "B_inner", "C_node", "E_texture"]);
        assert!(of(b"").is_empty() && of(b"[1, {\"extensions\": 5}]").is_empty());
        let escaped = br#"{ "\u0065xtensions": { "A_spelled": 1 } }"#;
        assert!(of(escaped).contains("A_spelled"));
    }

    /// Returns values in which keys and texts look like the searched key.
    fn values() -> impl Strategy<Value = Value> {
        let words = || {
            let words =
                ["extensions", "a", "\"extensions\"", "\\\"extensions", "extensions\\", "B"];
            proptest::sample::select(words.to_vec())
        };
        let leaf = prop_oneof![
            Just(Value::Null),
            any::<bool>().prop_map(Value::from),
            any::<f64>().prop_map(Value::from),
            words().prop_map(Value::from),
        ];
        leaf.prop_recursive(6, 64, 4, move |inner| {
            let entries = prop::collection::vec((words(), inner.clone()), 0..4);
            let object = entries.prop_map(|entries| {
                let entries = entries.into_iter().map(|(key, value)| (key.to_owned(), value));
                Value::Object(Map::from_iter(entries))
            });
            prop_oneof![prop::collection::vec(inner, 0..4).prop_map(Value::Array), object]
        })
    }

    proptest! {
        #[test]
        fn a_search_finds_what_a_walk_finds(value in values()) {
            for text in [value.to_string(), format!("{value:#}").replace(':', " :\n")] {
                prop_assert_eq!(search(text.as_bytes()), walk(text.as_bytes()), "{}", text);
            }
        }
    }

    #[test]
    fn a_search_keeps_as_many_names_as_a_walk() {
        let node = |index: usize| json!({ "extensions": { format!("A_{index}"): {} } });
        let text = json!({ "nodes": (0..100).map(node).collect::<Vec<_>>() }).to_string();
        assert_eq!(search(text.as_bytes()).len(), super::MOST);
        assert_eq!(search(text.as_bytes()), walk(text.as_bytes()));
    }
}
