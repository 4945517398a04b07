//! Resampling of images on the CPU: for mip maps on devices that cannot create them, and for images
//! of a common size.

use ash::vk;

/// Returns the image `rgba8` (rows from the top, four bytes per pixel, `from` pixels) at the size
/// `to`. A smaller image takes the mean of the area that each pixel covers; a larger image is
/// interpolated linearly between pixel centres. Colours of an sRGB `format` are averaged as linear
/// light, other values unchanged. Returns an empty image if a size is 0 or `rgba8` has too few
/// bytes.
#[must_use]
pub fn resampled(rgba8: &[u8], from: [u32; 2], to: [u32; 2], format: vk::Format) -> Vec<u8> {
    let [from_width, from_height] = from.map(|side| side as usize);
    let [width, height] = to.map(|side| side as usize);
    let enough = from_width.checked_mul(from_height).and_then(|pixels| pixels.checked_mul(4));
    let source = enough.and_then(|bytes| rgba8.get(..bytes)).unwrap_or_default();
    if source.is_empty() || width == 0 || height == 0 {
        return Vec::new();
    }
    let decode = decoding(format);
    let across = spans(from_width, width);
    let down = spans(from_height, height);
    // Rows first, so that only rows of the new width are kept as numbers.
    let narrow = |row: &[u8]| -> Vec<[f32; 4]> {
        let pixels: Vec<[f32; 4]> =
            row.chunks_exact(4).map(|pixel| decoded(pixel, &decode)).collect();
        across.iter().map(|span| span.mean(&pixels)).collect()
    };
    let rows: Vec<Vec<[f32; 4]>> = source.chunks_exact(from_width * 4).map(narrow).collect();
    let mut result = Vec::with_capacity(width * height * 4);
    for span in &down {
        for column in 0..width {
            let mean = span.mean_of(|row| {
                rows.get(row).and_then(|row| row.get(column)).copied().unwrap_or_default()
            });
            result.extend(encoded(mean, format));
        }
    }
    result
}

/// The source elements of one result element, from `first` on, with their weights.
struct Span {
    first: usize,
    weights: Vec<f32>,
}

impl Span {
    fn mean(&self, elements: &[[f32; 4]]) -> [f32; 4] {
        self.mean_of(|place| elements.get(place).copied().unwrap_or_default())
    }

    fn mean_of(&self, element: impl Fn(usize) -> [f32; 4]) -> [f32; 4] {
        let mut sum = [0.0; 4];
        for (place, weight) in (self.first..).zip(&self.weights) {
            for (sum, part) in sum.iter_mut().zip(element(place)) {
                *sum += part * weight;
            }
        }
        sum
    }
}

/// Returns the span of each of `to` result elements over `from` source elements; neither may be 0.
fn spans(from: usize, to: usize) -> Vec<Span> {
    let scale = from as f32 / to as f32;
    let larger = |place: usize| {
        let centre = ((place as f32 + 0.5) * scale - 0.5).clamp(0.0, (from - 1) as f32);
        let first = (centre as usize).min(from.saturating_sub(2));
        let share = centre - first as f32;
        let weights = if from == 1 { vec![1.0] } else { vec![1.0 - share, share] };
        Span { first, weights }
    };
    let smaller = |place: usize| {
        let start = place as f32 * scale;
        let end = (place + 1) as f32 * scale;
        let first = (start as usize).min(from - 1);
        let last = (end.ceil() as usize).clamp(first + 1, from);
        let covered =
            |element: usize| ((element + 1) as f32).min(end) - (element as f32).max(start);
        let weights: Vec<f32> = (first..last).map(|element| covered(element).max(0.0)).collect();
        let sum: f32 = weights.iter().sum();
        Span { first, weights: weights.into_iter().map(|weight| weight / sum.max(1e-6)).collect() }
    };
    if to >= from { (0..to).map(larger).collect() } else { (0..to).map(smaller).collect() }
}

/// Returns the linear light of each byte of a colour.
fn decoding(format: vk::Format) -> [f32; 256] {
    std::array::from_fn(|byte| {
        let value = byte as f32 / 255.0;
        match format {
            vk::Format::R8G8B8A8_SRGB if value > 0.040_45 => ((value + 0.055) / 1.055).powf(2.4),
            vk::Format::R8G8B8A8_SRGB => value / 12.92,
            _ => value,
        }
    })
}

fn decoded(pixel: &[u8], decode: &[f32; 256]) -> [f32; 4] {
    let byte = |channel: usize| pixel.get(channel).copied().unwrap_or_default();
    let light = |channel| decode[usize::from(byte(channel))];
    [light(0), light(1), light(2), f32::from(byte(3)) / 255.0]
}

fn encoded(colour: [f32; 4], format: vk::Format) -> [u8; 4] {
    let [red, green, blue, alpha] = colour;
    let encode = |value: f32| match format {
        vk::Format::R8G8B8A8_SRGB if value > 0.003_130_8 => 1.055 * value.powf(1.0 / 2.4) - 0.055,
        vk::Format::R8G8B8A8_SRGB => value * 12.92,
        _ => value,
    };
    let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    [byte(encode(red)), byte(encode(green)), byte(encode(blue)), byte(alpha)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SRGB: vk::Format = vk::Format::R8G8B8A8_SRGB;
    const LINEAR: vk::Format = vk::Format::R8G8B8A8_UNORM;

    #[test]
    fn the_same_size_is_the_same_image() {
        let image: Vec<u8> = (0..=255).collect();
        for format in [SRGB, LINEAR] {
            assert_eq!(resampled(&image, [8, 8], [8, 8], format), image);
        }
    }

    #[test]
    fn colours_are_mixed_as_light_and_numbers_as_they_are() {
        let board = [[0, 0, 0, 0], [255; 4], [255; 4], [0, 0, 0, 0]].concat();
        assert_eq!(resampled(&board, [2, 2], [1, 1], SRGB), [188, 188, 188, 128]);
        assert_eq!(resampled(&board, [2, 2], [1, 1], LINEAR), [128; 4]);
    }

    #[test]
    fn odd_sizes_weigh_what_is_covered() {
        let row = [[0; 4], [90; 4], [240; 4]].concat();
        // One and a half pixels each.
        assert_eq!(resampled(&row, [3, 1], [2, 1], LINEAR)[0], 30);
        assert_eq!(resampled(&row, [3, 1], [2, 1], LINEAR)[4], 190);
        assert_eq!(resampled(&row, [3, 1], [1, 1], LINEAR)[0], 110);
    }

    #[test]
    fn larger_ones_are_interpolated() {
        let row = [[0; 4], [100; 4]].concat();
        let wide = resampled(&row, [2, 1], [4, 2], LINEAR);
        let first: Vec<u8> = wide.chunks_exact(4).map(|pixel| pixel[0]).collect();
        assert_eq!(first, [0, 25, 75, 100, 0, 25, 75, 100]);
        assert_eq!(resampled(&[7; 4], [1, 1], [3, 3], SRGB), [7; 36]);
    }

    #[test]
    fn what_is_not_there_is_empty() {
        assert_eq!(resampled(&[0; 12], [2, 2], [1, 1], LINEAR), []);
        assert_eq!(resampled(&[0; 16], [2, 2], [0, 1], LINEAR), []);
        assert_eq!(resampled(&[], [0, 0], [1, 1], LINEAR), []);
        assert_eq!(resampled(&[0; 16], [u32::MAX, u32::MAX], [1, 1], LINEAR), []);
    }
}
