//! What becomes of a file: the values that are drawn, feature by feature.

#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

#[path = "scenes/assets.rs"]
mod assets;
#[path = "hostile/files.rs"]
mod files;
#[path = "scenes/geometry.rs"]
mod geometry;
#[path = "scenes/life.rs"]
mod life;
#[path = "hostile/loaded.rs"]
mod loaded;
#[path = "scenes/loading.rs"]
mod loading;
#[path = "scenes/materials.rs"]
mod materials;
#[path = "scenes/nodes.rs"]
mod nodes;
#[path = "scenes/variants.rs"]
mod variants;
