//! The light of an environment on the GPU, and its visible backdrop.

use gpu::{
    Buffer, Device, MipGeneration, SampledTexture, TextureArray, TextureArrayInfo, TextureUploads,
    VolumeTexels, VolumeTexture, vk,
};
use half::f16;
use scene::{Backdrop, Environment, GLOSSY_LEVELS, Panorama};

use crate::passes::{SkyIo, SkyRow};

/// The levels of an [`Environment`] in one texture, and its backdrop. Without an environment it is
/// one dark texel.
pub(crate) struct EnvironmentTexture {
    texture: VolumeTexture,
    backdrop: Option<BackdropResources>,
}

/// The backdrop of an environment.
struct BackdropResources {
    sky: Buffer,
    /// The panorama; `None` if the sky is computed.
    panorama: Option<TextureArray>,
}

impl EnvironmentTexture {
    /// Uploads an environment. Waits for the copy: do not use it in frames.
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
        let backdrop =
            environment.map(|around| BackdropResources::new(device, around)).transpose()?;
        Ok(Self { texture, backdrop })
    }

    pub(crate) fn is_there(&self) -> bool {
        self.backdrop.is_some()
    }

    /// Returns the visible backdrop of the environment, if there is one.
    pub(crate) fn sky(&self) -> Option<SkyIo<'_>> {
        let BackdropResources { sky, panorama } = self.backdrop.as_ref()?;
        Some(SkyIo { sky: sky.whole(), panorama: panorama.as_ref() })
    }

    /// Returns the texture for shaders.
    pub(crate) fn sampled(&self) -> SampledTexture<'_> {
        self.texture.sampled()
    }
}

impl BackdropResources {
    fn new(device: &Device, environment: &Environment) -> Result<Self, gpu::Error> {
        let row = SkyRow::of(environment);
        let sky = device.upload("sky", &[row], vk::BufferUsageFlags::STORAGE_BUFFER)?;
        let panorama = match environment.backdrop() {
            Backdrop::Sky(_) => None,
            Backdrop::Panorama(panorama) => Some(upload_panorama(device, panorama)?),
        };
        Ok(Self { sky, panorama })
    }
}

/// Uploads the levels of a panorama, beginning with the first that fits into an image of the
/// device.
fn upload_panorama(device: &Device, panorama: &Panorama) -> Result<TextureArray, gpu::Error> {
    let most = device.adapter().limits.max_image_dimension2_d;
    let mut size = panorama.size();
    let mut levels = panorama.levels();
    while let [_, smaller @ ..] = levels
        && size.into_iter().any(|side| side > most)
    {
        size = size.map(|side| (side / 2).max(1));
        levels = smaller;
    }
    let info = TextureArrayInfo {
        name: "panorama",
        size,
        layers: 1,
        format: vk::Format::E5B9G9R9_UFLOAT_PACK32,
        wrap: [vk::SamplerAddressMode::REPEAT, vk::SamplerAddressMode::CLAMP_TO_EDGE],
        magnified: vk::Filter::LINEAR,
        minified: vk::Filter::LINEAR,
        between_levels: Some(vk::SamplerMipmapMode::LINEAR),
        anisotropy: 1.0,
        mip_making: MipGeneration::Given(levels.len() as u32),
    };
    let mut array = TextureArray::new(device, &info)?;
    let bytes = |level: &Vec<u32>| bytemuck::cast_slice(level).to_vec();
    let levels: Vec<Vec<u8>> = levels.iter().map(bytes).collect();
    TextureUploads::new(device)?.write_levels(&mut array, 0, &levels)?;
    Ok(array)
}
