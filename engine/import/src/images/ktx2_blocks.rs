//! Images of compressed blocks in KTX2 files: BC1 to BC5, BC7 and ASTC, as they are or packed by
//! Zstandard.

use ktx2::{Format, Header, Reader, SupercompressionScheme};
use ruzstd::decoding::FrameDecoder;
use scene::{AstcBlock, BlockFormat, Texels};

use super::ImageHead;
use crate::error::Reason;
use crate::memory;

/// The window that Zstandard's usual levels take for data of any size.
const WINDOW_BYTES: u64 = 2 << 20;

/// An encoded image of blocks.
pub(super) struct EncodedBlocks {
    format: BlockFormat,
    are_packed: bool,
    /// The bytes of each mip map, the whole image first.
    level_bytes: Vec<u64>,
}

impl EncodedBlocks {
    /// Returns true for a KTX2 file.
    pub(super) fn are_in(encoded: &[u8]) -> bool {
        encoded.starts_with(&ktx2::MAGIC)
    }

    /// Reads the head of an image.
    pub(super) fn read(encoded: &[u8]) -> Result<(ImageHead, Self), Reason> {
        let reader = reader(encoded)?;
        let header = reader.header();
        let format = format_of(&header)?;
        let are_packed = match header.supercompression_scheme {
            None => false,
            Some(SupercompressionScheme::Zstandard) => true,
            Some(other) => {
                let text =
                    format!("it is a KTX2 image packed by {other:?}; Zstandard is supported");
                return Err(Reason::unsupported(text));
            }
        };
        check_layout(&reader, &header)?;
        let size = [header.pixel_width, header.pixel_height];
        let levels = header.level_count.max(1);
        if levels > size[0].max(size[1]).max(1).ilog2() + 1 {
            return Err(Reason::malformed(
                "it is a KTX2 image with more mip maps than its size has",
            ));
        }
        let bytes_of = |level: u32| format.bytes(size.map(|side| (side >> level).max(1)));
        let level_bytes: Vec<u64> =
            (0..levels).map(|level| bytes_of(level).unwrap_or(u64::MAX)).collect();
        let bytes = level_bytes.iter().fold(0_u64, |all, level| all.saturating_add(*level));
        let blocks = Self { format, are_packed, level_bytes };
        // The decoder's buffer begins as large as the window; beyond that it is copied to one twice
        // as large.
        let window_bytes = if are_packed { blocks.window_bytes().saturating_mul(3) } else { 0 };
        let scratch_bytes = window_bytes.saturating_add(encoded.len() as u64);
        Ok((ImageHead { size, bytes, scratch_bytes }, blocks))
    }

    /// Returns the largest window of Zstandard that is taken: none beyond a mip map is of use.
    fn window_bytes(&self) -> u64 {
        let largest = self.level_bytes.first().copied().unwrap_or_default();
        largest.checked_next_power_of_two().unwrap_or(u64::MAX).max(WINDOW_BYTES)
    }

    /// Takes the blocks of all mip maps out of the file.
    pub(super) fn decode(&self, encoded: &[u8]) -> Result<Texels, Reason> {
        let reader = reader(encoded)?;
        let mut decoder = FrameDecoder::new();
        decoder.set_max_window_size(self.window_bytes());
        let mut levels = Vec::with_capacity(self.level_bytes.len());
        for (level, &bytes) in reader.levels().zip(&self.level_bytes) {
            memory::ask(bytes)?;
            let wrong = || {
                let number = levels.len();
                Reason::damaged(format!("mip map {number} of a KTX2 image has not {bytes} bytes"))
            };
            let blocks = if self.are_packed {
                let mut blocks = vec![0; usize::try_from(bytes).map_err(|_| wrong())?];
                let found = decoder.decode_all(level.data, &mut blocks).map_err(|_| wrong())?;
                if found == blocks.len() { blocks } else { return Err(wrong()) }
            } else if level.data.len() as u64 == bytes {
                level.data.to_vec()
            } else {
                return Err(wrong());
            };
            levels.push(blocks);
        }
        Ok(Texels::Blocks { format: self.format, levels })
    }
}

fn reader(encoded: &[u8]) -> Result<Reader<&[u8]>, Reason> {
    let wrong = |error| Reason::damaged(format!("it is a KTX2 image that cannot be read: {error}"));
    Reader::new(encoded).map_err(wrong)
}

/// Returns the format of the blocks. The materials say what they mean, not the file.
fn format_of(header: &Header) -> Result<BlockFormat, Reason> {
    const KNOWN: &str = "BC1 to BC5, BC7 and ASTC without light beyond white are supported";
    let Some(format) = header.format else {
        let text = format!("it is a KTX2 image of Basis Universal; {KNOWN}");
        return Err(Reason::unsupported(text));
    };
    Ok(match format {
        Format::BC1_RGB_UNORM_BLOCK | Format::BC1_RGB_SRGB_BLOCK => BlockFormat::Bc1,
        Format::BC1_RGBA_UNORM_BLOCK | Format::BC1_RGBA_SRGB_BLOCK => BlockFormat::Bc1Alpha,
        Format::BC2_UNORM_BLOCK | Format::BC2_SRGB_BLOCK => BlockFormat::Bc2,
        Format::BC3_UNORM_BLOCK | Format::BC3_SRGB_BLOCK => BlockFormat::Bc3,
        Format::BC4_UNORM_BLOCK => BlockFormat::Bc4,
        Format::BC5_UNORM_BLOCK => BlockFormat::Bc5,
        Format::BC7_UNORM_BLOCK | Format::BC7_SRGB_BLOCK => BlockFormat::Bc7,
        other => {
            let place = other.value().checked_sub(Format::ASTC_4x4_UNORM_BLOCK.value());
            let block = place.and_then(|place| AstcBlock::of_place(place / 2));
            let text = || format!("it is a KTX2 image of {other:?}; {KNOWN}");
            BlockFormat::Astc(block.ok_or_else(|| Reason::unsupported(text()))?)
        }
    })
}

/// Refuses what is no flat image with rows from the top and all of its channels as they are.
fn check_layout(reader: &Reader<&[u8]>, header: &Header) -> Result<(), Reason> {
    let is_flat = header.pixel_height > 0
        && header.pixel_depth == 0
        && header.layer_count <= 1
        && header.face_count == 1;
    if !is_flat {
        let text = "it is a KTX2 image of several layers, faces or depths, or of a line";
        return Err(Reason::unsupported(text));
    }
    let has = |key: &str, wanted: &[u8]| {
        let mut values = reader.key_value_data().filter(|(name, _)| *name == key);
        values.all(|(_, value)| value.strip_suffix(b"\0").unwrap_or(value) == wanted)
    };
    if !has("KTXorientation", b"rd") {
        return Err(Reason::unsupported("it is a KTX2 image whose rows are not from the top"));
    }
    if !has("KTXswizzle", b"rgba") {
        return Err(Reason::unsupported("it is a KTX2 image whose channels are swapped"));
    }
    if reader.is_alpha_premultiplied() == Some(true) {
        let text = "it is a KTX2 image whose colours are multiplied by alpha";
        return Err(Reason::unsupported(text));
    }
    Ok(())
}
