//! The colour of objects: surfaces with their materials and lights, transparency, and the order of
//! the draws.

pub(crate) mod depth_first;
pub(crate) mod environment_texture;
pub(crate) mod fragments;
pub(crate) mod scene_degradations;
pub mod surfaces;
pub(crate) mod transparency;
pub(crate) mod transparent;
