//! Scenes out of glTF 2.0, STL and OBJ files, which are hostile until proven otherwise.
//!
//! [`load`] reads a file and what it refers to, [`load_bytes`] a file in memory. Container, weight
//! of the JSON, structure and budget are checked before anything is allocated by what a file says
//! ([`Limits`]); then files, decompression, values and images. What the file as a whole lacks or
//! asks too much of is an [`ImportError`]. A fault of a part of it is a note, and the part is left
//! out; of what is shown it is an error on request ([`BrokenParts`]). Both name the element and the
//! reason. Nothing here knows a GPU.
//!
//! | type | what it is |
//! |---|---|
//! | [`GltfScene`] | the scene to draw, its cameras, clips, names and notes |
//! | [`LoadOptions`], [`Limits`] | what is read, and how much of it at most |
//! | [`SceneAnimator`] | time in, changes of the scene out |
//!
//! ```
//! # use antumbra_import as import;
//! use import::{LoadOptions, load_bytes};
//! use std::ops::ControlFlow;
//!
//! let file = br#"{
//!     "asset": { "version": "2.0" },
//!     "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "name": "hinge" }]
//! }"#;
//! let (options, mut progress) = (LoadOptions::default(), |_| ControlFlow::Continue(()));
//! let loaded = load_bytes(file.to_vec(), None, &options, &mut progress)?;
//! assert!(loaded.scene.objects.is_empty());
//!
//! let error = load_bytes(b"{ \"asset\": ".to_vec(), None, &options, &mut progress).unwrap_err();
//! println!("{error}"); // the file, the element, the reason
//! # Ok::<(), import::ImportError>(())
//! ```
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![forbid(unsafe_code)]

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
mod leave_out;
mod limits;
mod load;
mod load_options;
mod lods;
mod losses;
mod memory;
mod mesh_files;
mod meshopt;
mod notes;
mod placeholder;
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
pub use images::decode_image;
pub use limits::Limits;
pub use load::{load, load_bytes, load_mesh_bytes};
pub use load_options::{BrokenParts, LoadOptions, ScenePlace};
pub use lods::LevelOptions;
pub use mesh_files::MeshFormat;
pub use notes::Note;
pub use progress::{Progress, ProgressFn, Stage};
pub use scene_animator::SceneAnimator;
pub use source::{Source, open, read};
