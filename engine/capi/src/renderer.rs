//! The renderer on a host's device: the host gives meshes and objects, and gets images.

pub mod description;
pub mod device_costs;
pub mod frame;
pub mod self_test;
pub mod shadows;
