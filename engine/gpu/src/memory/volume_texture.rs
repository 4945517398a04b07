//! Three-dimensional textures: tables for shaders.

use ash::vk;

use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::ownership::of_device;
use crate::memory::buffer::{Buffer, MemoryKind};
use crate::memory::image::Image;
use crate::memory::sampled_texture::{Contents, SampledTexture};
use crate::record::access::{Access, LayoutChange};
use crate::record::commands::Commands;

/// The texels of a [`VolumeTexture`], ordered from left to right, then downwards, then backwards.
#[derive(Debug, Clone, Copy)]
pub enum VolumeTexels<'a> {
    /// Numbers from -1 to 1, sampled without interpolation; the texture repeats in all directions.
    Signed(&'a [[i8; 4]]),
    /// The bits of 16-bit floats, sampled with interpolation; coordinates are clamped to the edges.
    Half(&'a [[u16; 4]]),
}

impl VolumeTexels<'_> {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::Signed(texels) => bytemuck::cast_slice(texels),
            Self::Half(texels) => bytemuck::cast_slice(texels),
        }
    }

    fn count(&self) -> usize {
        match self {
            Self::Signed(texels) => texels.len(),
            Self::Half(texels) => texels.len(),
        }
    }

    fn format(&self) -> vk::Format {
        match self {
            Self::Signed(_) => vk::Format::R8G8B8A8_SNORM,
            Self::Half(_) => vk::Format::R16G16B16A16_SFLOAT,
        }
    }

    fn sampling(&self) -> (vk::Filter, vk::SamplerAddressMode) {
        match self {
            Self::Signed(_) => (vk::Filter::NEAREST, vk::SamplerAddressMode::REPEAT),
            Self::Half(_) => (vk::Filter::LINEAR, vk::SamplerAddressMode::CLAMP_TO_EDGE),
        }
    }
}

/// A texture of three dimensions whose contents never change.
pub struct VolumeTexture {
    device: Device,
    image: Image,
    sampler: vk::Sampler,
}

of_device!(VolumeTexture: "a texture of three dimensions (`VolumeTexture`)");

impl VolumeTexture {
    /// Creates a texture of `size` (width, height, depth) texels. Waits for the copy, so it is for
    /// loading.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for a side that is 0 or beyond the device's limits, or if `texels` has
    /// another number of texels; no memory, a failed call.
    pub fn new(
        device: &Device,
        size: [u32; 3],
        texels: VolumeTexels<'_>,
        name: &str,
    ) -> Result<Self, Error> {
        let limit = device.adapter().limits.max_image_dimension3_d;
        let count = size.iter().map(|side| u64::from(*side)).product::<u64>();
        let side = size.into_iter().find(|side| *side == 0 || *side > limit);
        let wrong = side.map(|side| (u64::from(side), u64::from(limit)));
        let wrong =
            wrong.or((count != texels.count() as u64).then_some((texels.count() as u64, count)));
        if let Some((wanted, limit)) = wrong {
            let what = format!("a side, or the texels, of the texture {name}");
            return Err(Error::TooLarge { what, wanted, limit });
        }
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let image = Image::volume(device, name, size, texels.format(), usage)?;
        let mut made = Self { device: device.clone(), image, sampler: vk::Sampler::null() };
        let (filter, beyond) = texels.sampling();
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(filter)
            .min_filter(filter)
            .address_mode_u(beyond)
            .address_mode_v(beyond)
            .address_mode_w(beyond);
        // SAFETY: a plain sampler.
        made.sampler = unsafe { device.raw().create_sampler(&info, device.callbacks()) }
            .called("vkCreateSampler")?;
        device.name(made.sampler, name);
        let bytes = texels.bytes();
        let usage = vk::BufferUsageFlags::TRANSFER_SRC;
        let mut staging =
            Buffer::new(device, "staging", bytes.len() as u64, usage, MemoryKind::Upload)?;
        if let Some(place) = staging.bytes_mut().get_mut(..bytes.len()) {
            place.copy_from_slice(bytes);
        }
        device.run_once("upload", |commands| made.copy(commands, &staging, size))?;
        Ok(made)
    }

    fn copy(&self, commands: &Commands, staging: &Buffer, size: [u32; 3]) {
        let [width, height, depth] = size;
        let colour = vk::ImageAspectFlags::COLOR;
        let change = |from, to| {
            commands.change_layouts([LayoutChange::new(self.image.raw, colour, from, to)])
        };
        change(Access::Nothing, Access::CopyWrite);
        let region = vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: colour,
                layer_count: 1,
                ..Default::default()
            })
            .image_extent(vk::Extent3D { width, height, depth });
        // SAFETY: the buffer contains all texels of the image, which is in the given layout.
        unsafe {
            self.device.raw().cmd_copy_buffer_to_image(
                commands.raw(),
                staging.whole().raw(),
                self.image.raw,
                Access::CopyWrite.layout(),
                &[region],
            );
        }
        change(Access::CopyWrite, Access::FragmentSample);
    }

    /// Returns the texture for shaders.
    pub fn sampled(&self) -> SampledTexture<'_> {
        let contents = Contents::Defined;
        SampledTexture::new(self.device.id(), self.image.view, self.sampler, contents)
    }
}

impl Drop for VolumeTexture {
    fn drop(&mut self) {
        self.device.retire(Retired::Sampler(self.sampler));
    }
}
