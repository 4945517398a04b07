//! Images in KTX2 files: compressed blocks of BC1 to BC5, BC7 and ASTC, and pixels of one to four
//! channels of eight bits, as they are or packed by Zstandard.

use ktx2::{Format, Header, Reader, SupercompressionScheme};
use ruzstd::decoding::FrameDecoder;
use scene::{AstcBlock, BlockFormat, Texels, counted};

use super::ImageHead;
use crate::error::Reason;
use crate::memory;

/// The most bytes of a format's description: one block with a size of 16 bits.
const MAX_DESCRIPTION_BYTES: u32 = 4 + 0xFFFF;

/// The form of the texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TexelForm {
    Blocks(BlockFormat),
    /// Pixels of `channels` bytes, red first.
    Pixels {
        channels: usize,
    },
}

impl TexelForm {
    /// Returns the number of bytes of a mip map, or `None` if it overflows.
    fn bytes(self, size: [u32; 2]) -> Option<u64> {
        match self {
            Self::Blocks(format) => format.bytes(size),
            Self::Pixels { channels } => {
                size.iter().try_fold(channels as u64, |all, side| all.checked_mul(u64::from(*side)))
            }
        }
    }
}

/// An encoded image.
pub(super) struct EncodedKtx2 {
    form: TexelForm,
    /// The largest window of Zstandard, if the levels are packed by it.
    window_bytes: Option<u64>,
    /// The number of bytes of each mip map that is used, the whole image first. Mip maps of pixels
    /// are generated, so only the whole image is used.
    level_bytes: Vec<u64>,
}

impl EncodedKtx2 {
    /// Returns true for a KTX2 file.
    pub(super) fn is_in(encoded: &[u8]) -> bool {
        encoded.starts_with(&ktx2::MAGIC)
    }

    /// Reads the header of an image.
    pub(super) fn read(encoded: &[u8]) -> Result<(ImageHead, Self), Reason> {
        let reader = reader(encoded)?;
        let header = reader.header();
        let form = form_of(&header)?;
        let window_bytes = match header.supercompression_scheme {
            None => None,
            Some(SupercompressionScheme::Zstandard) => {
                reader.levels().map(|level| window_bytes(level.data)).max()
            }
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
        let taken = if matches!(form, TexelForm::Pixels { .. }) { 1 } else { levels };
        let bytes_of = |level: u32| form.bytes(size.map(|side| (side >> level).max(1)));
        let level_bytes: Vec<u64> =
            (0..taken).map(|level| bytes_of(level).unwrap_or(u64::MAX)).collect();
        let bytes = level_bytes.iter().fold(0_u64, |all, level| all.saturating_add(*level));
        let texels = u64::from(size[0]) * u64::from(size[1]);
        // Pixels take four bytes per texel, and so do blocks on devices without the format.
        let bytes = bytes.max(texels.saturating_mul(4));
        // The decoder's buffer begins at the size of the window; if more is needed, it is copied to
        // a buffer of twice the size.
        let scratch_bytes = window_bytes.unwrap_or(0).saturating_mul(3);
        let scratch_bytes = scratch_bytes.saturating_add(encoded.len() as u64);
        // Pixels of fewer channels exist twice while channels are added.
        let spread_bytes = match form {
            TexelForm::Pixels { channels: 1..=3 } => level_bytes.iter().copied().sum(),
            TexelForm::Pixels { .. } | TexelForm::Blocks(_) => 0,
        };
        let scratch_bytes = scratch_bytes.saturating_add(spread_bytes);
        let head = ImageHead { size, bytes, scratch_bytes };
        Ok((head, Self { form, window_bytes, level_bytes }))
    }

    /// Reads the blocks of all mip maps, or the pixels of the whole image.
    pub(super) fn decode(&self, encoded: &[u8]) -> Result<Texels, Reason> {
        let reader = reader(encoded)?;
        let mut decoder = FrameDecoder::new();
        decoder.set_max_window_size(self.window_bytes.unwrap_or_default());
        let mut levels = Vec::with_capacity(self.level_bytes.len());
        for (level, &bytes) in reader.levels().zip(&self.level_bytes) {
            memory::ask(bytes)?;
            let number = levels.len();
            let wrong =
                |fault: &str| Reason::damaged(format!("mip map {number} of a KTX2 image {fault}"));
            let wrong_size = || wrong(&format!("is not of {}", counted(bytes, "byte", "bytes")));
            let texels = if self.window_bytes.is_some() {
                let mut texels = vec![0; usize::try_from(bytes).map_err(|_| wrong_size())?];
                let found = decoder.decode_all(level.data, &mut texels);
                match found.map_err(|error| wrong(&format!("cannot be unpacked: {error}")))? {
                    found if found == texels.len() => {}
                    _ => return Err(wrong_size()),
                }
                let found = decoder.get_calculated_checksum();
                if decoder.get_checksum_from_data().is_some_and(|sum| Some(sum) != found) {
                    return Err(wrong("has not the checksum that it names"));
                }
                texels
            } else if level.data.len() as u64 == bytes {
                level.data.to_vec()
            } else {
                return Err(wrong_size());
            };
            levels.push(texels);
        }
        match self.form {
            TexelForm::Blocks(format) => Ok(Texels::Blocks { format, levels }),
            TexelForm::Pixels { channels } => {
                let pixels = levels.pop().unwrap_or_default();
                memory::ask(pixels.len() as u64 / channels as u64 * 4)?;
                Ok(Texels::Rgba8(rgba8(pixels, channels)))
            }
        }
    }
}

/// Returns pixels with four channels: missing colours are 0, alpha 255.
fn rgba8(pixels: Vec<u8>, channels: usize) -> Vec<u8> {
    if channels == 4 {
        return pixels;
    }
    let mut rgba8 = Vec::with_capacity(pixels.len() / channels * 4);
    for pixel in pixels.chunks_exact(channels) {
        let mut spread = [0, 0, 0, u8::MAX];
        spread.iter_mut().zip(pixel).for_each(|(to, from)| *to = *from);
        rgba8.extend(spread);
    }
    rgba8
}

fn reader(encoded: &[u8]) -> Result<Reader<&[u8]>, Reason> {
    let wrong = |error| Reason::damaged(format!("it is a KTX2 image that cannot be read: {error}"));
    // The reader allocates memory for each block of the description.
    if let Some(head) = encoded.first_chunk() {
        let header = Header::from_bytes(head).map_err(wrong)?;
        if header.index.dfd_byte_length > MAX_DESCRIPTION_BYTES {
            let text = "it is a KTX2 image whose format has a description of several blocks";
            return Err(Reason::unsupported(text));
        }
    }
    Reader::new(encoded).map_err(wrong)
}

/// Returns the number of bytes that the decoder must keep for the first frame of Zstandard (RFC
/// 8878, section 3.1.1.1); 0 if there is no frame.
fn window_bytes(packed: &[u8]) -> u64 {
    const MAGIC: [u8; 4] = [0x28, 0xB5, 0x2F, 0xFD];
    let Some([descriptor, rest @ ..]) = packed.strip_prefix(&MAGIC) else { return 0 };
    let is_single_segment = descriptor & 0x20 != 0;
    let Some(window) = rest.first().filter(|_| !is_single_segment) else {
        // The window is the content, whose size follows the dictionary's number.
        let dictionary_bytes = [0, 1, 2, 4][usize::from(descriptor & 3)];
        let (size_bytes, least) = [(1, 0), (2, 256), (4, 0), (8, 0)][usize::from(descriptor >> 6)];
        let size = rest.get(dictionary_bytes..dictionary_bytes + size_bytes).unwrap_or_default();
        let size = size.iter().rev().fold(0_u64, |size, byte| size << 8 | u64::from(*byte));
        return size.saturating_add(least);
    };
    let base = 1_u64 << (10 + (window >> 3));
    base + base / 8 * u64::from(window & 7)
}

/// Returns the form of the texels. Their meaning depends on materials, not on the file.
fn form_of(header: &Header) -> Result<TexelForm, Reason> {
    const KNOWN: &str = "BC1 to BC5, BC7, ASTC without light beyond white, and one to four channels of 8 bits (R8 to R8G8B8A8) are supported";
    let Some(format) = header.format else {
        let text = format!("it is a KTX2 image of Basis Universal; {KNOWN}");
        return Err(Reason::unsupported(text));
    };
    let pixels = |channels: usize| Ok(TexelForm::Pixels { channels });
    Ok(TexelForm::Blocks(match format {
        Format::R8_UNORM | Format::R8_SRGB => return pixels(1),
        Format::R8G8_UNORM | Format::R8G8_SRGB => return pixels(2),
        Format::R8G8B8_UNORM | Format::R8G8B8_SRGB => return pixels(3),
        Format::R8G8B8A8_UNORM | Format::R8G8B8A8_SRGB => return pixels(4),
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
    }))
}

/// Refuses images that are not flat, whose rows do not start at the top, or whose channels are
/// swizzled.
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
