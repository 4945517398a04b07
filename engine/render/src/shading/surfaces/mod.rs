//! Surfaces on the GPU: textures in pages, materials, lights, and the lights that reach each
//! object.

mod checks;
mod light_lists;
mod light_tree;
mod lights;
mod marked;
mod material_slots;
mod materials;
mod page_groups;
mod page_upload;
mod pages;
mod resources;
mod texture_slots;
mod texture_transforms;

pub use lights::reach_m;
pub(crate) use lights::{LightTable, is_bright};
pub use resources::{SurfaceOptions, SurfaceResources};
pub(crate) use texture_slots::TexturePlace;

#[cfg(test)]
mod light_tests;
#[cfg(test)]
mod many_images_tests;
#[cfg(test)]
mod many_lights_tests;
#[cfg(test)]
mod page_tests;
