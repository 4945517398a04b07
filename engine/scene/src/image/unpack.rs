//! Unpacking of compressed blocks on the CPU, for devices that do not sample them.

use std::cmp::Ordering;
use std::panic::catch_unwind;

use super::block_format::{AstcBlock, BlockFormat};

/// The colour of broken ASTC blocks, as GPUs show them: blue, green, red, alpha.
const BROKEN: u32 = u32::from_le_bytes([255, 0, 255, 255]);

/// Returns four bytes per texel; the texels of missing blocks are 0.
pub(super) fn unpacked(format: BlockFormat, size: [u32; 2], blocks: &[u8]) -> Vec<u8> {
    let [width, height] = size.map(|side| side as usize);
    let block_rows = format.block_size()[1] as usize;
    let row_bytes = format.bytes([size[0], 1]).map_or(usize::MAX, |bytes| bytes as usize).max(1);
    let mut rgba8 = Vec::new();
    // One row of blocks at a time, so that the decoder's copy of the texels stays small.
    for (row, first) in blocks.chunks_exact(row_bytes).zip((0..height).step_by(block_rows)) {
        let texels = decoded(format, row, [width, block_rows.min(height - first)]);
        let bytes = texels.into_iter().map(u32::to_le_bytes);
        rgba8.extend(bytes.flat_map(|[blue, green, red, alpha]| [red, green, blue, alpha]));
    }
    rgba8.resize(width.saturating_mul(height).saturating_mul(4), 0);
    rgba8
}

/// Returns the texels of a row of blocks: blue, green, red, alpha from the lowest byte on.
fn decoded(format: BlockFormat, blocks: &[u8], size: [usize; 2]) -> Vec<u32> {
    let [width, height] = size;
    let mut texels = vec![0; width * height];
    let four_coloured: Vec<u8>;
    let blocks = match format {
        BlockFormat::Bc2 | BlockFormat::Bc3 => {
            let blocks = blocks.as_chunks().0;
            four_coloured = blocks.iter().flat_map(|block| four_colours(*block)).collect();
            &four_coloured
        }
        _ => blocks,
    };
    let decode = match format {
        BlockFormat::Bc1 => texture2ddecoder::decode_bc1,
        BlockFormat::Bc1Alpha => texture2ddecoder::decode_bc1a,
        BlockFormat::Bc2 => texture2ddecoder::decode_bc2,
        BlockFormat::Bc3 => texture2ddecoder::decode_bc3,
        BlockFormat::Bc4 => texture2ddecoder::decode_bc4,
        BlockFormat::Bc5 => texture2ddecoder::decode_bc5,
        BlockFormat::Bc7 => texture2ddecoder::decode_bc7,
        BlockFormat::Astc(block) => {
            decode_astc(block, blocks, &mut texels, width);
            return texels;
        }
    };
    // There is a block for each texel; the decoder fails only where blocks are missing.
    let _complete = decode(blocks, width, height, &mut texels);
    texels
}

/// Decodes a row of blocks individually: the decoder panics on some broken blocks, and the others
/// must not be lost.
fn decode_astc(block: AstcBlock, blocks: &[u8], texels: &mut [u32], width: usize) {
    let [across, down] = block.size().map(|side| side as usize);
    for (bytes, first) in blocks.chunks_exact(16).zip((0..width).step_by(across)) {
        let decoded = catch_unwind(|| {
            let mut decoded = [0; 12 * 12];
            texture2ddecoder::decode_astc_block(bytes, across, down, &mut decoded);
            decoded
        });
        let decoded = decoded.unwrap_or([BROKEN; 12 * 12]);
        for (to, from) in texels.chunks_exact_mut(width).zip(decoded.chunks_exact(across)) {
            to.iter_mut().skip(first).zip(from).for_each(|(to, from)| *to = *from);
        }
    }
}

/// Returns a block of BC2 or BC3 with the same texels whose first end colour is greater than the
/// second. Otherwise the decoder takes it for a block of three colours and black, which only BC1
/// has (Khronos Data Format Specification, 18.2).
fn four_colours(mut block: [u8; 16]) -> [u8; 16] {
    let [_, _, _, _, _, _, _, _, a, b, c, d, choices @ ..] = &mut block;
    match u16::from_le_bytes([*a, *b]).cmp(&u16::from_le_bytes([*c, *d])) {
        Ordering::Greater => {}
        Ordering::Equal => *choices = [0; 4],
        Ordering::Less => {
            // The ends and the colours between them change places.
            std::mem::swap(a, c);
            std::mem::swap(b, d);
            *choices = choices.map(|four| four ^ 0b0101_0101);
        }
    }
    block
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn broken_and_missing_blocks_panic_nowhere() {
        let mut random = 0x2545_F491_4F6C_DD1D_u64;
        let mut byte = || {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            random as u8
        };
        let astc = (0..14).filter_map(AstcBlock::of_place).map(BlockFormat::Astc);
        use BlockFormat::*;
        for format in [Bc1, Bc1Alpha, Bc2, Bc3, Bc4, Bc5, Bc7].into_iter().chain(astc) {
            for size in [[1, 1], [13, 7], [64, 64]] {
                let bytes = format.bytes(size).unwrap() as usize;
                for _ in 0..200 {
                    let blocks: Vec<u8> = (0..bytes).map(|_| byte()).collect();
                    let [whole, part] = [bytes, bytes / 2].map(|end| &blocks[..end]);
                    for blocks in [whole, part] {
                        let texels = size[0] * size[1];
                        assert_eq!(unpacked(format, size, blocks).len() as u32, texels * 4);
                    }
                }
            }
        }
    }

    #[test]
    fn a_broken_block_of_astc_is_magenta_and_its_neighbours_are_whole() {
        let one = [0xFC, 0xFD, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF].as_slice();
        let red = [one, &[0xFF, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF]].concat();
        let blocks = [red.clone(), vec![0; 16], red].concat();
        let block = BlockFormat::Astc(AstcBlock::of_size([8, 5]).unwrap());
        let texels = unpacked(block, [20, 2], &blocks);
        for (place, texel) in texels.chunks_exact(4).enumerate() {
            let is_broken = (8..16).contains(&(place % 20));
            assert_eq!(texel, [255, 0, if is_broken { 255 } else { 0 }, 255], "{place}");
        }
    }

    #[test]
    fn channels_that_a_format_lacks_are_empty_and_opaque() {
        // The two end colours of a block; all texels choose the first.
        let red = [200, 100, 0, 0, 0, 0, 0, 0];
        let green = [90, 20, 0, 0, 0, 0, 0, 0];
        assert_eq!(unpacked(BlockFormat::Bc4, [1, 1], &red), [200, 0, 0, 255]);
        let both = [red, green].concat();
        assert_eq!(unpacked(BlockFormat::Bc5, [1, 1], &both), [200, 90, 0, 255]);
        // Blocks of one colour: the last eight bytes are four channels of sixteen bits.
        let astc = [0xFC, 0xFD, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF];
        let colour = [0x10, 0x10, 0x80, 0x80, 0xF0, 0xF0, 0x40, 0x40];
        let block = BlockFormat::Astc(AstcBlock::of_size([6, 6]).unwrap());
        let unpacked = unpacked(block, [1, 1], &[astc, colour].concat());
        assert_eq!(unpacked, [0x10, 0x80, 0xF0, 0x40]);
    }

    #[test]
    fn bc1_alone_has_three_colours_and_black() {
        // Black and white, and all four choices: the first end, the second, and the two mixes.
        let opaque = [255; 8];
        let low_first = [0, 0, 255, 255, 0b1110_0100, 0, 0, 0];
        let high_first = [255, 255, 0, 0, 0b1110_0100, 0, 0, 0];
        let reds = |format, colours: [u8; 8]| {
            let block = match format {
                BlockFormat::Bc1 => colours.to_vec(),
                _ => [opaque, colours].concat(),
            };
            let texels = unpacked(format, [4, 1], &block);
            texels.chunks_exact(4).map(|texel| texel[0]).collect::<Vec<u8>>()
        };
        assert_eq!(reds(BlockFormat::Bc1, low_first), [0, 255, 127, 0]);
        for format in [BlockFormat::Bc2, BlockFormat::Bc3] {
            assert_eq!(reds(format, low_first), [0, 255, 85, 170], "{format:?}");
            assert_eq!(reds(format, high_first), [255, 0, 170, 85], "{format:?}");
            assert_eq!(reds(format, [255; 8]), [255; 4], "{format:?}");
        }
    }

    #[test]
    fn holes_of_bc1_are_holes_only_where_they_are_meant() {
        // The first end is not above the second: the last of the four texels is black.
        let block = [0, 0, 255, 255, 255, 255, 255, 255];
        assert_eq!(unpacked(BlockFormat::Bc1, [1, 1], &block), [0, 0, 0, 255]);
        assert_eq!(unpacked(BlockFormat::Bc1Alpha, [1, 1], &block), [0, 0, 0, 0]);
    }
}
