//! The renderer's calls, a file per concern; nothing below imports them.

mod adjust;
mod edges;
mod environment;
mod finish;
mod finished_image;
mod flares;
#[cfg(feature = "loaded")]
pub(crate) mod headless;
mod inspect;
mod lights;
pub(crate) mod lod;
mod materials;
mod meshes;
mod moves;
mod object;
mod poses;
#[cfg(feature = "window")]
mod present;
mod recover;
mod render;
mod section;
mod shadows;
mod snapshot;
mod textures;
mod transparency;
mod untested;
mod update;
mod visible_set;
