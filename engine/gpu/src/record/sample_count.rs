//! Samples per pixel of the engine's own targets.

use ash::vk;

use crate::core::error::Error;

/// The number of positions in a pixel with their own depth and colour.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum SampleCount {
    /// One sample, in the middle of the pixel.
    #[default]
    One,
    /// Four samples, whose colours are averaged in the finished image for smooth edges.
    Four,
}

impl SampleCount {
    /// Returns the number of samples.
    #[must_use]
    pub fn count(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Four => 4,
        }
    }

    /// Returns the Vulkan flag of this number of samples.
    #[must_use]
    pub fn flags(self) -> vk::SampleCountFlags {
        match self {
            Self::One => vk::SampleCountFlags::TYPE_1,
            Self::Four => vk::SampleCountFlags::TYPE_4,
        }
    }
}

impl TryFrom<u32> for SampleCount {
    type Error = Error;

    /// Returns the sample count with this number.
    ///
    /// # Errors
    /// [`Error::SampleCount`] for numbers other than 1 and 4.
    fn try_from(count: u32) -> Result<Self, Error> {
        match count {
            1 => Ok(Self::One),
            4 => Ok(Self::Four),
            wanted => Err(Error::SampleCount { wanted }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_has_one_or_four_samples() {
        for count in [SampleCount::One, SampleCount::Four] {
            assert_eq!(SampleCount::try_from(count.count()).unwrap(), count);
            assert_eq!(count.flags().as_raw(), count.count());
        }
        for wanted in [0, 2, 3, 5, 8, 16, u32::MAX] {
            let error = SampleCount::try_from(wanted).unwrap_err().to_string();
            assert!(error.contains(&wanted.to_string()) && error.contains("1 or 4"), "{error}");
        }
    }
}
