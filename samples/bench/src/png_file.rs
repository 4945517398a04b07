//! Writes images as PNG files.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::options::FrameSize;
use crate::outputs::{WriteError, write_new};

/// An image that could not be written.
#[derive(Debug, Error)]
pub enum PngError {
    /// The bytes are not `width * height` pixels of four bytes.
    #[error("an image of {size} pixels needs 4 bytes for each, not {bytes} in all")]
    WrongLength {
        /// The expected size.
        size: FrameSize,
        /// The number of bytes.
        bytes: usize,
    },
    /// Too little memory for two more copies of the image.
    #[error("there is no memory for an image of {size} pixels as a PNG (about {} MiB)", bytes >> 20)]
    NoMemory {
        /// The size.
        size: FrameSize,
        /// The number of bytes that were asked for.
        bytes: usize,
    },
    /// An error of the encoder.
    #[error("cannot encode an image: {0}")]
    Encoding(#[from] png::EncodingError),
    /// An error of the file system.
    #[error(transparent)]
    Writing(#[from] WriteError),
}

/// Writes rows of RGBA pixels, sRGB-encoded, the top row first, as a PNG. Alpha is dropped: frames
/// are opaque. An existing file is never replaced: returns the path that was [free](write_new).
///
/// # Errors
/// When the bytes do not match the size, or the file cannot be written.
pub fn write_png(path: &Path, size: FrameSize, rgba8: &[u8]) -> Result<PathBuf, PngError> {
    let pixels = u64::from(size.width) * u64::from(size.height);
    if pixels == 0 || u64::try_from(rgba8.len()).ok() != pixels.checked_mul(4) {
        return Err(PngError::WrongLength { size, bytes: rgba8.len() });
    }
    let bytes = rgba8.len() / 4 * 3;
    let mut rgb8: Vec<u8> = Vec::new();
    // The compressed image is hardly ever larger.
    let mut file: Vec<u8> = Vec::new();
    let reserved = rgb8.try_reserve_exact(bytes).and_then(|()| file.try_reserve(bytes));
    reserved.map_err(|_| PngError::NoMemory { size, bytes: 2 * bytes })?;
    rgb8.extend(rgba8.as_chunks::<4>().0.iter().flat_map(|&[r, g, b, _]| [r, g, b]));
    let mut encoder = png::Encoder::new(&mut file, size.width, size.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb8)?;
    writer.finish()?;
    Ok(write_new(path, &file)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::BufReader;

    #[test]
    fn what_was_written_is_read_back() {
        let path = std::env::temp_dir().join(format!("antumbra-{}.png", std::process::id()));
        let size = FrameSize { width: 3, height: 2 };
        let rgba8: Vec<u8> = (0..24).map(|byte| byte * 10).collect();
        write_png(&path, size, &rgba8).unwrap();

        let file = BufReader::new(std::fs::File::open(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut pixels).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!((frame.width, frame.height, frame.color_type), (3, 2, png::ColorType::Rgb));
        let expected: Vec<u8> = rgba8.chunks(4).flat_map(|pixel| &pixel[..3]).copied().collect();
        assert_eq!(pixels, expected);
    }

    #[test]
    fn bytes_that_do_not_match_the_size_are_refused() {
        // There is no folder below a file.
        let path = &std::env::current_exe().unwrap().join("never-written.png");
        for (width, height, bytes) in [(2, 2, 15), (2, 2, 17), (0, 5, 0), (u32::MAX, u32::MAX, 16)]
        {
            let refused = write_png(path, FrameSize { width, height }, &vec![0; bytes]);
            assert!(matches!(refused, Err(PngError::WrongLength { .. })));
        }
        let refused = write_png(path, FrameSize { width: 1, height: 1 }, &[0; 4]);
        assert!(matches!(refused, Err(PngError::Writing(_))));
    }
}
