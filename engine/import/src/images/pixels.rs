//! Images of pixels: PNG, JPEG and WebP.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use super::{ImageHead, jpeg};
use crate::Limits;
use crate::error::Reason;

/// An encoded image of pixels.
pub(super) struct EncodedPixels {
    format: ImageFormat,
    /// True for a JPEG without an end marker.
    lacks_end: bool,
}

impl EncodedPixels {
    /// Reads the header of an image.
    pub(super) fn read(encoded: &[u8], limits: &Limits) -> Result<(ImageHead, Self), Reason> {
        let format = match image::guess_format(encoded) {
            Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) => format,
            _ => return Err(Reason::unsupported("it is not a PNG, JPEG, WebP or KTX2 image")),
        };
        let (size, raw_bytes) = {
            let decoder = decoder(encoded, format, limits)?;
            (decoder.dimensions().into(), decoder.total_bytes())
        };
        let jpeg = (format == ImageFormat::Jpeg).then(|| jpeg::inspect(encoded));
        let copies = match (format, jpeg) {
            // Coefficients of 16 bits for the whole image.
            (_, Some(jpeg)) if jpeg.is_progressive => 4,
            (ImageFormat::Png, _) => 1,
            _ => 2,
        };
        let lacks_end = jpeg.is_some_and(|jpeg| !jpeg.has_end);
        let [width, height]: [u32; 2] = size;
        let bytes = u64::from(width).saturating_mul(u64::from(height)).saturating_mul(4);
        let encoded_bytes = encoded.len() as u64;
        let more_bytes = if lacks_end { bytes.saturating_add(encoded_bytes) } else { 0 };
        let scratch_bytes = raw_bytes.saturating_mul(copies).saturating_add(encoded_bytes);
        let scratch_bytes = scratch_bytes.saturating_add(more_bytes);
        Ok((ImageHead { size, bytes, scratch_bytes }, Self { format, lacks_end }))
    }

    /// Decodes the image to four bytes per pixel.
    pub(super) fn decode(
        &self,
        encoded: &[u8],
        size: [u32; 2],
        limits: &Limits,
    ) -> Result<Vec<u8>, Reason> {
        if !self.lacks_end {
            return self.pixels(encoded, size, limits);
        }
        // The decoder fills up missing data without a warning. In a complete file, bytes after the
        // end do not matter.
        let [one, other] = jpeg::endings(encoded);
        let pixels = self.pixels(&one, size, limits)?;
        drop(one);
        if self.pixels(&other, size, limits).as_ref() == Ok(&pixels) {
            return Ok(pixels);
        }
        Err(Reason::damaged("it is a JPEG that is cut off"))
    }

    fn pixels(&self, encoded: &[u8], size: [u32; 2], limits: &Limits) -> Result<Vec<u8>, Reason> {
        let decoder = decoder(encoded, self.format, limits)?;
        if <[u32; 2]>::from(decoder.dimensions()) != size {
            return Err(Reason::malformed("its size is not what its head says"));
        }
        let colour = decoder.color_type();
        let channels = colour.channel_count();
        if colour.bytes_per_pixel() > channels {
            let pixels =
                DynamicImage::from_decoder(decoder).map_err(|error| undecodable(&error))?;
            return Ok(pixels.into_rgba8().into_raw());
        }
        let bytes = size.into_iter().map(u64::from).product::<u64>().saturating_mul(4);
        let count = usize::try_from(bytes).map_err(|_| Reason::no_memory(bytes))?;
        let mut pixels = vec![0; count];
        // The decoded pixels fill the end of the result and are widened in place, which saves a
        // copy of the image.
        let start = count / 4 * usize::from(4 - channels);
        let decoded = pixels.get_mut(start..).unwrap_or_default();
        decoder.read_image(decoded).map_err(|error| undecodable(&error))?;
        match channels {
            1 => widen(&mut pixels, |grey: [u8; 1]| [grey[0], grey[0], grey[0], u8::MAX]),
            2 => widen(&mut pixels, |grey: [u8; 2]| [grey[0], grey[0], grey[0], grey[1]]),
            3 => widen(&mut pixels, |rgb: [u8; 3]| [rgb[0], rgb[1], rgb[2], u8::MAX]),
            _ => {}
        }
        Ok(pixels)
    }
}

/// Widens pixels of `N` bytes at the end of a list to four bytes, which fill it. Blocks are copied
/// first, and no later pixel is overwritten: the wide pixels end before the next one to read.
fn widen<const N: usize>(pixels: &mut [u8], to_rgba: impl Fn([u8; N]) -> [u8; 4]) {
    const BLOCK: usize = 256;
    let mut block = [[0; N]; BLOCK];
    let count = pixels.len() / 4;
    for start in (0..count).step_by(BLOCK) {
        let end = count.min(start + BLOCK);
        let given = &pixels[count * (4 - N) + start * N..count * (4 - N) + end * N];
        block.as_flattened_mut()[..given.len()].copy_from_slice(given);
        let wide = pixels[start * 4..end * 4].as_chunks_mut().0;
        wide.iter_mut().zip(block).for_each(|(rgba, pixel)| *rgba = to_rgba(pixel));
    }
}

fn decoder<'a>(
    encoded: &'a [u8],
    format: ImageFormat,
    limits: &Limits,
) -> Result<impl ImageDecoder + 'a, Reason> {
    let mut reader = ImageReader::with_format(Cursor::new(encoded), format);
    let mut memory = image::Limits::no_limits();
    memory.max_alloc = Some(limits.image_scratch_bytes);
    reader.limits(memory);
    reader.into_decoder().map_err(|error| undecodable(&error))
}

fn undecodable(error: &image::ImageError) -> Reason {
    let said = error.to_string();
    let text = format!("it cannot be decoded: {}", said.trim());
    match error {
        image::ImageError::Limits(_) => Reason::beyond_limits(text),
        _ => Reason::damaged(text),
    }
}

#[cfg(test)]
mod tests {
    use image::{DynamicImage, ImageBuffer};

    use super::*;

    #[test]
    fn pixels_of_any_channels_become_those_that_the_decoder_would_make() {
        let size = [50, 11];
        let bytes: Vec<u8> = (0..size[0] * size[1] * 8).map(|byte| (byte * 37) as u8).collect();
        let wide: Vec<u16> = bytes.iter().map(|&byte| u16::from(byte) * 251).collect();
        let count = |channels: usize| (size[0] * size[1]) as usize * channels;
        let [width, height] = size;
        let images = [
            ImageBuffer::from_raw(width, height, bytes[..count(1)].to_vec())
                .map(DynamicImage::ImageLuma8),
            ImageBuffer::from_raw(width, height, bytes[..count(2)].to_vec())
                .map(DynamicImage::ImageLumaA8),
            ImageBuffer::from_raw(width, height, bytes[..count(3)].to_vec())
                .map(DynamicImage::ImageRgb8),
            ImageBuffer::from_raw(width, height, bytes[..count(4)].to_vec())
                .map(DynamicImage::ImageRgba8),
            ImageBuffer::from_raw(width, height, wide[..count(3)].to_vec())
                .map(DynamicImage::ImageRgb16),
        ];
        for image in images {
            let image = image.expect("as many bytes as pixels");
            let mut png = Cursor::new(Vec::new());
            image.write_to(&mut png, ImageFormat::Png).expect("a PNG");
            let png = png.into_inner();
            let (_, encoded) = EncodedPixels::read(&png, &Limits::default()).expect("a header");
            let pixels = encoded.decode(&png, size, &Limits::default());
            assert_eq!(pixels, Ok(image.to_rgba8().into_raw()), "{:?}", image.color());
        }
    }
}
