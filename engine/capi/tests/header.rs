//! The committed header matches the declarations in the sources.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

#[test]
fn the_header_is_fresh() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let bindings = cbindgen::generate_with_config(folder, config).unwrap();
    let mut fresh = Vec::new();
    bindings.write(&mut fresh);
    let committed = folder.join("include/antumbra.h");
    if fs::read(&committed).unwrap_or_default() != fresh {
        let made = Path::new(env!("CARGO_TARGET_TMPDIR")).join("antumbra.h");
        fs::write(&made, fresh).unwrap();
        panic!("the header is stale: cp {} {}", made.display(), committed.display());
    }
}

/// Checks that a program can use every name in a comment.
#[test]
fn what_comments_name_is_declared() {
    let header = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/antumbra.h");
    let header = fs::read_to_string(header).unwrap();
    let mut comments = String::new();
    let mut code = String::new();
    for (number, part) in header.split("/*").enumerate() {
        let (comment, rest) = part.split_once("*/").unwrap_or(("", part));
        if number > 0 {
            comments += comment;
        }
        code += rest;
    }
    let words = |text: &str| -> BTreeSet<String> {
        let is_of_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
        let words = text.split(|letter| !is_of_word(letter));
        words.filter(|word| word.starts_with("ANTUMBRA_")).map(str::to_owned).collect()
    };
    let declared = words(&code);
    // A name that ends with an underscore stands for all names that begin so:
    // `ANTUMBRA_SHADOWS_..`.
    let is_declared = |word: &&String| {
        let begins = |other: &String| other.starts_with(word.as_str());
        declared.contains(word.as_str()) || word.ends_with('_') && declared.iter().any(begins)
    };
    let used = words(&comments);
    let missing: Vec<&String> = used.iter().filter(|word| !is_declared(word)).collect();
    assert!(used.len() > 30 && missing.is_empty(), "of {} names: {missing:?}", used.len());
}
