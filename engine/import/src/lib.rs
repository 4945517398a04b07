//! Scenes out of glTF 2.0 files, which are hostile until proven otherwise.
#![forbid(unsafe_code)]

mod blank;
mod buffers;
mod check;
mod convert;
mod element;
mod elements;
mod error;
mod extensions;
mod glb;
mod gltf_scene;
mod images;
mod json;
mod layout;
mod limits;
mod load;
mod load_options;
mod lods;
mod memory;
mod meshopt;
mod notes;
mod progress;
mod prune;
mod reach;
mod scene_animator;
mod source;
mod textures;
mod uri;
mod verdict;

pub use check::Instancing;
pub use error::{Cause, ImportError};
pub use extensions::SUPPORTED_EXTENSIONS;
pub use gltf_scene::{GltfScene, NodeAttachment, PlacedNode, SceneCamera};
pub use limits::Limits;
pub use load::{load, load_bytes};
pub use load_options::LoadOptions;
pub use lods::LevelOptions;
pub use notes::Note;
pub use progress::{Progress, ProgressFn, Stage};
pub use scene_animator::SceneAnimator;
pub use source::{Source, open, read};
