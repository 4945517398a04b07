//! Textures that a renderer takes while it runs.

use super::error::SceneError;
use super::surface::{Encoding, Image, Sampler};

/// An image that was checked, with the meaning of its bytes and its sampler.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedTexture {
    image: Image,
    encoding: Encoding,
    sampler: Sampler,
}

impl PreparedTexture {
    /// Checks an image.
    ///
    /// # Errors
    /// [`SceneError::BrokenSurfaces`] for one without pixels, or with another number of bytes than
    /// its size says.
    pub fn new(image: Image, encoding: Encoding, sampler: Sampler) -> Result<Self, SceneError> {
        let pixels = image.size.map(u64::from).iter().product::<u64>();
        if pixels == 0 || pixels.checked_mul(4) != Some(image.rgba8.len() as u64) {
            let fault = "it has not four bytes for each pixel of its size, or no pixels";
            return Err(SceneError::BrokenSurfaces { part: "image", index: 0, fault });
        }
        Ok(Self { image, encoding, sampler })
    }

    /// Returns the image.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// Returns the meaning of its bytes.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Returns its sampling.
    pub fn sampler(&self) -> Sampler {
        self.sampler
    }
}
