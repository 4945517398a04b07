//! Scenes out of glTF 2.0 files, which are hostile until proven otherwise.
#![forbid(unsafe_code)]

mod error;
mod imported;
mod limits;
mod source;

pub use error::{Cause, ImportError};
pub use imported::{Camera, Imported, Placed, Placement};
pub use limits::Limits;
pub use source::{Instancing, SUPPORTED_EXTENSIONS, Source, open, read};
