//! The committed header is what the sources declare.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

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
