//! An image on the CPU.

/// An image on the CPU: rows from the top, four bytes per pixel, red first, sRGB.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RgbaImage {
    /// Width and height, in pixels.
    pub size: [u32; 2],
    /// The bytes.
    pub pixels: Vec<u8>,
}

#[cfg(feature = "png")]
impl RgbaImage {
    /// Writes a PNG file, if the image is complete.
    ///
    /// # Errors
    /// No pixels, or a number of pixels other than the size says; a file that cannot be written.
    pub fn save_png(&self, file: impl AsRef<std::path::Path>) -> std::io::Result<()> {
        let [width, height] = self.size;
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        writer.finish()?;
        let file = file.as_ref();
        std::fs::write(file, bytes).map_err(|error| {
            std::io::Error::new(
                error.kind(),
                format!("{} cannot be written: {error}", file.display()),
            )
        })
    }
}
