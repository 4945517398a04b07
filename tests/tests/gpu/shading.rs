//! Shading: surfaces, textures, transparency, edges and sections, exact with every kind of culling.

mod bindless_textures;
mod depth_complexity;
mod edges;
mod environment;
mod flares;
mod formulas;
pub mod golden;
mod hud;
mod msaa;
mod poses;
#[cfg(feature = "shader-compiler")]
mod reload;
mod sections;
pub mod skinning;
mod sorted_fragments;
mod streaming;
mod tessellation;
mod textures;
mod transparent;
mod vertex_surfaces;
