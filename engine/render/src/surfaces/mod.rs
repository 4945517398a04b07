//! Surfaces on the GPU: textures in pages, materials, lights, and which lights reach which object.

mod light_lists;
mod lights;
mod materials;
mod pages;
mod relight;
mod resources;

pub use light_lists::{LightLists, MAX_LIGHTS, MAX_LIGHTS_PER_OBJECT};
pub use lights::{MAX_DIRECTIONAL_LIGHTS, reach_m};
pub use materials::MAX_TRANSFORMS;
pub use pages::{MAX_LAYERS, MAX_PAGES, Page, PagePlan};
pub use resources::{SurfaceOptions, SurfaceResources};

#[cfg(test)]
mod light_tests;
#[cfg(test)]
mod page_tests;
