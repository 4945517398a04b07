//! Shadow maps and shadow volumes against rays.

mod pictures;
mod relight;
mod scene_rays;
pub mod shadow_maps;
mod shadow_volumes;
mod volume_shadows;
