//! Every field of every struct that functions read: the value 0 has the effect that the header
//! documents. The fields come from the header, so a new field without documentation of 0 fails.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::collections::BTreeMap;

use antumbra_capi::layout::StructLayout;
use antumbra_capi::structs::STRUCTS;

const HEADER: &str = include_str!("../include/antumbra.h");

/// A field as the header declares it.
struct Field {
    name: String,
    /// The type, without the name.
    declared: String,
    doc: String,
}

/// Returns the fields of each struct of the header.
fn fields() -> BTreeMap<String, Vec<Field>> {
    let mut structs = BTreeMap::new();
    let mut lines = HEADER.lines().map(str::trim);
    while let Some(line) = lines.next() {
        let Some(name) =
            line.strip_prefix("typedef struct ").and_then(|rest| rest.strip_suffix(" {"))
        else {
            continue;
        };
        let mut fields = Vec::new();
        let mut doc = Vec::new();
        for line in lines.by_ref().take_while(|line| !line.starts_with('}')) {
            match line.strip_prefix('*').or_else(|| line.strip_prefix("/*")) {
                Some(text) => doc.push(text.trim_matches(['*', '/', ' '])),
                None => {
                    let declared = line.trim_end_matches(';').split('[').next().unwrap();
                    let at =
                        declared.rfind(|letter: char| !letter.is_alphanumeric() && letter != '_');
                    let (declared, name) = declared.split_at(at.unwrap() + 1);
                    let name = name.to_owned();
                    let declared = declared.trim().to_owned();
                    fields.push(Field { name, declared, doc: doc.join(" ").trim().to_owned() });
                    doc.clear();
                }
            }
        }
        structs.insert(name.to_owned(), fields);
    }
    structs
}

/// Returns the number that a constant of the header or of Vulkan stands for.
fn constant(name: &str) -> u64 {
    match name {
        "null" | "VK_NULL_HANDLE" | "VK_FORMAT_UNDEFINED" => return 0,
        "VK_SAMPLE_COUNT_1_BIT" => return 1,
        "VK_API_VERSION_1_3" => return 1 << 22 | 3 << 12,
        _ => {}
    }
    let define = format!("#define {name} ");
    let value = HEADER.lines().find_map(|line| line.strip_prefix(&define));
    value.and_then(|value| value.parse().ok()).unwrap_or_else(|| panic!("{name} has no value"))
}

/// Returns the bytes of the default that a field's documentation names; `None` if it names none.
fn default(field: &Field, size: usize) -> Option<Vec<u8>> {
    let (_, said) = field.doc.split_once("Default: ")?;
    let said = said.trim_start_matches('`');
    let end = if said.starts_with('(') {
        said.find(')').unwrap() + 1
    } else {
        said.find(['`', ',', '.', ' ']).unwrap()
    };
    let numbers = said[..end].trim_matches(['(', ')']).split(", ");
    let is_float = field.declared == "float";
    let bytes = |number: &str| match number.parse::<u64>() {
        Ok(number) if is_float => (number as f32).to_le_bytes().to_vec(),
        Ok(number) => number.to_le_bytes()[..size.min(8)].to_vec(),
        Err(_) => constant(number).to_le_bytes()[..size.min(8)].to_vec(),
    };
    let mut all: Vec<u8> = numbers.flat_map(bytes).collect();
    // An array of zeros.
    all.resize(size, 0);
    Some(all)
}

/// Returns true if functions read the struct through a pointer, or from an array.
fn is_read(name: &str) -> bool {
    // A callback of the host reads these.
    let is_callbacks = ["AntumbraBinding", "AntumbraRendering"].contains(&name);
    !is_callbacks && HEADER.contains(&format!("const {name} *"))
}

/// Returns a struct in which every required field has a value, by its bytes.
fn required(layout: &StructLayout, fields: &[Field]) -> Vec<u8> {
    let mut bytes = vec![0; layout.size];
    for (field, place) in fields.iter().zip(layout.fields) {
        if place.name == "struct_size" {
            bytes[..4].copy_from_slice(&(layout.size as u32).to_le_bytes());
        } else if field.doc.contains("Required") {
            bytes[place.offset] = 1;
        }
    }
    // Required images have reserved fields in them.
    let nested = layout.fields.iter().filter(|place| !place.fields.is_empty());
    nested.for_each(|place| bytes[place.offset..place.offset + place.size].fill(0));
    bytes
}

#[test]
fn zero_is_the_default_of_every_field() {
    let mut checked = 0;
    let all = fields();
    let versioned = |layout: &&StructLayout| layout.fields[0].name == "struct_size";
    for layout in STRUCTS.iter().filter(versioned).filter(|layout| is_read(layout.name)) {
        let fields = &all[layout.name];
        let good = required(layout, fields);
        let seen = (layout.read)(&good).unwrap_or_else(|error| panic!("{}: {error}", layout.name));
        for (field, place) in fields.iter().zip(layout.fields) {
            let name = format!("{}::{}: {}", layout.name, field.name, field.doc);
            assert_eq!(field.name, place.name, "{name}");
            let there = &seen[place.offset..place.offset + place.size];
            checked += 1;
            if place.name == "struct_size" {
                assert!(field.doc.contains("Size of this struct in bytes"), "{name}");
            } else if place.name.starts_with("reserved") {
                assert_eq!(field.doc, "Must be 0.", "{name}");
            } else if field.doc.contains("Required") {
                assert!(!field.doc.contains("Default"), "{name}");
                let mut without = good.clone();
                without[place.offset..place.offset + place.size].fill(0);
                // Handles, images and the version are refused later, where they are used.
                let is_refused_later = !place.fields.is_empty() || place.name == "abi_version";
                let refused = (layout.read)(&without).err();
                let names =
                    refused.is_some_and(|error| error.contains(&format!(".{}", place.name)));
                assert!(names || is_refused_later, "{name}");
            } else {
                let default = default(field, place.size);
                assert_eq!(default.as_deref(), Some(there), "{name}: which is the default?");
            }
        }
    }
    assert!(checked > 130, "{checked} fields");
}

#[test]
fn reserved_fields_are_checked_in_every_struct_and_in_arrays() {
    let all = fields();
    let mut checked = 0;
    // The offsets of reserved bytes, including nested structs.
    fn places(fields: &[antumbra_capi::layout::FieldLayout], at: usize, found: &mut Vec<usize>) {
        for field in fields {
            if field.name.starts_with("reserved") {
                found.push(at + field.offset + field.size - 1);
            }
            places(field.fields, at + field.offset, found);
        }
    }
    // An image state is read as a part of an image.
    let is_checked = |layout: &&StructLayout| is_read(layout.name);
    for layout in STRUCTS.iter().filter(is_checked) {
        let good = required(layout, &all[layout.name]);
        let mut found = Vec::new();
        places(layout.fields, 0, &mut found);
        for place in found {
            let mut bad = good.clone();
            bad[place] = 1;
            let refused = (layout.read)(&bad).unwrap_err();
            assert!(refused.contains("reserved") && refused.ends_with("must be 0"), "{refused}");
            checked += 1;
        }
    }
    assert!(checked > 12, "{checked} fields");
}

#[test]
fn enumerations_have_a_zero() {
    // A field that takes one constant of a set has a default in the set.
    for field in fields().values().flatten().filter(|field| field.doc.starts_with("An `ANTUMBRA_"))
    {
        let prefix = field.doc.split('`').nth(1).unwrap().trim_end_matches("..");
        let named = HEADER.lines().filter(|line| line.starts_with(&format!("#define {prefix}")));
        assert!(named.clone().any(|line| line.ends_with(" 0")), "{prefix} has no 0");
    }
}
