//! Textures that a renderer can add while it runs.

use super::error::SceneError;
use super::image::{Image, Texels};
use super::surface::{Encoding, Sampler};

/// A checked image with the meaning of its bytes and its sampler.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedTexture {
    image: Image,
    encoding: Encoding,
    sampler: Sampler,
}

impl PreparedTexture {
    /// Checks an image. Mip maps that the sampler does not use are left out.
    ///
    /// # Errors
    /// [`SceneError::BrokenSurfaces`] for an image without pixels, or with a number of bytes that
    /// does not match its size.
    pub fn new(mut image: Image, encoding: Encoding, sampler: Sampler) -> Result<Self, SceneError> {
        let broken = |fault| SceneError::BrokenSurfaces { part: "image", index: 0, fault };
        image.check().map_err(broken)?;
        if let (Texels::Blocks { levels, .. }, None) = (&mut image.texels, sampler.between_levels) {
            levels.truncate(1);
        }
        Ok(Self { image, encoding, sampler })
    }

    /// Returns the image.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// Returns the texture with four bytes per texel.
    #[must_use]
    pub fn unpacked(self) -> Self {
        Self { image: self.image.unpacked(), ..self }
    }

    /// Returns the meaning of the image's bytes.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Returns the sampler.
    pub fn sampler(&self) -> Sampler {
        self.sampler
    }
}
