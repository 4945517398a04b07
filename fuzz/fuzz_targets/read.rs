//! Reads arbitrary bytes as a scene: an error is fine, a panic is not.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // The same function that `cargo test` runs a bounded number of times.
    let _ = gltf_files::target::try_bytes(bytes);
});
