//! Recording of what needs to know pipelines, textures and draws.

mod binding;
mod draws;
