//! Formats of textures: four bytes per texel, or compressed blocks of texels.

use ash::vk;

use crate::core::capabilities::OptionalFeature;

/// The layout of a format's texels: blocks that lie in memory as a unit. A block of an uncompressed
/// format is a single texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TexelBlocks {
    /// The width and height of a block in texels.
    pub(crate) size: [u32; 2],
    /// The size of a block in bytes.
    pub(crate) bytes: u32,
    /// The capability that a device needs for these blocks.
    pub(crate) needs: Option<OptionalFeature>,
}

/// The block sizes of ASTC in the order of their formats, of which each size has two.
const ASTC_SIZES: [[u32; 2]; 14] = [
    [4, 4],
    [5, 4],
    [5, 5],
    [6, 5],
    [6, 6],
    [8, 5],
    [8, 6],
    [8, 8],
    [10, 5],
    [10, 6],
    [10, 8],
    [10, 10],
    [12, 10],
    [12, 12],
];

impl TexelBlocks {
    /// Returns the blocks of a format; `None` for a format that textures do not support.
    pub(crate) fn of(format: vk::Format) -> Option<Self> {
        let of_bc = |bytes| Self { size: [4; 2], bytes, needs: Some(OptionalFeature::BcTextures) };
        Some(match format {
            vk::Format::R8G8B8A8_SRGB
            | vk::Format::R8G8B8A8_UNORM
            | vk::Format::E5B9G9R9_UFLOAT_PACK32 => Self { size: [1; 2], bytes: 4, needs: None },
            vk::Format::BC1_RGB_UNORM_BLOCK
            | vk::Format::BC1_RGB_SRGB_BLOCK
            | vk::Format::BC1_RGBA_UNORM_BLOCK
            | vk::Format::BC1_RGBA_SRGB_BLOCK
            | vk::Format::BC4_UNORM_BLOCK => of_bc(8),
            vk::Format::BC2_UNORM_BLOCK
            | vk::Format::BC2_SRGB_BLOCK
            | vk::Format::BC3_UNORM_BLOCK
            | vk::Format::BC3_SRGB_BLOCK
            | vk::Format::BC5_UNORM_BLOCK
            | vk::Format::BC7_UNORM_BLOCK
            | vk::Format::BC7_SRGB_BLOCK => of_bc(16),
            other => {
                let first = vk::Format::ASTC_4X4_UNORM_BLOCK.as_raw();
                let place = usize::try_from(other.as_raw().checked_sub(first)?).ok()? / 2;
                let size = *ASTC_SIZES.get(place)?;
                Self { size, bytes: 16, needs: Some(OptionalFeature::AstcTextures) }
            }
        })
    }

    /// Returns the number of rows of blocks in `height` rows of texels.
    pub(crate) fn rows(self, height: u32) -> u32 {
        height.div_ceil(self.size[1])
    }

    /// Returns the size in bytes of a row of blocks that covers `width` texels.
    pub(crate) fn row_bytes(self, width: u32) -> u64 {
        u64::from(width.div_ceil(self.size[0])) * u64::from(self.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_have_the_blocks_that_vulkan_says() {
        let of = |format| {
            TexelBlocks::of(format)
                .map(|texel_blocks: TexelBlocks| (texel_blocks.size, texel_blocks.bytes))
        };
        assert_eq!(of(vk::Format::R8G8B8A8_SRGB), Some(([1, 1], 4)));
        assert_eq!(of(vk::Format::BC1_RGBA_SRGB_BLOCK), Some(([4, 4], 8)));
        assert_eq!(of(vk::Format::BC7_UNORM_BLOCK), Some(([4, 4], 16)));
        assert_eq!(of(vk::Format::ASTC_4X4_SRGB_BLOCK), Some(([4, 4], 16)));
        assert_eq!(of(vk::Format::ASTC_10X6_UNORM_BLOCK), Some(([10, 6], 16)));
        assert_eq!(of(vk::Format::ASTC_12X12_SRGB_BLOCK), Some(([12, 12], 16)));
        for other in [
            vk::Format::UNDEFINED,
            vk::Format::R8_UNORM,
            vk::Format::BC5_SNORM_BLOCK,
            vk::Format::BC6H_UFLOAT_BLOCK,
            vk::Format::EAC_R11G11_SNORM_BLOCK,
            vk::Format::from_raw(185),
        ] {
            assert_eq!(of(other), None, "{other:?}");
        }
    }

    #[test]
    fn rows_of_blocks_reach_beyond_the_edges() {
        let blocks = TexelBlocks::of(vk::Format::ASTC_8X5_SRGB_BLOCK).unwrap();
        assert_eq!((blocks.rows(1), blocks.rows(5), blocks.rows(6)), (1, 1, 2));
        assert_eq!((blocks.row_bytes(8), blocks.row_bytes(9)), (16, 32));
    }
}
