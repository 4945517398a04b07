//! The renderer, on a host's device or on one of its own: the host gives meshes and objects, or a
//! file, and gets images.

pub mod description;
pub mod device_costs;
pub mod frame;
#[cfg(feature = "import")]
pub(crate) mod loaded_file;
#[cfg(feature = "import")]
pub(crate) mod playback;
pub(crate) mod scene_begin;
pub mod scene_file;
pub mod self_test;
pub mod shadows;
pub mod view;
