//! Recording that depends on pipelines, textures and draws.

pub(crate) mod binding;
mod captures;
mod draws;
mod target_contents;
pub(crate) mod textures;
