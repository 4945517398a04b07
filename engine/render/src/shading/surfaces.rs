//! Surfaces on the GPU: textures, materials, lights, and the lights that reach each object.

mod bindless_textures;
mod blocks;
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
mod surface_options;
mod texture_slots;
mod texture_storage;
mod texture_transforms;
mod textures;

pub use lights::reach_m;
pub(crate) use lights::{LightTable, is_bright};
pub(crate) use page_groups::SMALL_PAGES_BYTES;
pub use resources::SurfaceResources;
pub use surface_options::SurfaceOptions;
pub(crate) use texture_slots::TexturePlace;
pub use texture_storage::TextureStorage;
pub(crate) use textures::SurfaceTextures;

#[cfg(test)]
mod light_tests;
#[cfg(test)]
mod many_images_tests;
#[cfg(test)]
mod many_lights_tests;
#[cfg(test)]
mod page_tests;
