//! Scenes out of glTF 2.0 files, which are hostile until proven otherwise.
#![forbid(unsafe_code)]

mod imported;
mod performance;

pub use imported::{Camera, Imported, Placed, Placement};
pub use performance::{BlendedMove, Changes, Deformation, LightMove, ObjectMove, Performance};
