//! Takes arbitrary bytes from a file to a frame, on lavapipe under the validation layer. An error
//! is fine; a panic, a message or another image without culling is not.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use tests::Driver;
use tests::frame_of_file::FileViewer;

/// One device for all files.
static VIEWER: LazyLock<FileViewer> = LazyLock::new(|| FileViewer::open(Driver::Lavapipe));

fuzz_target!(|bytes: &[u8]| {
    // The same function that `cargo test` runs a bounded number of times.
    let _ = VIEWER.show(bytes);
});
