//! Any bytes are read as a scene: an error is fine, a panic is not.
#![no_main]

use libfuzzer_sys::fuzz_target;

// The same function that `cargo test` runs a bounded number of times.
#[path = "../../engine/import/tests/hostile/target.rs"]
mod target;

fuzz_target!(|bytes: &[u8]| {
    let _ = target::try_bytes(bytes);
});
