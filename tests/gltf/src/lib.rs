//! Small glTF and KTX2 files that are made here, and the invariants of everything loaded from any
//! file.
//!
//! [`files`], [`chains`] and [`ktx2_files`] make them; [`target`] tries arbitrary bytes, as the
//! tests and `cargo fuzz` do: the loaded scene is [checked](loaded), and [plays](playback).
//! [`mutations`] change valid files.
// A harness fails by panicking.
#![allow(clippy::panic, clippy::expect_used)]
#![forbid(unsafe_code)]

pub mod chains;
pub mod files;
pub mod ktx2_files;
pub mod loaded;
pub mod mutations;
pub mod playback;
pub mod target;
