//! Small glTF files that are made here, and what must hold whatever is in a file.
//!
//! [`files`] and [`chains`] make them; [`target`] tries any bytes, as the tests and `cargo fuzz`
//! do: what was loaded is [checked](loaded), and [plays](perform).
// A harness fails by panicking.
#![allow(clippy::panic, clippy::expect_used)]
#![forbid(unsafe_code)]

pub mod chains;
pub mod files;
pub mod loaded;
pub mod perform;
pub mod target;
