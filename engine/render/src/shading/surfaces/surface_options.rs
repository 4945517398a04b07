//! The options of surfaces on the GPU.

use gpu::{CancellationToken, MipGeneration};

use crate::resources::spare_capacity::SpareCapacity;
use crate::shading::surfaces::texture_storage::TextureStorage;
use crate::shading::transparency::TransparencyOptions;

/// The options of the upload of surfaces.
#[derive(Clone, Debug)]
pub struct SurfaceOptions {
    /// The highest anisotropy of textures on surfaces seen at a low angle. `None` takes 8, and 1 on
    /// a software driver, on which each sample costs as much as another texture.
    pub anisotropy: Option<f32>,
    /// The way in which mip maps are generated.
    pub mip_making: MipGeneration,
    /// The storage of textures on the GPU; `None` takes the device's best.
    pub textures: Option<TextureStorage>,
    /// The highest number of texels per side of the scene's textures: larger images are halved
    /// until they fit. Does not apply to textures that are added later.
    pub max_texture_side: u32,
    /// Room for things that are added later.
    pub spare: SpareCapacity,
    /// Cancels the upload; checked between its parts.
    pub cancellation: CancellationToken,
    /// The order in which transparent objects are blended.
    pub transparency: TransparencyOptions,
}

impl Default for SurfaceOptions {
    fn default() -> Self {
        Self {
            anisotropy: None,
            mip_making: MipGeneration::Blits,
            textures: None,
            max_texture_side: u32::MAX,
            spare: SpareCapacity::default(),
            cancellation: CancellationToken::default(),
            transparency: TransparencyOptions::default(),
        }
    }
}
