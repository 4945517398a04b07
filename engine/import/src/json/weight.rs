//! Estimates the memory that JSON takes once it is read, before it is read: two characters can
//! become a structure of hundreds of bytes.

use std::fmt;

use gltf::json;
use serde::Deserializer;
use serde::de::{DeserializeSeed, Error, MapAccess, SeqAccess, Visitor};

use crate::Limits;
use crate::error::Reason;

/// The size of a number, boolean, or null in a list.
const SCALAR_BYTES: u64 = size_of::<serde_json::Value>() as u64;
/// The size of an entry of a JSON map, without its key and value.
const ENTRY_BYTES: u64 = 64;
/// The size of any object: the size of the largest structure of `gltf` except materials, of which
/// there are few.
const OBJECT_BYTES: u64 = 512;

const _: () = {
    let largest = OBJECT_BYTES as usize;
    assert!(size_of::<json::Accessor>() <= largest);
    assert!(size_of::<json::Animation>() <= largest);
    assert!(size_of::<json::animation::Channel>() <= largest);
    assert!(size_of::<json::animation::Sampler>() <= largest);
    assert!(size_of::<json::Buffer>() <= largest);
    assert!(size_of::<json::buffer::View>() <= largest);
    assert!(size_of::<json::Camera>() <= largest);
    assert!(size_of::<json::Image>() <= largest);
    assert!(size_of::<json::Material>() <= 2 * largest);
    assert!(size_of::<json::Mesh>() <= largest);
    assert!(size_of::<json::mesh::Primitive>() <= largest);
    assert!(size_of::<json::Node>() <= largest);
    assert!(size_of::<json::Scene>() <= largest);
    assert!(size_of::<json::Skin>() <= largest);
    assert!(size_of::<json::Texture>() <= largest);
    assert!(size_of::<json::texture::Sampler>() <= largest);
};

/// The most memory per byte of JSON: `{}` with a comma is an object, and no value of that length
/// takes more.
const MOST_PER_BYTE: u64 = OBJECT_BYTES / 2;

/// Fails if the JSON is longer than the limits allow, or would take more memory.
///
/// Broken JSON is estimated up to its fault, which the reader reports. Text that is too short to
/// exceed the limit is skipped, since the estimate takes half as long as reading.
pub(super) fn check(json: &[u8], limits: &Limits) -> Result<(), Reason> {
    let length = json.len() as u64;
    if length > limits.json_bytes {
        return Err(Reason::too_large("bytes of JSON", length, limits.json_bytes));
    }
    if length.saturating_mul(MOST_PER_BYTE) <= limits.json_memory_bytes {
        return Ok(());
    }
    let mut weight = Weight { bytes: 0, limit: limits.json_memory_bytes };
    let mut reader = serde_json::Deserializer::from_slice(json);
    let _ = weight.deserialize(&mut reader);
    if weight.is_too_much() {
        return Err(Reason::too_large("bytes of JSON in memory", weight.bytes, weight.limit));
    }
    Ok(())
}

struct Weight {
    bytes: u64,
    limit: u64,
}

impl Weight {
    fn is_too_much(&self) -> bool {
        self.bytes > self.limit
    }

    fn add<E: Error>(&mut self, bytes: u64) -> Result<(), E> {
        self.bytes = self.bytes.saturating_add(bytes);
        if self.is_too_much() { Err(E::custom("too much")) } else { Ok(()) }
    }
}

impl<'de> DeserializeSeed<'de> for &mut Weight {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, reader: D) -> Result<(), D::Error> {
        reader.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for &mut Weight {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.add(SCALAR_BYTES)
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<(), E> {
        self.add(SCALAR_BYTES)
    }

    fn visit_i64<E: Error>(self, _: i64) -> Result<(), E> {
        self.add(SCALAR_BYTES)
    }

    fn visit_u64<E: Error>(self, _: u64) -> Result<(), E> {
        self.add(SCALAR_BYTES)
    }

    fn visit_f64<E: Error>(self, _: f64) -> Result<(), E> {
        self.add(SCALAR_BYTES)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<(), E> {
        self.add(SCALAR_BYTES + text.len() as u64)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        self.add(SCALAR_BYTES)?;
        while list.next_element_seed(&mut *self)?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        self.add(OBJECT_BYTES)?;
        while map.next_key_seed(&mut *self)?.is_some() {
            self.add(ENTRY_BYTES)?;
            map.next_value_seed(&mut *self)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weight_of(json: &str) -> u64 {
        let mut weight = Weight { bytes: 0, limit: u64::MAX };
        let mut reader = serde_json::Deserializer::from_slice(json.as_bytes());
        weight.deserialize(&mut reader).expect("well-formed");
        weight.bytes
    }

    #[test]
    fn no_json_weighs_more_than_its_length_can() {
        let mut worst: f64 = 0.0;
        for item in ["{}", "[]", "0", "\"\"", "{\"\":{}}", "{\"\":0}", "[{}]", "[[]]", "null"] {
            for count in [1, 2, 1000] {
                let json = format!("[{}]", vec![item; count].join(","));
                worst = worst.max(weight_of(&json) as f64 / json.len() as f64);
            }
        }
        assert!(worst <= MOST_PER_BYTE as f64, "{worst}");
        assert!(weight_of("{}") <= 2 * MOST_PER_BYTE);
    }

    #[test]
    fn what_could_be_too_much_is_weighed_and_what_cannot_be_is_not() {
        let json = format!("[{}]", vec!["{}"; 1000].join(","));
        let weight = weight_of(&json);
        let limits = |bytes| Limits { json_memory_bytes: bytes, ..Limits::default() };
        assert!(check(json.as_bytes(), &limits(weight)).is_ok());
        assert!(check(json.as_bytes(), &limits(weight - 1)).is_err());
        let long = " ".repeat(100);
        assert!(check(long.as_bytes(), &limits(0)).is_ok(), "spaces weigh nothing");
    }
}
