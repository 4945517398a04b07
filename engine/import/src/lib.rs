//! Scenes out of glTF 2.0 files, which are hostile until proven otherwise.
#![forbid(unsafe_code)]

mod blank;
mod buffers;
mod check;
mod convert;
mod elements;
mod error;
mod glb;
mod gltf_scene;
mod images;
mod json;
mod layout;
mod levels;
mod limits;
mod load;
mod memory;
mod meshopt;
mod notes;
mod prune;
mod reach;
mod scene_animator;
mod source;
mod textures;
mod uri;
mod verdict;

pub use error::{Cause, ImportError};
pub use gltf_scene::{Camera, GltfScene, Placed, Placement};
pub use levels::LevelOptions;
pub use limits::Limits;
pub use load::{Listener, LoadOptions, Progress, Stage, load, load_bytes};
pub use notes::Note;
pub use scene_animator::SceneAnimator;
pub use source::{Instancing, SUPPORTED_EXTENSIONS, Source, open, read};
