//! Scenes out of glTF 2.0 files, which are hostile until proven otherwise.
#![forbid(unsafe_code)]

mod buffers;
mod check;
mod convert;
mod elements;
mod error;
mod glb;
mod images;
mod imported;
mod json;
mod layout;
mod limits;
mod load;
mod meshopt;
mod notes;
mod source;
mod textures;
mod uri;

pub use error::{Cause, ImportError};
pub use imported::{Camera, Imported, Placed, Placement};
pub use limits::Limits;
pub use load::{Listener, LoadOptions, Progress, Stage, load, load_bytes};
pub use source::{Instancing, SUPPORTED_EXTENSIONS, Source, open, read};
