//! A CAD viewer on the engine: parts can be picked, hidden, moved apart, measured and exported.
//!
//! The state of the viewer is a pure value, a [`document::Document`]. Commands of a [`script`]
//! change it, and a [`viewport::ModelViewport`] shows it on the GPU. A [`session::WorkshopSession`]
//! has both. In a [`window`], the commands come from the user.
#![forbid(unsafe_code)]

pub mod args;
pub mod document;
pub mod explode;
pub mod export;
pub mod file_parts;
mod ghosts;
pub mod hinge;
pub mod hit;
pub mod inputs;
pub mod measure;
pub mod orbit;
pub mod report;
pub mod retessellate;
pub mod run;
pub mod script;
pub mod session;
pub mod viewport;
pub mod window;
