//! Animations as PNG files (APNG), with one palette for all images.

use std::path::Path;

use crate::colour_palette::ColourHistogram;
use crate::options::FrameSize;
use crate::outputs::write_file;
use crate::png_file::PngError;

/// Images of one size that are shown in an endless loop.
pub struct AnimatedPng {
    size: FrameSize,
    images_per_second: u16,
    /// The pixels of each image, three bytes for each.
    images: Vec<Vec<u8>>,
    histogram: ColourHistogram,
}

impl AnimatedPng {
    /// Creates an animation without images.
    pub fn new(size: FrameSize, images_per_second: u16) -> Self {
        let histogram = ColourHistogram::default();
        Self { size, images_per_second, images: Vec::new(), histogram }
    }

    /// Adds an image: rows of RGBA pixels, sRGB-encoded, the top row first. Alpha is dropped.
    ///
    /// # Errors
    /// Bytes that do not match the size; no memory.
    pub fn push(&mut self, rgba8: &[u8]) -> Result<(), PngError> {
        let size = self.size;
        let pixels = u64::from(size.width) * u64::from(size.height);
        if pixels == 0 || u64::try_from(rgba8.len()).ok() != pixels.checked_mul(4) {
            return Err(PngError::WrongLength { size, bytes: rgba8.len() });
        }
        let bytes = rgba8.len() / 4 * 3;
        let mut rgb8 = Vec::new();
        rgb8.try_reserve_exact(bytes).map_err(|_| PngError::NoMemory { size, bytes })?;
        rgb8.extend(rgba8.as_chunks::<4>().0.iter().flat_map(|&[r, g, b, _]| [r, g, b]));
        self.histogram.add(&rgb8);
        self.images.push(rgb8);
        Ok(())
    }

    /// Returns the bytes of a file with the images that were added. The same images give the same
    /// bytes.
    ///
    /// # Errors
    /// No image; an error of the encoder.
    pub fn encode(&self) -> Result<Vec<u8>, PngError> {
        let FrameSize { width, height } = self.size;
        let palette = self.histogram.palette();
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_palette(palette.colours().as_flattened());
        encoder.set_compression(png::Compression::High);
        // Neighbouring palette indices are not similar, so a filter saves nothing.
        encoder.set_filter(png::Filter::NoFilter);
        encoder.set_animated(u32::try_from(self.images.len()).unwrap_or(u32::MAX), 0)?;
        encoder.set_frame_delay(1, self.images_per_second)?;
        let mut writer = encoder.write_header()?;
        for image in &self.images {
            let places: Vec<u8> = palette.places(image).collect();
            writer.write_image_data(&places)?;
        }
        writer.finish()?;
        Ok(file)
    }

    /// Writes the images that were added to a file, which is replaced whole.
    ///
    /// # Errors
    /// As [`AnimatedPng::encode`]; a file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), PngError> {
        Ok(write_file(path, &self.encode()?)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    const SIZE: FrameSize = FrameSize { width: 2, height: 2 };

    /// Returns the pixels of each image of a file.
    fn decoded(file: &[u8]) -> Vec<Vec<u8>> {
        let mut decoder = png::Decoder::new(Cursor::new(file));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let control = *reader.info().animation_control().unwrap();
        assert_eq!(control.num_plays, 0, "it never ends");
        let mut images = Vec::new();
        for _ in 0..control.num_frames {
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            let shown = reader.info().frame_control().unwrap();
            assert_eq!((shown.delay_num, shown.delay_den), (1, 14));
            images.push(pixels);
        }
        images
    }

    #[test]
    fn images_are_read_back_in_their_order() {
        let image = |colour: [u8; 4]| [[255, 255, 255, 255], colour, colour, [0; 4]].concat();
        let mut animation = AnimatedPng::new(SIZE, 14);
        let colours = [[255, 0, 0, 255], [0, 255, 0, 9], [0, 0, 255, 0]];
        for colour in colours {
            animation.push(&image(colour)).unwrap();
        }
        let file = animation.encode().unwrap();
        assert_eq!(file, animation.encode().unwrap(), "the same bytes");
        let expected = colours.map(|colour| {
            let rgba8 = image(colour);
            rgba8.chunks(4).flat_map(|pixel| &pixel[..3]).copied().collect::<Vec<u8>>()
        });
        assert_eq!(decoded(&file), expected);
    }

    #[test]
    fn what_is_no_animation_is_refused() {
        let mut animation = AnimatedPng::new(SIZE, 14);
        assert!(matches!(animation.encode(), Err(PngError::Encoding(_))), "no image");
        assert!(matches!(animation.push(&[0; 15]), Err(PngError::WrongLength { .. })));
        animation.push(&[0; 16]).unwrap();
        // There is no folder below a file.
        let nowhere = animation.write(&std::env::current_exe().unwrap().join("never-written.png"));
        assert!(matches!(nowhere, Err(PngError::Writing(_))));
    }
}
