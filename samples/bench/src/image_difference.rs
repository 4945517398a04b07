//! The difference of images that need not be the same: its mean and its maximum.

use crate::statistics::kept;

/// The difference of the channels of some pairs of images.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImageDifference {
    channels: u64,
    sum: u64,
    most: u8,
}

impl ImageDifference {
    /// Adds a pair of images of four bytes per pixel, the last of which is not compared.
    pub fn add(&mut self, a: &[u8], b: &[u8]) {
        for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
            for (a, b) in a.iter().zip(b).take(3) {
                let difference = a.abs_diff(*b);
                self.channels += 1;
                self.sum += u64::from(difference);
                self.most = self.most.max(difference);
            }
        }
    }

    /// Returns the mean, of 255; `None` without images.
    pub fn mean(&self) -> Option<f64> {
        (self.channels > 0).then(|| kept(self.sum as f64 / self.channels as f64))
    }

    /// Returns the maximum, of 255; `None` without images.
    pub fn most(&self) -> Option<u64> {
        (self.channels > 0).then(|| self.most.into())
    }
}

/// Returns the number of pixels of two images of the same size that are not the same bits; all,
/// if the sizes differ.
pub fn pixels_that_differ(reference: &[u8], image: &[u8]) -> u64 {
    let expected = reference.chunks_exact(4);
    let found = image.chunks_exact(4);
    if reference.len() != image.len() || image.is_empty() {
        return expected.len().max(found.len()).max(1) as u64;
    }
    expected.zip(found).filter(|(a, b)| a != b).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_maximum_are_of_the_colours() {
        let mut difference = ImageDifference::default();
        assert_eq!((difference.mean(), difference.most()), (None, None));
        difference.add(&[10, 20, 30, 255, 0, 0, 0, 0], &[10, 26, 27, 0, 0, 0, 0, 255]);
        assert_eq!((difference.mean(), difference.most()), (Some(1.5), Some(6)));
        difference.add(&[0, 0, 0, 0], &[0, 0, 0, 0]);
        assert_eq!((difference.mean(), difference.most()), (Some(1.0), Some(6)));
    }

    #[test]
    fn pixels_are_counted_once_each() {
        let image = [1, 2, 3, 255, 4, 5, 6, 255];
        assert_eq!(pixels_that_differ(&image, &image), 0);
        assert_eq!(pixels_that_differ(&image, &[1, 2, 3, 255, 9, 9, 9, 255]), 1);
        assert_eq!(pixels_that_differ(&[], &[]), 1, "nothing compared is no proof");
        assert_eq!(pixels_that_differ(&image, &image[..4]), 2);
    }
}
