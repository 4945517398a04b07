//! Tests that valid files are accepted and others are refused: with a reason, in time, and without
//! a panic.

#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod accepted;
mod assets;
mod bombs;
mod compressed;
mod containers;
mod deviations;
mod disk;
mod ktx2_images;
mod left_out;
mod motion;
mod mutations;
mod refused;
mod replaced;
mod tolerated;
mod triangles;
mod unused;

use antumbra_import::{BrokenParts, LoadOptions};

/// Returns options that refuse a file because of a broken part.
fn strict() -> LoadOptions {
    LoadOptions { broken_parts: BrokenParts::Refuse, ..LoadOptions::default() }
}
