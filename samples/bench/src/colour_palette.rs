//! Colours for images with a palette: boxes of colours are cut at the mean of the channel with the
//! largest squared error, then k-means (Lloyd) moves each colour to the mean of its pixels.

use antumbra::glam::DVec3;

/// The most colours of a palette.
pub const MAX_COLOURS: usize = 256;

/// The bits per channel by which colours are distinguished.
const BITS: u32 = 6;
/// The number of rounds in which the colours of a palette move.
const ROUNDS: usize = 4;

/// The number of pixels of each colour, in one image or several.
pub struct ColourHistogram {
    counts: Vec<u32>,
}

impl Default for ColourHistogram {
    fn default() -> Self {
        Self { counts: vec![0; 1 << (3 * BITS)] }
    }
}

/// A colour of a histogram.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Its number in the histogram.
    bin: u32,
    colour: DVec3,
    weight: f64,
}

/// At most [`MAX_COLOURS`] colours, and the nearest of them for each colour of a histogram.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColourPalette {
    colours: Vec<[u8; 3]>,
    /// The index of the nearest colour, by the number of a colour in the histogram.
    places: Vec<u8>,
}

impl ColourHistogram {
    /// Adds pixels of three bytes.
    pub fn add(&mut self, rgb8: &[u8]) {
        for pixel in rgb8.as_chunks::<3>().0 {
            if let Some(count) = self.counts.get_mut(bin_of(*pixel) as usize) {
                *count = count.saturating_add(1);
            }
        }
    }

    /// Returns the colours that have pixels, in the order of their numbers. A colour is weighted by
    /// the square root of its number of pixels, so that small things keep their colours.
    fn samples(&self) -> Vec<Sample> {
        let found = (0..).zip(&self.counts).filter(|(_, count)| **count > 0);
        let sample = |(bin, count): (u32, &u32)| {
            let weight = f64::from(*count).sqrt();
            Sample { bin, colour: middle_of(bin), weight }
        };
        found.map(sample).collect()
    }

    /// Returns a palette for the pixels that were added.
    pub fn palette(&self) -> ColourPalette {
        let mut samples = self.samples();
        let mut centres = cut(&mut samples);
        for _ in 0..ROUNDS {
            move_to_means(&mut centres, &samples);
        }
        let mut colours: Vec<[u8; 3]> = centres.into_iter().map(rounded).collect();
        colours.sort_unstable();
        colours.dedup();
        let fixed: Vec<DVec3> = colours.iter().map(|colour| colour.map(f64::from).into()).collect();
        let mut places = vec![0; self.counts.len()];
        for sample in &samples {
            if let Some(place) = places.get_mut(sample.bin as usize) {
                *place = nearest(&fixed, sample.colour) as u8;
            }
        }
        ColourPalette { colours, places }
    }
}

impl ColourPalette {
    /// Returns the colours.
    pub fn colours(&self) -> &[[u8; 3]] {
        &self.colours
    }

    /// Returns the index of the colour of each pixel, three bytes each. The palette was made for
    /// these pixels, possibly among others.
    pub fn places<'a>(&'a self, rgb8: &'a [u8]) -> impl Iterator<Item = u8> + 'a {
        let place = |pixel: &[u8; 3]| self.places.get(bin_of(*pixel) as usize).copied();
        rgb8.as_chunks::<3>().0.iter().map(move |pixel| place(pixel).unwrap_or_default())
    }
}

/// Returns the number of a colour in a histogram.
fn bin_of(pixel: [u8; 3]) -> u32 {
    pixel.into_iter().fold(0, |bin, part| (bin << BITS) | u32::from(part) >> (8 - BITS))
}

/// Returns the colour of a number in a histogram. Black and white are exact.
fn middle_of(bin: u32) -> DVec3 {
    let most = (1 << BITS) - 1;
    let part = |number: u32| f64::from((bin >> (number * BITS)) & most) * 255.0 / f64::from(most);
    DVec3::new(part(2), part(1), part(0))
}

fn rounded(colour: DVec3) -> [u8; 3] {
    colour.to_array().map(|part| part.round() as u8)
}

/// Returns the index of the nearest colour; of equally near ones, the first.
fn nearest(colours: &[DVec3], colour: DVec3) -> usize {
    let distances = colours.iter().map(|other| other.distance_squared(colour));
    let nearest = distances.enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b));
    nearest.map_or(0, |(place, _)| place)
}

/// A part of the samples.
struct Part {
    first: usize,
    end: usize,
    mean: DVec3,
    /// The sum of the squared distances from the mean, by channel.
    errors: DVec3,
}

impl Part {
    fn of(samples: &[Sample], first: usize, end: usize) -> Self {
        let own = samples.get(first..end).unwrap_or_default();
        let mean = mean(own);
        let error = |sample: &Sample| {
            let aside = sample.colour - mean;
            aside * aside * sample.weight
        };
        let errors = own.iter().map(error).sum();
        Self { first, end, mean, errors }
    }

    fn error(&self) -> f64 {
        self.errors.element_sum()
    }

    /// Returns the two parts on both sides of the mean of the channel that varies most.
    fn halves(&self, samples: &mut [Sample]) -> [Self; 2] {
        let widest = self.errors.max_position();
        let limit = self.mean[widest];
        let own = samples.get_mut(self.first..self.end).unwrap_or_default();
        own.sort_by(|a, b| a.colour[widest].total_cmp(&b.colour[widest]).then(a.bin.cmp(&b.bin)));
        let low = own.partition_point(|sample| sample.colour[widest] <= limit);
        let middle = self.first + low.clamp(1, own.len().saturating_sub(1).max(1));
        [Self::of(samples, self.first, middle), Self::of(samples, middle, self.end)]
    }
}

fn mean(samples: &[Sample]) -> DVec3 {
    let weight: f64 = samples.iter().map(|sample| sample.weight).sum();
    let sum: DVec3 = samples.iter().map(|sample| sample.colour * sample.weight).sum();
    if weight > 0.0 { sum / weight } else { DVec3::ZERO }
}

/// Cuts the samples into parts, always the one with the largest error; returns their means.
fn cut(samples: &mut [Sample]) -> Vec<DVec3> {
    let mut parts = vec![Part::of(samples, 0, samples.len())];
    while parts.len() < MAX_COLOURS {
        let can_be_cut = |part: &&Part| part.end - part.first > 1;
        let errors = parts.iter().enumerate().filter(|(_, part)| can_be_cut(part));
        let worst = errors.max_by(|(_, a), (_, b)| a.error().total_cmp(&b.error()));
        let Some((at, worst)) = worst else { break };
        let [low, high] = worst.halves(samples);
        parts[at] = low;
        parts.push(high);
    }
    parts.into_iter().map(|part| part.mean).collect()
}

/// Moves each colour to the mean of the samples that are nearest to it.
fn move_to_means(centres: &mut [DVec3], samples: &[Sample]) {
    let mut own: Vec<Vec<Sample>> = vec![Vec::new(); centres.len()];
    for sample in samples {
        own[nearest(centres, sample.colour)].push(*sample);
    }
    for (centre, own) in centres.iter_mut().zip(own).filter(|(_, own)| !own.is_empty()) {
        *centre = mean(&own);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn palette_of(rgb8: &[u8]) -> ColourPalette {
        let mut histogram = ColourHistogram::default();
        histogram.add(rgb8);
        histogram.palette()
    }

    /// Returns the pixels with the colours of the palette.
    fn seen(palette: &ColourPalette, rgb8: &[u8]) -> Vec<[u8; 3]> {
        palette.places(rgb8).map(|place| palette.colours()[usize::from(place)]).collect()
    }

    #[test]
    fn few_colours_are_kept_however_few_pixels_have_them() {
        let colours = [[0, 0, 0], [255, 255, 255], [255, 0, 0], [0, 130, 0], [0, 0, 65]];
        let mut pixels = colours.as_flattened().to_vec();
        pixels.extend([255, 255, 255].repeat(100_000));
        let palette = palette_of(&pixels);
        assert_eq!(palette.colours().len(), colours.len());
        for (seen, colour) in seen(&palette, &pixels).into_iter().zip(colours) {
            let far = seen.into_iter().zip(colour).map(|(a, b)| a.abs_diff(b)).max();
            assert!(far <= Some(2), "{colour:?} is seen as {seen:?}");
        }
    }

    #[test]
    fn many_colours_are_seen_as_near_ones() {
        // A cube of 32,768 colours.
        let steps = || (0..32_u8).map(|step| step * 8);
        let pixels: Vec<u8> = steps()
            .flat_map(|r| steps().flat_map(move |g| steps().flat_map(move |b| [r, g, b])))
            .collect();
        let palette = palette_of(&pixels);
        assert_eq!(palette.colours().len(), MAX_COLOURS);
        let seen = seen(&palette, &pixels);
        let far = |(seen, colour): (&[u8; 3], &[u8; 3])| {
            DVec3::from(seen.map(f64::from)).distance(colour.map(f64::from).into())
        };
        let far: Vec<f64> = seen.iter().zip(pixels.as_chunks::<3>().0).map(far).collect();
        // Cut into 256 equal cubes, cells would have a side of 40: their corners would be 35 from
        // their middles, and their points 19.2 on average. Ours may be a tenth worse.
        let most = far.iter().copied().fold(0.0, f64::max);
        let mean = far.iter().sum::<f64>() / far.len() as f64;
        assert!(most < 45.0 && mean < 21.2, "{most}, {mean}");
    }

    #[test]
    fn nothing_has_a_palette_too() {
        assert_eq!(palette_of(&[]).colours(), [[0, 0, 0]]);
    }

    #[test]
    fn the_same_pixels_have_the_same_palette() {
        let pixels: Vec<u8> = (0..30_000_u32).map(|at| (at * at % 251) as u8).collect();
        assert_eq!(palette_of(&pixels), palette_of(&pixels));
    }
}
