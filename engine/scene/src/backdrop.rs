//! Backdrops of the light from all around: a computed sky or a panorama, and the disk of a sun or
//! moon.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3, vec2, vec3};

use crate::error::SceneError;
use crate::limits::MAX_PANORAMA_TEXELS;

/// The highest radiance that is stored: it fits 16 bits.
pub(crate) const BRIGHTEST: f32 = 60_000.0;

/// The picture that is seen where nothing is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Backdrop {
    /// A sky, computed for each pixel.
    Sky(Sky),
    /// A picture of all directions.
    Panorama(Panorama),
}

/// The disk of a sun or moon in the sky. The disk is visible but lights nothing: lights do that,
/// and a texel of the environment would be far larger than the disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyDisk {
    /// Unit vector towards the middle of the disk.
    pub towards: Vec3,
    /// Half of the angle that the disk covers, in radians, above 0 and below 0.5; 0.0047 for the
    /// sun.
    pub radius_rad: f32,
    /// The radiance of the disk, added to the sky's.
    pub radiance: [f32; 3],
}

/// A clear or hazy sky over a ground. All colours are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Unit vector towards the sun.
    pub towards_sun: Vec3,
    /// The colour straight above.
    pub zenith: [f32; 3],
    /// The colour at the horizon.
    pub horizon: [f32; 3],
    /// The colour of the ground, as it is lit.
    pub ground: [f32; 3],
    /// The light around the sun, added to the sky. The sun itself is a light of the scene.
    pub glow: [f32; 3],
}

impl Sky {
    /// Returns the radiance from a direction, a unit vector.
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let [zenith, horizon, ground, glow] =
            [self.zenith, self.horizon, self.ground, self.glow].map(Vec3::from_array);
        let height = 1.0 - squared(1.0 - direction.y.max(0.0), 2);
        let near = direction.dot(self.towards_sun).max(0.0);
        let above =
            horizon.lerp(zenith, height) + glow * (0.6 * squared(near, 3) + squared(near, 6));
        // Haze hides the ground towards the horizon, so that there is no edge.
        let towards_horizon = 1.0 + direction.y.min(0.0);
        ground.lerp(above, squared(towards_horizon, 2) * towards_horizon)
    }
}

/// Squares a number so many times. `powi` rounds differently on some systems.
fn squared(number: f32, times: u32) -> f32 {
    (0..times).fold(number, |power, _| power * power)
}

/// An equirectangular picture of all directions, with its mip maps: each level has half of the size
/// of the one before it, rounded down and at least 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Panorama {
    size: [u32; 2],
    levels: Vec<Vec<u32>>,
}

impl Panorama {
    /// Creates a panorama of linear radiance, in the layout of [`Environment::of_equirectangular`].
    ///
    /// [`Environment::of_equirectangular`]: crate::Environment::of_equirectangular
    ///
    /// # Errors
    /// [`SceneError::BrokenEnvironment`] for a size of 0, for a number of pixels that does not
    /// match the size, and for a value that is not finite.
    pub fn new(size: [u32; 2], pixels: &[[f32; 3]]) -> Result<Self, SceneError> {
        Self::of_at_most(MAX_PANORAMA_TEXELS, size, pixels)
    }

    fn of_at_most(
        most_texels: u64,
        size: [u32; 2],
        pixels: &[[f32; 3]],
    ) -> Result<Self, SceneError> {
        if texels_of(size) == 0 || pixels.len() as u64 != texels_of(size) {
            let fault = "its number of pixels is not that of its size";
            return Err(SceneError::BrokenEnvironment { fault });
        }
        if pixels.iter().flatten().any(|part| !part.is_finite()) {
            let fault = "one of its values is not finite";
            return Err(SceneError::BrokenEnvironment { fault });
        }
        let mut of_level = size;
        let mut halved = Vec::new();
        while texels_of(of_level) > most_texels {
            halved = half_of(of_level, if halved.is_empty() { pixels } else { &halved });
            of_level = half_size(of_level);
        }
        let mut panorama = Self { size: of_level, levels: Vec::new() };
        let packed =
            |level: &[[f32; 3]]| level.iter().map(|pixel| shared_exponent(*pixel)).collect();
        panorama.levels.push(packed(if halved.is_empty() { pixels } else { &halved }));
        while of_level != [1; 2] {
            halved = half_of(of_level, if halved.is_empty() { pixels } else { &halved });
            of_level = half_size(of_level);
            panorama.levels.push(packed(&halved));
        }
        Ok(panorama)
    }

    /// Returns the directions of the middles of the pixels of a picture, row by row.
    pub(crate) fn directions(size: [u32; 2]) -> impl Iterator<Item = Vec3> {
        let [width, height] = size;
        (0..height).flat_map(move |y| {
            (0..width).map(move |x| {
                let along = ((x as f32 + 0.5) / width as f32 - 0.5) * TAU;
                let from_top = (y as f32 + 0.5) / height as f32 * PI;
                let across = from_top.sin();
                vec3(across * along.sin(), from_top.cos(), -across * along.cos())
            })
        })
    }

    /// Returns the size in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the texels of each level, the largest level first, in rows from the top. A texel has
    /// the layout of Vulkan's `E5B9G9R9_UFLOAT_PACK32`: three numbers of nine bits, red in the
    /// lowest bits, with a shared exponent of five bits.
    #[must_use]
    pub fn levels(&self) -> &[Vec<u32>] {
        &self.levels
    }

    /// Returns the radiance from a direction, a unit vector: a mix of the four nearest pixels.
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let [width, height] = self.size.map(i64::from);
        let texels = self.levels.first().map(Vec::as_slice).unwrap_or_default();
        let at = |x: i64, y: i64| {
            let place = y.clamp(0, height - 1) * width + x.rem_euclid(width);
            texels.get(place as usize).copied().map_or(Vec3::ZERO, of_shared_exponent)
        };
        let across = 0.5 + direction.x.atan2(-direction.z) / TAU;
        let down = direction.y.clamp(-1.0, 1.0).acos() / PI;
        let place = vec2(across, down) * Vec2::from(self.size.map(|side| side as f32)) - 0.5;
        let low = place.floor();
        let share = place - low;
        let row = |y: i64| at(low.x as i64, y).lerp(at(low.x as i64 + 1, y), share.x);
        row(low.y as i64).lerp(row(low.y as i64 + 1), share.y)
    }
}

fn texels_of(size: [u32; 2]) -> u64 {
    let [width, height] = size;
    u64::from(width) * u64::from(height)
}

fn half_size(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| (side / 2).max(1))
}

/// Returns the next level of a picture. Each texel is the mean of all pixels that it touches, so
/// that pictures of an odd size do not shift.
fn half_of(size: [u32; 2], pixels: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let [width, height] = half_size(size);
    let touched = |place: u32, of: u32, from: u32| {
        let [first, end] = [place, place + 1].map(|edge| u64::from(edge) * u64::from(from));
        first / u64::from(of)..end.div_ceil(u64::from(of))
    };
    let mut halved = Vec::with_capacity(texels_of([width, height]) as usize);
    for y in 0..height {
        for x in 0..width {
            let mut sum = Vec3::ZERO;
            let mut count = 0.0;
            for row in touched(y, height, size[1]) {
                for column in touched(x, width, size[0]) {
                    let place = row * u64::from(size[0]) + column;
                    let pixel = pixels.get(place as usize).copied().unwrap_or_default();
                    sum += Vec3::from_array(pixel).clamp(Vec3::ZERO, Vec3::splat(BRIGHTEST));
                    count += 1.0;
                }
            }
            halved.push((sum / f32::max(count, 1.0)).to_array());
        }
    }
    halved
}

/// The bits of each number that shares an exponent.
const MANTISSA_BITS: i32 = 9;

/// The exponent whose bits are 0.
const EXPONENT_BIAS: i32 = 15;

/// Returns a radiance in 32 bits, clamped to the range of the format (Vulkan, "RGB to Shared
/// Exponent Conversion").
fn shared_exponent(radiance: [f32; 3]) -> u32 {
    let parts = radiance.map(|part| part.clamp(0.0, BRIGHTEST));
    let largest = parts.into_iter().fold(0.0, f32::max);
    let whole_log = (largest.to_bits() >> 23) as i32 - 127;
    let exponent = whole_log.max(-EXPONENT_BIAS - 1) + 1 + EXPONENT_BIAS;
    let scaled = |exponent: i32, part: f32| {
        let unit = 2.0_f32.powi(exponent - EXPONENT_BIAS - MANTISSA_BITS);
        (part / unit + 0.5).floor() as u32
    };
    let is_rounded_up = scaled(exponent, largest) == 1 << MANTISSA_BITS;
    let exponent = exponent + i32::from(is_rounded_up);
    let [red, green, blue] = parts.map(|part| scaled(exponent, part));
    red | green << 9 | blue << 18 | (exponent as u32) << 27
}

fn of_shared_exponent(packed: u32) -> Vec3 {
    let exponent = (packed >> 27) as i32 - EXPONENT_BIAS - MANTISSA_BITS;
    let parts = [packed, packed >> 9, packed >> 18].map(|part| (part & 511) as f32);
    Vec3::from_array(parts) * 2.0_f32.powi(exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radiances_are_found_again_in_32_bits() {
        for radiance in [[0.0; 3], [1.0, 0.5, 0.25], [0.999, 0.3, 1e-3], [511.9, 1.0, 300.0]] {
            let found = of_shared_exponent(shared_exponent(radiance));
            let off = (found - Vec3::from_array(radiance)).abs().max_element();
            let largest = radiance.into_iter().fold(0.0, f32::max);
            assert!(off <= largest / 511.0, "{radiance:?} became {found}");
        }
        let found = of_shared_exponent(shared_exponent([1e9, -1.0, f32::MIN_POSITIVE]));
        assert_eq!(found, vec3(60_032.0, 0.0, 0.0), "the nearest to the brightest that is held");
        // Vulkan's formula for one: 256 times 2 to the power of 16 - 15 - 9.
        assert_eq!(shared_exponent([1.0, 0.0, 0.0]), 256 | 16 << 27);
    }

    #[test]
    fn levels_are_means_of_halves() {
        let pixels: Vec<[f32; 3]> = (0..15).map(|pixel| [pixel as f32, 8.0, 0.0]).collect();
        let panorama = Panorama::new([5, 3], &pixels).expect("numbers");
        let lengths: Vec<usize> = panorama.levels().iter().map(Vec::len).collect();
        assert_eq!(lengths, [15, 2, 1]);
        let last = of_shared_exponent(panorama.levels()[2][0]);
        assert!((last - vec3(7.0, 8.0, 0.0)).length() < 0.05, "{last}");
        assert_eq!(panorama.size(), [5, 3]);
    }

    #[test]
    fn what_is_larger_than_the_budget_is_halved() {
        let sizes = [512, 511, 127].map(|most| {
            let panorama = Panorama::of_at_most(most, [32, 16], &[[0.5; 3]; 512]).expect("numbers");
            assert_eq!(panorama.radiance(Vec3::X), Vec3::splat(0.5));
            panorama.size()
        });
        assert_eq!(sizes, [[32, 16], [16, 8], [8, 4]]);
    }

    #[test]
    fn the_sky_has_no_edge() {
        let sky = Sky {
            towards_sun: vec3(0.6, 0.0, -0.8),
            zenith: [0.1, 0.25, 0.6],
            horizon: [0.5, 0.55, 0.6],
            ground: [0.12, 0.1, 0.08],
            glow: [0.5, 0.4, 0.2],
        };
        let at = |degrees: f32| {
            let height = degrees.to_radians().sin();
            sky.radiance(sky.towards_sun * (1.0 - height * height).sqrt() + Vec3::Y * height)
        };
        for tenth in -900..900_i16 {
            let [below, above] = [tenth, tenth + 1].map(|tenth| at(f32::from(tenth) * 0.1));
            assert!((above - below).abs().max_element() < 0.03, "{tenth}: {below} {above}");
        }
    }
}
