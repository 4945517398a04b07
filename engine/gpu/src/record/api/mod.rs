//! Recording that depends on pipelines, textures and draws.

mod binding;
mod draws;
pub(crate) mod textures;
