//! Loads scenes from glTF 2.0, STL and OBJ files, which are taken to be hostile.
//!
//! [`load`] reads a file and the files that it refers to, [`load_bytes`] a file in memory.
//! Container, memory demand of the JSON, structure and budget are checked first, before any
//! allocation whose size the file determines ([`Limits`]). Then files are read, buffers
//! decompressed, values checked and images decoded. A file that is broken as a whole or demands too
//! much returns an [`ImportError`]. A fault in a part of a file becomes a note, and the part is
//! left out. On request, a fault in the shown scene is an error, too ([`BrokenParts`]). Notes and
//! errors name the element and the reason. The crate is independent of GPUs.
//!
//! | type | purpose |
//! |---|---|
//! | [`GltfScene`] | the scene to draw, its cameras, clips, names and notes |
//! | [`LoadOptions`], [`Limits`] | the options of loading, and the limits on a file's demands |
//! | [`SceneAnimator`] | the changes of the scene at a time |
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
