//! Textures that fragment shaders sample and that are written piece by piece from a frame's memory.

use ash::vk;

use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::ownership::of_device;
use crate::memory::buffer::BufferSlice;
use crate::memory::image::{Image, ImageFormats};
use crate::memory::sampled_texture::{Contents, SampledTexture};
use crate::record::access::{Access, LayoutChange};
use crate::record::commands::{Commands, Failure};

/// The format of the bytes, whose meaning the shader defines.
const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// An image of four 8-bit channels with a linear sampler that clamps at the edges.
pub struct DynamicTexture {
    device: Device,
    image: Image,
    sampler: vk::Sampler,
    size: [u32; 2],
    // The contents are undefined until the first write has been submitted.
    contents: Contents,
}

of_device!(DynamicTexture: "a texture (`DynamicTexture`)");

impl DynamicTexture {
    /// Creates a texture of `size` pixels.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for a side that is 0 or beyond the device's limit; no memory.
    pub fn new(device: &Device, size: [u32; 2], name: &str) -> Result<Self, Error> {
        let limit = device.adapter().limits.max_image_dimension2_d;
        if let Some(side) = size.into_iter().find(|side| *side == 0 || *side > limit) {
            return Err(Error::TooLarge {
                what: format!("a side of the texture {name}"),
                wanted: side.into(),
                limit: limit.into(),
            });
        }
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let colour = vk::ImageAspectFlags::COLOR;
        let image = Image::new(device, name, size, ImageFormats::same(FORMAT), usage, colour)?;
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(vk::Filter::LINEAR)
            .min_filter(vk::Filter::LINEAR)
            .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE);
        // SAFETY: a plain sampler.
        let sampler = unsafe { device.raw().create_sampler(&info, device.callbacks()) }
            .called("vkCreateSampler")?;
        device.name(sampler, name);
        Ok(Self { device: device.clone(), image, sampler, size, contents: Contents::Undefined })
    }

    /// Returns the size in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Writes an area of `size` pixels at `origin` (from the upper left) with the contents of
    /// `pixels`: four bytes per pixel, rows from the top without gaps. Pixels that were never
    /// written are transparent black. Must be called outside of rendering; later draws of the same
    /// recording see the new pixels. An area outside of the texture, a slice of another size or a
    /// slice of another device makes the recording fail.
    pub fn write(
        &mut self,
        commands: &Commands,
        origin: [u32; 2],
        size: [u32; 2],
        pixels: BufferSlice,
    ) {
        let [width, height] = size;
        let fits = |side: usize| {
            u64::from(origin[side]) + u64::from(size[side]) <= u64::from(self.size[side])
        };
        let bytes = u64::from(width) * u64::from(height) * 4;
        if commands.check_owner(self).is_err() || commands.check_owner(&pixels).is_err() {
            return;
        }
        if bytes == 0 || pixels.size_bytes != bytes || !fits(0) || !fits(1) {
            commands.fail(Failure::Wrong("a texture is written outside of its area"));
            return;
        }
        self.prepare(commands);
        self.change(commands, Access::FragmentSample, Access::CopyWrite);
        let region = vk::BufferImageCopy::default()
            .buffer_offset(pixels.offset_bytes)
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                layer_count: 1,
                ..Default::default()
            })
            .image_offset(vk::Offset3D { x: origin[0] as i32, y: origin[1] as i32, z: 0 })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        // SAFETY: the slice contains the pixels of the area, which lies within the image in the
        // given layout.
        unsafe {
            commands.device().raw().cmd_copy_buffer_to_image(
                commands.raw(),
                pixels.raw,
                self.image.raw,
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &[region],
            );
        }
        self.change(commands, Access::CopyWrite, Access::FragmentSample);
    }

    /// Notes that the last recording was submitted, so that later recordings can use its contents.
    pub fn submitted(&mut self) {
        self.contents = self.contents.submitted();
    }

    /// Returns the texture for shaders.
    pub fn sampled(&self) -> SampledTexture<'_> {
        SampledTexture::new(self.device.id(), self.image.view, self.sampler, self.contents)
    }

    /// Prepares the texture to be sampled, outside of rendering: if nothing was ever written to it,
    /// it becomes transparent black.
    pub fn prepare(&mut self, commands: &Commands) {
        if commands.check_owner(self).is_err() || self.contents.is_known_to(commands) {
            return;
        }
        let colour = vk::ImageAspectFlags::COLOR;
        let uses = [Access::CopyWrite, Access::FragmentSample];
        let fresh = LayoutChange::forgetting(self.image.raw, colour, &uses, Access::CopyWrite);
        commands.change_layouts([fresh]);
        let whole = vk::ImageSubresourceRange {
            aspect_mask: colour,
            level_count: 1,
            layer_count: 1,
            ..Default::default()
        };
        // SAFETY: the image is a transfer destination in the given layout.
        unsafe {
            commands.device().raw().cmd_clear_color_image(
                commands.raw(),
                self.image.raw,
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &vk::ClearColorValue::default(),
                &[whole],
            );
        }
        self.change(commands, Access::CopyWrite, Access::FragmentSample);
        self.contents = Contents::OfRecording(commands.recording());
    }

    fn change(&self, commands: &Commands, from: Access, to: Access) {
        commands.change_layouts([self.image.change(vk::ImageAspectFlags::COLOR, from, to)]);
    }
}

impl Drop for DynamicTexture {
    fn drop(&mut self) {
        self.device.retire(Retired::Sampler(self.sampler));
    }
}
