//! Scenes out of glTF 2.0 files, which are hostile until proven otherwise.
#![forbid(unsafe_code)]

mod imported;
mod levels;

pub use imported::{Camera, Imported, Placed, Placement};
pub use levels::LevelOptions;
