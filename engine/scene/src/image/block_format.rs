//! Formats of compressed blocks.

/// A format of compressed blocks that GPUs can sample. Colours and numbers have the same formats:
/// the [`Encoding`](crate::Encoding) of a texture gives their meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BlockFormat {
    /// BC1: red, green, blue; all opaque.
    Bc1,
    /// BC1 with holes: texels are opaque, or black and transparent.
    Bc1Alpha,
    /// BC2: BC1 and four bits of alpha.
    Bc2,
    /// BC3: BC1 and BC4 of alpha.
    Bc3,
    /// BC4: red alone.
    Bc4,
    /// BC5: red and green. As a normal map it holds x and y; z is computed from them.
    Bc5,
    /// BC7: red, green, blue, alpha.
    Bc7,
    /// ASTC of low dynamic range: red, green, blue, alpha.
    Astc(AstcBlock),
}

/// The size of the blocks of ASTC.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AstcBlock(u8);

/// The sizes in the order of Vulkan's formats.
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

impl AstcBlock {
    /// Returns the block format of a size in texels; `None` for a size that ASTC does not have.
    pub fn of_size(size: [u32; 2]) -> Option<Self> {
        let place = ASTC_SIZES.iter().position(|known| *known == size)?;
        Some(Self(place as u8))
    }

    /// Returns the block format at a place in the order of Vulkan's formats, from 4x4 on.
    pub fn of_place(place: u32) -> Option<Self> {
        ((place as usize) < ASTC_SIZES.len()).then_some(Self(place as u8))
    }

    /// Returns the place in the order of Vulkan's formats, from 4x4 on.
    pub fn place(self) -> u32 {
        self.0.into()
    }

    /// Returns the width and height of a block in texels.
    pub fn size(self) -> [u32; 2] {
        ASTC_SIZES.get(usize::from(self.0)).copied().unwrap_or([4; 2])
    }
}

impl BlockFormat {
    /// Returns the width and height of a block in texels.
    pub fn block_size(self) -> [u32; 2] {
        match self {
            Self::Astc(block) => block.size(),
            _ => [4; 2],
        }
    }

    /// Returns the bytes of a block.
    pub fn block_bytes(self) -> u32 {
        match self {
            Self::Bc1 | Self::Bc1Alpha | Self::Bc4 => 8,
            Self::Bc2 | Self::Bc3 | Self::Bc5 | Self::Bc7 | Self::Astc(_) => 16,
        }
    }

    /// Returns the number of bytes of all blocks of an image of this size in texels.
    pub fn bytes(self, size: [u32; 2]) -> Option<u64> {
        let [width, height] = self.block_size();
        let blocks = [size[0].div_ceil(width), size[1].div_ceil(height)].map(u64::from);
        blocks[0].checked_mul(blocks[1])?.checked_mul(self.block_bytes().into())
    }

    /// Returns true if blocks of the format can hold colours. BC4 and BC5 hold numbers: colours in
    /// them are unpacked.
    pub fn has_colours(self) -> bool {
        !matches!(self, Self::Bc4 | Self::Bc5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_astc_are_known_by_size_and_by_place() {
        for place in 0..14 {
            let block = AstcBlock::of_place(place).unwrap();
            assert_eq!((block.place(), AstcBlock::of_size(block.size())), (place, Some(block)));
        }
        assert_eq!(AstcBlock::of_place(14), None);
        assert_eq!(AstcBlock::of_size([4, 5]), None);
    }

    #[test]
    fn blocks_at_the_edges_count_whole() {
        let astc = |size| BlockFormat::Astc(AstcBlock::of_size(size).unwrap());
        assert_eq!(BlockFormat::Bc1.bytes([1, 1]), Some(8));
        assert_eq!(BlockFormat::Bc3.bytes([5, 9]), Some(96));
        assert_eq!(astc([12, 10]).bytes([13, 10]), Some(32));
        assert_eq!(BlockFormat::Bc1.bytes([u32::MAX; 2]), Some(1 << 63));
        assert_eq!(BlockFormat::Bc7.bytes([u32::MAX; 2]), None);
    }
}
