//! Tests of the scenes of files: the values that are drawn, feature by feature.

#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod assets;
mod geometry;
mod life;
mod loading;
mod materials;
mod nodes;
mod variants;
