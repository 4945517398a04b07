//! Runs `walkthrough`, `compare` and `gpu_page` as users do.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by panicking"
)]

mod bad_input;
#[cfg(feature = "charts")]
mod compare;
#[cfg(feature = "charts")]
mod gpu_page;
mod lights;
#[cfg(unix)]
mod results;
mod scene_files;
#[cfg(unix)]
mod scripts;
#[cfg(target_os = "linux")]
mod terminal;
mod whole_walk;

use std::path::Path;
use std::process::Command;

const WALKTHROUGH: &str = env!("CARGO_BIN_EXE_walkthrough");

/// Returns `walkthrough` in `folder`.
fn walkthrough(folder: &Path, arguments: &[&str]) -> Command {
    harness::program(WALKTHROUGH, folder, arguments)
}
