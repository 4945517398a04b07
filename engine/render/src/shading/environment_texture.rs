//! The light from all around on the GPU.

use gpu::{Device, SampledTexture, VolumeTexels, VolumeTexture};
use half::f16;
use scene::{Environment, GLOSSY_LEVELS, SkyDisk};

/// The levels of an [`Environment`] behind each other, or one dark texel without one.
pub(crate) struct EnvironmentTexture {
    texture: VolumeTexture,
    is_there: bool,
    disk: Option<SkyDisk>,
}

impl EnvironmentTexture {
    /// Uploads an environment. Waits for the copy: not for frames.
    ///
    /// # Errors
    /// No memory, a failed call.
    pub(crate) fn new(
        device: &Device,
        environment: Option<&Environment>,
    ) -> Result<Self, gpu::Error> {
        let (side, texels) = environment.map_or((1, vec![[0.0; 3]]), Environment::bordered);
        let levels = if environment.is_some() { GLOSSY_LEVELS + 1 } else { 1 };
        let half = |[red, green, blue]: [f32; 3]| {
            [red, green, blue, 1.0].map(|part| f16::from_f32(part).to_bits())
        };
        let texels: Vec<[u16; 4]> = texels.into_iter().map(half).collect();
        let size = [side, side, levels];
        let texture = VolumeTexture::new(device, size, VolumeTexels::Half(&texels), "environment")?;
        let disk = environment.and_then(Environment::disk).copied();
        Ok(Self { texture, is_there: environment.is_some(), disk })
    }

    /// Returns true if there is an environment.
    pub(crate) fn is_there(&self) -> bool {
        self.is_there
    }

    /// Returns the disk in the sky, if there is one.
    pub(crate) fn disk(&self) -> Option<&SkyDisk> {
        self.disk.as_ref()
    }

    /// Returns the texture for shaders.
    pub(crate) fn sampled(&self) -> SampledTexture<'_> {
        self.texture.sampled()
    }
}
