//! The renderer on a host's device: the host gives meshes and objects, and gets images.

pub mod description;
pub mod frame;
pub mod prices;
pub mod shadows;
pub mod trust;
