//! The options of surfaces on the GPU.

use gpu::{CancellationToken, MipGeneration};

use crate::resources::spare_capacity::SpareCapacity;
use crate::shading::surfaces::texture_storage::TextureStorage;
use crate::shading::transparency::TransparencyOptions;

/// The options of the upload of surfaces.
#[derive(Clone, Debug)]
pub struct SurfaceOptions {
    /// The most samples of textures along grazing surfaces; `None` takes 8, and 1 on a CPU, where
    /// each costs as much as another texture.
    pub anisotropy: Option<f32>,
    /// The maker of the mip maps.
    pub mip_making: MipGeneration,
    /// The way that textures lie on the GPU; `None` takes the device's best.
    pub textures: Option<TextureStorage>,
    /// Room for what comes later.
    pub spare: SpareCapacity,
    /// The request to give the upload up, which is checked between its pieces.
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
            spare: SpareCapacity::default(),
            cancellation: CancellationToken::default(),
            transparency: TransparencyOptions::default(),
        }
    }
}
