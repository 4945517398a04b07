//! Images of textures, as texels or as compressed blocks.

mod block_format;
mod unpack;

pub use block_format::{AstcBlock, BlockFormat};

use std::borrow::Cow;

/// An image of a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The name, for people.
    pub name: String,
    /// Width and height in texels, neither 0.
    pub size: [u32; 2],
    /// The texels.
    pub texels: Texels,
}

/// The texels of an image.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Four channels of eight bits: rows from the top without gaps. Mip maps are generated from
    /// them.
    Rgba8(Vec<u8>),
    /// Compressed blocks. For texture pages, and for devices that do not support the format, they
    /// are [unpacked](Image::rgba8) to four bytes per texel.
    Blocks {
        /// The format of the blocks.
        format: BlockFormat,
        /// The mip maps, starting with the whole image: each half as wide and high as the one
        /// before, rounded down, but at least one texel. Rows of blocks from the top without gaps;
        /// blocks may reach beyond the edges. Mip maps after the last one do not exist for the
        /// sampler.
        levels: Vec<Vec<u8>>,
    },
}

impl Image {
    /// Returns an image of four bytes per texel.
    pub fn of_rgba8(name: impl Into<String>, size: [u32; 2], rgba8: Vec<u8>) -> Self {
        Self { name: name.into(), size, texels: Texels::Rgba8(rgba8) }
    }

    /// Checks that the number of bytes matches the size.
    ///
    /// # Errors
    /// The fault, as the end of a sentence.
    pub fn check(&self) -> Result<(), &'static str> {
        let texels = self.size.map(u64::from).iter().product::<u64>();
        match &self.texels {
            Texels::Rgba8(bytes) if texels.checked_mul(4) == Some(bytes.len() as u64) => {}
            Texels::Rgba8(_) => return Err("it has not four bytes for each pixel of its size"),
            Texels::Blocks { format, levels } => {
                let most =
                    self.size.iter().max().map_or(0, |side| side.checked_ilog2().unwrap_or(0) + 1);
                if levels.is_empty() || levels.len() > most as usize {
                    return Err("it has no mip maps, or more than its size has");
                }
                let is_whole = |(level, bytes): (u32, &Vec<u8>)| {
                    format.bytes(self.level_size(level)) == Some(bytes.len() as u64)
                };
                if !(0..).zip(levels).all(is_whole) {
                    return Err("a mip map has not the bytes of all blocks of its size");
                }
            }
        }
        if texels == 0 { Err("it has no pixels") } else { Ok(()) }
    }

    /// Returns the size of a mip map in texels; level 0 is the whole image.
    pub fn level_size(&self, level: u32) -> [u32; 2] {
        self.size.map(|side| side.checked_shr(level).unwrap_or(0).max(1))
    }

    /// Returns the number of bytes of a row of a mip map: a row of texels, or of blocks.
    pub fn row_bytes(&self, level: u32) -> usize {
        let [width, _] = self.level_size(level);
        match &self.texels {
            Texels::Rgba8(_) => width as usize * 4,
            Texels::Blocks { format, .. } => {
                let [across, _] = format.block_size();
                width.div_ceil(across) as usize * format.block_bytes() as usize
            }
        }
    }

    /// Returns the whole image with four bytes per texel, unpacked on the CPU if it has blocks. The
    /// image must pass [`Image::check`]. Channels that the format lacks are 0, alpha is 255; broken
    /// blocks are magenta.
    pub fn rgba8(&self) -> Cow<'_, [u8]> {
        match &self.texels {
            Texels::Rgba8(bytes) => Cow::Borrowed(bytes),
            Texels::Blocks { format, levels } => {
                let blocks = levels.first().map(Vec::as_slice).unwrap_or_default();
                Cow::Owned(unpack::unpacked(*format, self.size, blocks))
            }
        }
    }

    /// Returns the image with four bytes per texel and without mip maps.
    #[must_use]
    pub fn unpacked(self) -> Self {
        if let Texels::Rgba8(_) = self.texels {
            return self;
        }
        let rgba8 = self.rgba8().into_owned();
        Self::of_rgba8(self.name, self.size, rgba8)
    }

    /// Returns true if the image has only red and green, like normal maps of two channels, whose
    /// third channel is computed.
    pub fn has_two_channels(&self) -> bool {
        matches!(self.texels, Texels::Blocks { format: BlockFormat::Bc5, .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(size: [u32; 2], format: BlockFormat, levels: &[usize]) -> Image {
        let levels = levels.iter().map(|bytes| vec![0; *bytes]).collect();
        Image { name: String::new(), size, texels: Texels::Blocks { format, levels } }
    }

    #[test]
    fn an_image_has_all_bytes_of_its_size() {
        let rgba8 = |size, bytes| Image::of_rgba8("", size, vec![0; bytes]).check();
        assert_eq!(rgba8([2, 3], 24), Ok(()));
        for (size, bytes) in [([2, 3], 23), ([2, 0], 0), ([u32::MAX; 2], 4), ([0, 1], 0)] {
            assert!(rgba8(size, bytes).is_err(), "{size:?}");
        }
        let astc = BlockFormat::Astc(AstcBlock::of_size([6, 5]).unwrap());
        for (image, is_whole) in [
            (blocks([4, 4], BlockFormat::Bc7, &[16]), true),
            (blocks([4, 4], BlockFormat::Bc7, &[16, 16, 16]), true),
            (blocks([4, 4], BlockFormat::Bc7, &[16, 16, 16, 16]), false),
            (blocks([4, 4], BlockFormat::Bc7, &[]), false),
            (blocks([4, 4], BlockFormat::Bc7, &[8]), false),
            (blocks([9, 5], BlockFormat::Bc1, &[48, 8]), true),
            (blocks([9, 5], BlockFormat::Bc1, &[48, 16]), false),
            (blocks([13, 11], astc, &[144, 16]), true),
            (blocks([0, 4], BlockFormat::Bc1, &[0]), false),
            (blocks([u32::MAX; 2], BlockFormat::Bc1, &[8]), false),
        ] {
            assert_eq!(image.check().is_ok(), is_whole, "{image:?}");
        }
    }

    #[test]
    fn blocks_are_unpacked_to_the_size_of_the_image() {
        // Two colours, white and black; all texels choose the first.
        let white = [255, 255, 0, 0, 0, 0, 0, 0];
        let mut image = blocks([5, 3], BlockFormat::Bc1, &[]);
        image.texels = Texels::Blocks { format: BlockFormat::Bc1, levels: vec![white.repeat(2)] };
        assert_eq!(image.check(), Ok(()));
        assert_eq!(image.rgba8(), vec![255; 5 * 3 * 4]);
        let unpacked = image.unpacked();
        assert_eq!((unpacked.size, unpacked.check()), ([5, 3], Ok(())));
        assert!(matches!(unpacked.texels, Texels::Rgba8(_)));
    }
}
