//! The names of extensions that objects of a file have, even if `extensionsUsed` does not list
//! them.

use std::collections::BTreeSet;
use std::fmt;

use serde::Deserializer;
use serde::de::{DeserializeSeed, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

/// The most names that are kept.
const MOST: usize = 64;

/// Returns the names of the extensions of objects outside of `extras`. The JSON has been read
/// before, so its depth is limited.
pub(super) fn of(json: &[u8]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let mut reader = serde_json::Deserializer::from_slice(json);
    let place = Place { names: &mut names, is_extensions: false };
    let _is_there = place.deserialize(&mut reader);
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
    use super::of;

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
    }
}
