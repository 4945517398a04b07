//! Small, reproducible changes of valid files: the files of `cargo fuzz`, with other bytes and
//! other values in their JSON.

use std::path::Path;

use serde_json::{Value, json};

use crate::files::{GltfFile, everything, glb_of};

/// The generator SplitMix64.
pub struct SplitMix(pub u64);

impl SplitMix {
    /// Returns the next number.
    #[allow(clippy::should_implement_trait, reason = "an endless sequence")]
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut value = self.0;
        value = (value ^ (value >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        value = (value ^ (value >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        value ^ (value >> 31)
    }

    /// Returns the next number below `end`; 0 if that is 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// Returns the seeds of `cargo fuzz`.
pub fn corpus() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/read");
    let mut files: Vec<_> = std::fs::read_dir(&folder)
        .expect("the corpus is in the project")
        .map(|entry| entry.expect("it can be listed").path())
        .collect();
    files.sort();
    let mut seeds: Vec<_> =
        files.iter().map(|file| std::fs::read(file).expect("it can be read")).collect();
    assert!(seeds.len() >= 8, "{} seeds in {}", seeds.len(), folder.display());
    seeds.extend([everything().glb(), everything().gltf(), GltfFile::triangle().glb()]);
    seeds
}

/// Returns a changed file. The change is in its bytes, or separately in its JSON and binary chunk,
/// so that it remains a container.
pub fn mutant(corpus: &[Vec<u8>], random: &mut SplitMix) -> Vec<u8> {
    let mut bytes = corpus[random.below(corpus.len())].clone();
    let changes = 1 + random.below(4);
    let parts = split(&bytes).filter(|_| random.below(4) > 0);
    let Some((mut json, mut binary)) = parts else {
        (0..changes).for_each(|_| change_bytes(&mut bytes, corpus, random));
        return bytes;
    };
    for _ in 0..changes {
        match random.below(5) {
            0 => change_bytes(&mut binary, corpus, random),
            _ => change_tree(&mut json, random),
        }
    }
    glb_of(&[(b"JSON", json.to_string().as_bytes()), (b"BIN\0", &binary)])
}

/// Returns the JSON and the binary chunk of a GLB.
fn split(bytes: &[u8]) -> Option<(Value, Vec<u8>)> {
    let length = bytes.get(12..16)?.first_chunk().map(|&value| u32::from_le_bytes(value))?;
    let (json, binary) = bytes.get(20..)?.split_at_checked(length as usize)?;
    Some((serde_json::from_slice(json).ok()?, binary.get(8..).unwrap_or_default().to_vec()))
}

/// Changes a few bytes.
fn change_bytes(bytes: &mut Vec<u8>, corpus: &[Vec<u8>], random: &mut SplitMix) {
    if bytes.is_empty() {
        return;
    }
    let at = random.below(bytes.len());
    let end = (at + random.below(64)).min(bytes.len());
    match random.below(6) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = random.next() as u8,
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..end)),
        4 => {
            let copy = bytes[at..end].to_vec();
            bytes.splice(at..at, copy);
        }
        _ => {
            let other = &corpus[random.below(corpus.len())];
            let from = random.below(other.len());
            let end = (from + random.below(256)).min(other.len());
            bytes.splice(at..at, other[from..end].iter().copied());
        }
    }
}

/// Changes one value of the JSON to another number or to another value of the JSON, or removes it.
fn change_tree(json: &mut Value, random: &mut SplitMix) {
    let mut pointers = Vec::new();
    collect(json, String::new(), &mut pointers);
    let at = pointers[random.below(pointers.len())].clone();
    let from = &pointers[random.below(pointers.len())];
    let other = json.pointer(from).cloned().unwrap_or_default();
    let Some(place) = json.pointer_mut(&at) else { return };
    match random.below(8) {
        0 => *place = other,
        1 => *place = Value::Null,
        2 => *place = json!([place.take()]),
        3 => match place {
            Value::Array(list) if !list.is_empty() => drop(list.remove(random.below(list.len()))),
            Value::Object(entries) => {
                let key = entries.keys().nth(random.below(entries.len())).cloned();
                key.and_then(|key| entries.remove(&key));
            }
            _ => {}
        },
        4 => {
            if let Value::Array(list) = place {
                list.push(other);
            }
        }
        _ => *place = number(place, random),
    }
}

fn number(old: &Value, random: &mut SplitMix) -> Value {
    const NUMBERS: &[i64] = &[
        0,
        1,
        2,
        3,
        4,
        5,
        7,
        -1,
        255,
        65535,
        5120,
        5121,
        5122,
        5123,
        5125,
        5126,
        1 << 32,
        i64::MAX,
    ];
    match random.below(4) {
        0 => json!(u64::MAX - random.next() % 64),
        1 => old
            .as_i64()
            .map_or(json!(1e39), |old| json!(old.wrapping_add(1 - 2 * (random.next() % 2) as i64))),
        _ => json!(NUMBERS[random.below(NUMBERS.len())]),
    }
}

/// Collects pointers to all values of some JSON.
fn collect(value: &Value, pointer: String, all: &mut Vec<String>) {
    match value {
        Value::Array(list) => {
            list.iter()
                .enumerate()
                .for_each(|(index, value)| collect(value, format!("{pointer}/{index}"), all));
        }
        Value::Object(entries) => {
            entries.iter().for_each(|(key, value)| collect(value, format!("{pointer}/{key}"), all));
        }
        _ => {}
    }
    all.push(pointer);
}
