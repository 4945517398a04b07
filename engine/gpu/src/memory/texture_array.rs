//! Texture arrays: images of one size and one sampler with all their mip maps.

use std::sync::Arc;

use ash::vk;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::ownership::of_device;
use crate::memory::buffer::BufferSlice;
use crate::memory::image::Image;
use crate::memory::resample::resampled;
use crate::memory::texel_blocks::TexelBlocks;
use crate::memory::texture_sampler::TextureSampler;
use crate::record::access::{Access, LayoutChange};
use crate::record::commands::Commands;

/// The source of the mip maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MipGeneration {
    /// Created by the device with linear blits if it supports them for this format, otherwise by
    /// the CPU.
    Blits,
    /// Created by the CPU with [`resampled`](crate::resampled).
    Cpu,
    /// Given by the caller, which [writes](crate::TextureUploads::write_levels) this number of
    /// levels, including the whole image; clamped to the number that the size has. It is the only
    /// source for light and for compressed blocks.
    Given(u32),
}

/// The description of a [`TextureArray`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureArrayInfo<'a> {
    /// The name in messages and debuggers.
    pub name: &'a str,
    /// Width and height of each layer in pixels.
    pub size: [u32; 2],
    /// The number of layers.
    pub layers: u32,
    /// `R8G8B8A8_SRGB` for colours, `R8G8B8A8_UNORM` for numbers, or `E5B9G9R9_UFLOAT_PACK32` for
    /// light. If the device supports them, also unsigned BC1 to BC5 and BC7, and ASTC
    /// ([`OptionalFeature::BcTextures`](crate::OptionalFeature::BcTextures),
    /// [`OptionalFeature::AstcTextures`](crate::OptionalFeature::AstcTextures)).
    pub format: vk::Format,
    /// The address modes beyond the edges, horizontal and vertical.
    pub wrap: [vk::SamplerAddressMode; 2],
    /// The filter for magnification.
    pub magnified: vk::Filter,
    /// The filter for minification.
    pub minified: vk::Filter,
    /// The filter between mip maps; `None` for a texture without mip maps.
    pub between_levels: Option<vk::SamplerMipmapMode>,
    /// The most samples of the anisotropic filter, clamped to 1 and to the device's limit. 1
    /// without [`OptionalFeature::Anisotropy`](crate::OptionalFeature::Anisotropy) or without
    /// linear filters.
    pub anisotropy: f32,
    /// The source of the mip maps.
    pub mip_making: MipGeneration,
}

impl TextureArrayInfo<'_> {
    /// Returns the number of levels.
    fn levels(&self) -> u32 {
        let all = match self.between_levels {
            Some(_) => self.size[0].max(self.size[1]).max(1).ilog2() + 1,
            None => 1,
        };
        match self.mip_making {
            MipGeneration::Given(levels) => levels.clamp(1, all),
            MipGeneration::Blits | MipGeneration::Cpu => all,
        }
    }

    /// Returns the size of all layers with all their mip maps; 0 for an unsupported format. On a
    /// device, an image may take somewhat more.
    #[must_use]
    pub fn size_bytes(&self) -> u64 {
        let Some(blocks) = TexelBlocks::of(self.format) else { return 0 };
        let of_level = |level: u32| {
            let [width, height] = self.size.map(|side| (side >> level).max(1));
            blocks.row_bytes(width) * u64::from(blocks.rows(height))
        };
        (0..self.levels()).map(of_level).sum::<u64>() * u64::from(self.layers)
    }
}

/// Layers of one size, format and sampler. The array can be bound once every layer was [written or
/// reserved](crate::TextureUploads).
pub struct TextureArray {
    device: Device,
    image: Image,
    sampler: Arc<TextureSampler>,
    pub(super) size: [u32; 2],
    pub(super) format: vk::Format,
    blocks: TexelBlocks,
    pub(crate) levels: u32,
    pub(super) mip_making: MipGeneration,
    pub(super) layers: Vec<Layer>,
}

/// The state of the upload of a layer.
#[derive(Debug, Clone, Default)]
pub(super) struct Layer {
    /// The number of rows of blocks on the GPU, from the top.
    pub(super) rows: u32,
    /// The bytes written so far, kept if the CPU creates the mip maps.
    pub(super) kept: Vec<u8>,
}

of_device!(TextureArray: "a texture array (`TextureArray`)");

impl TextureArray {
    /// Creates an array of empty layers.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for a size or number of layers that is 0 or beyond the device's limits;
    /// [`Error::WrongCommands`] for an unsupported format, or for blocks without given mip maps;
    /// [`Error::Unsupported`] for blocks that the device does not support; no memory.
    pub fn new(device: &Device, info: &TextureArrayInfo<'_>) -> Result<Self, Error> {
        Self::with_sampler(device, info, Arc::new(TextureSampler::new(device, info)?))
    }

    /// Creates an array of empty layers with a shared sampler, which was created for an equal
    /// sampler description.
    pub(super) fn with_sampler(
        device: &Device,
        info: &TextureArrayInfo<'_>,
        sampler: Arc<TextureSampler>,
    ) -> Result<Self, Error> {
        let limits = &device.adapter().limits;
        let [width, height] = info.size;
        for (what, wanted, limit) in [
            ("the width of", width, limits.max_image_dimension2_d),
            ("the height of", height, limits.max_image_dimension2_d),
            ("the number of layers of", info.layers, limits.max_image_array_layers),
        ] {
            if wanted == 0 || wanted > limit {
                let what = format!("{what} the texture {}", info.name);
                return Err(Error::TooLarge { what, wanted: wanted.into(), limit: limit.into() });
            }
        }
        let blocks = blocks_of(device, info)?;
        let blits = vk::FormatFeatureFlags::BLIT_SRC
            | vk::FormatFeatureFlags::BLIT_DST
            | vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
        let can_blit = device.has_format_feature(info.format, blits);
        let levels = info.levels();
        let mip_making = match info.mip_making {
            MipGeneration::Blits if !can_blit => MipGeneration::Cpu,
            source => source,
        };
        let usage = vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_DST
            | vk::ImageUsageFlags::TRANSFER_SRC;
        let TextureArrayInfo { name, size, layers, format, .. } = *info;
        let image = Image::array(device, name, size, levels, layers, format, usage)?;
        Ok(Self {
            device: device.clone(),
            image,
            sampler,
            size: info.size,
            format: info.format,
            blocks,
            levels,
            mip_making,
            layers: vec![Layer::default(); info.layers as usize],
        })
    }

    /// Returns the size of each layer in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the number of layers.
    pub fn layers(&self) -> u32 {
        self.layers.len() as u32
    }

    /// Returns true if the caller provides the mip maps.
    pub(crate) fn has_given_levels(&self) -> bool {
        matches!(self.mip_making, MipGeneration::Given(_))
    }

    /// Returns an error if `bytes` does not have the size of a level.
    pub(crate) fn check_level(&self, level: u32, bytes: &[u8]) -> Result<(), Error> {
        let wanted = self.row_bytes(level) * u64::from(self.level_rows(level));
        if bytes.len() as u64 == wanted {
            return Ok(());
        }
        Err(Error::WrongCommands("a layer is written with too many or too few bytes"))
    }

    /// Returns true if the device creates the mip maps.
    pub(crate) fn blits_levels(&self) -> bool {
        self.mip_making == MipGeneration::Blits && self.levels > 1
    }

    /// Returns the mip maps of a whole layer from its second level on if the CPU creates them;
    /// otherwise none.
    pub fn levels_by_cpu(&self, rgba8: &[u8]) -> Vec<Vec<u8>> {
        let mut levels: Vec<Vec<u8>> = Vec::new();
        if self.mip_making == MipGeneration::Cpu {
            for level in 1..self.levels {
                let [from, to] = [level - 1, level].map(|level| self.level_size(level));
                let above = levels.last().map_or(rgba8, Vec::as_slice);
                levels.push(resampled(above, from, to, self.format));
            }
        }
        levels
    }

    /// Marks all layers as reserved. The caller must [open](crate::Commands::open_texture) them in
    /// the next frame, before they are sampled or written.
    pub fn announce(&mut self) {
        let rows = self.level_rows(0);
        self.layers.iter_mut().for_each(|layer| layer.rows = rows);
    }

    /// Returns true if all layers were written or reserved.
    pub fn is_filled(&self) -> bool {
        self.layers.iter().all(|layer| layer.rows == self.level_rows(0))
    }

    pub(crate) fn descriptor(&self) -> vk::DescriptorImageInfo {
        vk::DescriptorImageInfo {
            sampler: self.sampler.raw,
            image_view: self.image.view,
            image_layout: Access::FragmentSample.layout(),
        }
    }

    pub(crate) fn level_size(&self, level: u32) -> [u32; 2] {
        self.size.map(|side| (side >> level).max(1))
    }

    /// Returns the number of rows of blocks in a level.
    pub(crate) fn level_rows(&self, level: u32) -> u32 {
        self.blocks.rows(self.level_size(level)[1])
    }

    pub(crate) fn row_bytes(&self, level: u32) -> u64 {
        self.blocks.row_bytes(self.level_size(level)[0])
    }

    pub(crate) fn change(
        &self,
        layer: u32,
        levels: std::ops::Range<u32>,
        from: Access,
        to: Access,
    ) -> LayoutChange {
        let part = vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            base_mip_level: levels.start,
            level_count: levels.end - levels.start,
            base_array_layer: layer,
            layer_count: 1,
        };
        LayoutChange::of_part(self.image.raw, part, from, to)
    }

    /// Copies complete rows of blocks from the beginning of a slice to a level.
    pub(crate) fn copy_rows(
        &self,
        commands: &Commands,
        from: BufferSlice,
        layer: u32,
        level: u32,
        rows: std::ops::Range<u32>,
    ) {
        let [width, height] = self.level_size(level);
        // Blocks at the lower edge extend beyond it, but a copy must not
        // (VUID-vkCmdCopyBufferToImage-imageSubresource-07972).
        let texels = |row: u32| (row * self.blocks.size[1]).min(height);
        let first = texels(rows.start);
        let end = texels(rows.end);
        let region = vk::BufferImageCopy::default()
            .buffer_offset(from.offset_bytes)
            .image_subresource(level_of(layer, level))
            .image_offset(vk::Offset3D { x: 0, y: first as i32, z: 0 })
            .image_extent(vk::Extent3D { width, height: end - first, depth: 1 });
        // SAFETY: the caller's rows lie in the level and in the slice; the level is in the given
        // layout.
        unsafe {
            commands.device().raw().cmd_copy_buffer_to_image(
                commands.raw(),
                from.raw,
                self.image.raw,
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &[region],
            );
        }
    }

    /// Creates each level of a layer from the previous level, and prepares all levels to be
    /// sampled.
    pub(crate) fn blit_levels(&self, commands: &Commands, layer: u32) {
        for level in 1..self.levels {
            let source = level - 1..level;
            commands.change_layouts([self.change(
                layer,
                source,
                Access::CopyWrite,
                Access::CopyRead,
            )]);
            let corner = |level| {
                let [width, height] = self.level_size(level);
                [vk::Offset3D::default(), vk::Offset3D { x: width as i32, y: height as i32, z: 1 }]
            };
            let blit = vk::ImageBlit::default()
                .src_subresource(level_of(layer, level - 1))
                .src_offsets(corner(level - 1))
                .dst_subresource(level_of(layer, level))
                .dst_offsets(corner(level));
            // SAFETY: the format supports linear blits, as was checked at creation; both levels are
            // in the given layouts.
            unsafe {
                commands.device().raw().cmd_blit_image(
                    commands.raw(),
                    self.image.raw,
                    vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                    self.image.raw,
                    vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                    &[blit],
                    vk::Filter::LINEAR,
                );
            }
        }
        let last = self.levels - 1;
        commands.change_layouts([self.change(
            layer,
            last..self.levels,
            Access::CopyWrite,
            Access::FragmentSample,
        )]);
        if last > 0 {
            commands.change_layouts([self.change(
                layer,
                0..last,
                Access::CopyRead,
                Access::FragmentSample,
            )]);
        }
    }
}

/// Returns the blocks of the format of a description.
fn blocks_of(device: &Device, info: &TextureArrayInfo<'_>) -> Result<TexelBlocks, Error> {
    const FORMATS: &str =
        "a texture array has four bytes per texel, or compressed blocks, in one of a few formats";
    let blocks = TexelBlocks::of(info.format).ok_or(Error::WrongCommands(FORMATS))?;
    if let Some(needed) = blocks.needs {
        device.require(needed, "textures of compressed blocks")?;
    }
    let has_bytes = matches!(info.format, vk::Format::R8G8B8A8_SRGB | vk::Format::R8G8B8A8_UNORM);
    match info.mip_making {
        MipGeneration::Given(_) => Ok(blocks),
        MipGeneration::Blits | MipGeneration::Cpu if has_bytes => Ok(blocks),
        MipGeneration::Blits | MipGeneration::Cpu => Err(Error::WrongCommands(
            "nobody makes mip maps but of textures of four channels of eight bits",
        )),
    }
}

fn level_of(layer: u32, level: u32) -> vk::ImageSubresourceLayers {
    vk::ImageSubresourceLayers {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        mip_level: level,
        base_array_layer: layer,
        layer_count: 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_takes_the_bytes_of_all_its_levels_and_layers() {
        let info = TextureArrayInfo {
            name: "",
            size: [8, 4],
            layers: 3,
            format: vk::Format::R8G8B8A8_SRGB,
            wrap: [vk::SamplerAddressMode::REPEAT; 2],
            magnified: vk::Filter::LINEAR,
            minified: vk::Filter::LINEAR,
            between_levels: Some(vk::SamplerMipmapMode::LINEAR),
            anisotropy: 1.0,
            mip_making: MipGeneration::Blits,
        };
        assert_eq!(info.size_bytes(), 3 * 4 * (32 + 8 + 2 + 1));
        assert_eq!(TextureArrayInfo { between_levels: None, ..info }.size_bytes(), 3 * 4 * 32);
        let format = vk::Format::BC7_SRGB_BLOCK;
        let blocks = TextureArrayInfo { format, mip_making: MipGeneration::Given(2), ..info };
        assert_eq!(blocks.size_bytes(), 3 * 16 * (2 + 1));
        assert_eq!(TextureArrayInfo { format: vk::Format::R8_UNORM, ..info }.size_bytes(), 0);
    }
}
