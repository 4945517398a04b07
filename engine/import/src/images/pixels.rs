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
        let pixels = DynamicImage::from_decoder(decoder).map(DynamicImage::into_rgba8);
        let pixels = pixels.map_err(|error| undecodable(&error))?;
        if <[u32; 2]>::from(pixels.dimensions()) != size {
            return Err(Reason::malformed("its size is not what its head says"));
        }
        Ok(pixels.into_raw())
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
