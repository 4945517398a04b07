//! Images of compressed blocks that a device samples without unpacking.

use gpu::{Device, OptionalFeature, vk};
use scene::{BlockFormat, Encoding, Image, Sampler, Texels};

/// The compressed formats that textures with separate images may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SampledBlocks {
    pub(crate) bc: bool,
    pub(crate) astc: bool,
}

/// The part of a compressed image that the GPU samples without unpacking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PageBlocks {
    pub(crate) format: BlockFormat,
    /// The first of the image's mip maps that the device supports.
    pub(crate) first_level: u32,
    /// The number of mip maps from there on.
    pub(crate) levels: u32,
}

impl SampledBlocks {
    /// Returns the compressed formats that a device supports.
    pub(crate) fn of(device: &Device) -> Self {
        let has = |optional| device.capabilities().has(optional);
        Self { bc: has(OptionalFeature::BcTextures), astc: has(OptionalFeature::AstcTextures) }
    }

    /// Returns the part of an image that is sampled without unpacking. It begins with the first mip
    /// map that fits `max_side`, and has as many levels as the sampler uses. `None` if the image
    /// must be unpacked.
    pub(crate) fn of_image(
        self,
        image: &Image,
        encoding: Encoding,
        sampler: Sampler,
        max_side: u32,
    ) -> Option<PageBlocks> {
        let Texels::Blocks { format, levels } = &image.texels else { return None };
        let is_sampled = match format {
            BlockFormat::Astc(_) => self.astc,
            _ => self.bc,
        };
        if !is_sampled || (encoding == Encoding::Srgb && !format.has_colours()) {
            return None;
        }
        let fits = |level: &u32| image.level_size(*level).iter().all(|side| *side <= max_side);
        let all = levels.len() as u32;
        let first_level = (0..all).find(fits)?;
        let levels = if sampler.between_levels.is_some() { all - first_level } else { 1 };
        Some(PageBlocks { format: *format, first_level, levels })
    }
}

impl PageBlocks {
    /// Returns the format of the image on the GPU.
    pub(crate) fn vulkan_format(&self, encoding: Encoding) -> vk::Format {
        let [srgb, linear] = match self.format {
            BlockFormat::Bc1 => [vk::Format::BC1_RGB_SRGB_BLOCK, vk::Format::BC1_RGB_UNORM_BLOCK],
            BlockFormat::Bc1Alpha => {
                [vk::Format::BC1_RGBA_SRGB_BLOCK, vk::Format::BC1_RGBA_UNORM_BLOCK]
            }
            BlockFormat::Bc2 => [vk::Format::BC2_SRGB_BLOCK, vk::Format::BC2_UNORM_BLOCK],
            BlockFormat::Bc3 => [vk::Format::BC3_SRGB_BLOCK, vk::Format::BC3_UNORM_BLOCK],
            BlockFormat::Bc4 => [vk::Format::BC4_UNORM_BLOCK; 2],
            BlockFormat::Bc5 => [vk::Format::BC5_UNORM_BLOCK; 2],
            BlockFormat::Bc7 => [vk::Format::BC7_SRGB_BLOCK, vk::Format::BC7_UNORM_BLOCK],
            BlockFormat::Astc(block) => {
                let linear = vk::Format::ASTC_4X4_UNORM_BLOCK.as_raw() + 2 * block.place() as i32;
                [linear + 1, linear].map(vk::Format::from_raw)
            }
        };
        if encoding == Encoding::Srgb { srgb } else { linear }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::AstcBlock;

    const BOTH: SampledBlocks = SampledBlocks { bc: true, astc: true };
    const COLOURS: Encoding = Encoding::Srgb;
    const NUMBERS: Encoding = Encoding::Linear;

    fn image(format: BlockFormat, size: [u32; 2], levels: u32) -> Image {
        let mut image = Image::of_rgba8("", size, Vec::new());
        let bytes = |level| format.bytes(image.level_size(level)).unwrap() as usize;
        let levels = (0..levels).map(|level| vec![0; bytes(level)]).collect();
        image.texels = Texels::Blocks { format, levels };
        assert_eq!(image.check(), Ok(()));
        image
    }

    #[test]
    fn blocks_are_sampled_where_the_device_and_their_meaning_allow_it() {
        let astc = BlockFormat::Astc(AstcBlock::of_size([8, 8]).unwrap());
        let [bc, astc_only] =
            [(true, false), (false, true)].map(|(bc, astc)| SampledBlocks { bc, astc });
        for (format, encoding, among, is_sampled) in [
            (BlockFormat::Bc7, COLOURS, bc, true),
            (BlockFormat::Bc7, COLOURS, astc_only, false),
            (astc, NUMBERS, astc_only, true),
            (astc, NUMBERS, bc, false),
            (BlockFormat::Bc5, NUMBERS, bc, true),
            (BlockFormat::Bc5, COLOURS, bc, false),
            (BlockFormat::Bc4, COLOURS, bc, false),
            (BlockFormat::Bc1, COLOURS, SampledBlocks::default(), false),
        ] {
            let image = image(format, [8, 8], 1);
            let found = among.of_image(&image, encoding, Sampler::default(), 64);
            assert_eq!(found.is_some(), is_sampled, "{format:?} {encoding:?} {among:?}");
        }
        let bytes = Image::of_rgba8("", [1, 1], vec![0; 4]);
        assert_eq!(BOTH.of_image(&bytes, COLOURS, Sampler::default(), 64), None);
    }

    #[test]
    fn an_image_beyond_the_devices_size_begins_with_the_mip_map_that_fits() {
        let part = |levels, sampler, max_side| {
            let image = image(BlockFormat::Bc7, [100, 40], levels);
            let part = BOTH.of_image(&image, COLOURS, sampler, max_side)?;
            Some((part.first_level, part.levels))
        };
        let plain = Sampler::default();
        assert_eq!(part(7, plain, 100), Some((0, 7)));
        assert_eq!(part(7, plain, 99), Some((1, 6)));
        assert_eq!(part(7, plain, 12), Some((3, 4)));
        assert_eq!(part(3, plain, 24), None, "it must be unpacked to be made smaller");
        let largest_alone = Sampler { between_levels: None, ..plain };
        assert_eq!(part(7, largest_alone, 50), Some((1, 1)));
    }

    #[test]
    fn formats_are_those_of_vulkan() {
        let format = |format, encoding| {
            PageBlocks { format, first_level: 0, levels: 1 }.vulkan_format(encoding)
        };
        let astc = |size| BlockFormat::Astc(AstcBlock::of_size(size).unwrap());
        assert_eq!(format(astc([4, 4]), NUMBERS), vk::Format::ASTC_4X4_UNORM_BLOCK);
        assert_eq!(format(astc([8, 5]), COLOURS), vk::Format::ASTC_8X5_SRGB_BLOCK);
        assert_eq!(format(astc([12, 12]), COLOURS), vk::Format::ASTC_12X12_SRGB_BLOCK);
        assert_eq!(format(BlockFormat::Bc1Alpha, COLOURS), vk::Format::BC1_RGBA_SRGB_BLOCK);
        assert_eq!(format(BlockFormat::Bc7, NUMBERS), vk::Format::BC7_UNORM_BLOCK);
    }
}
