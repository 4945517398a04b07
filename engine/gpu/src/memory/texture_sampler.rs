//! Samplers of textures. Textures share them, because some devices support only 4000.

use ash::vk;

use crate::core::capabilities::OptionalFeature;
use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::memory::texture_array::TextureArrayInfo;

/// A sampler, destroyed with the last texture that uses it.
pub(super) struct TextureSampler {
    device: Device,
    pub(super) raw: vk::Sampler,
}

/// The part of a description that affects the sampler.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SamplerKind {
    wrap: [vk::SamplerAddressMode; 2],
    magnified: vk::Filter,
    minified: vk::Filter,
    between_levels: Option<vk::SamplerMipmapMode>,
    anisotropy: f32,
}

impl SamplerKind {
    pub(super) fn of(info: &TextureArrayInfo<'_>) -> Self {
        let TextureArrayInfo { wrap, magnified, minified, between_levels, anisotropy, .. } = *info;
        Self { wrap, magnified, minified, between_levels, anisotropy }
    }
}

impl TextureSampler {
    /// Creates the sampler for textures with this description.
    pub(super) fn new(device: &Device, info: &TextureArrayInfo<'_>) -> Result<Self, Error> {
        let limit = device.adapter().limits.max_sampler_anisotropy;
        let is_linear = [info.magnified, info.minified] == [vk::Filter::LINEAR; 2];
        let has_it = is_linear && device.capabilities().has(OptionalFeature::Anisotropy);
        let anisotropy = if has_it { info.anisotropy.clamp(1.0, limit.max(1.0)) } else { 1.0 };
        let [across, down] = info.wrap;
        let create = vk::SamplerCreateInfo::default()
            .mag_filter(info.magnified)
            .min_filter(info.minified)
            .mipmap_mode(info.between_levels.unwrap_or(vk::SamplerMipmapMode::NEAREST))
            .max_lod(if info.between_levels.is_some() { vk::LOD_CLAMP_NONE } else { 0.25 })
            .address_mode_u(across)
            .address_mode_v(down)
            .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .anisotropy_enable(anisotropy > 1.0)
            .max_anisotropy(anisotropy);
        // SAFETY: anisotropy is only enabled with its feature, and within the limit.
        let raw = unsafe { device.raw().create_sampler(&create, device.callbacks()) }
            .called("vkCreateSampler")?;
        device.name(raw, info.name);
        Ok(Self { device: device.clone(), raw })
    }
}

impl Drop for TextureSampler {
    fn drop(&mut self) {
        self.device.retire(Retired::Sampler(self.raw));
    }
}
