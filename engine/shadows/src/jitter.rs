//! The offsets of filter samples: jittered and stratified over a disk, the outermost ring first,
//! stored as the bytes of a tiled 3D texture (Uralsky, GPU Gems 2, 17.3).

use std::f32::consts::TAU;

use cull::trigonometry;

/// The number of samples of a disk.
pub const DISK_SAMPLES: u32 = 64;

/// The number of samples of a ring, and of rings of a disk.
const RING: u32 = 8;

/// A 3D texture of disks. Each x and y holds another disk; along z lie its samples, two per texel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JitterTexture {
    /// The side of the tile of disks, in texels.
    pub side: u32,
    /// The depth in texels.
    pub depth: u32,
    /// Four signed 8-bit numbers per texel, the x and y of two samples: -127 for -1 to 127 for 1.
    /// The order of texels is x first, then y, then z.
    pub texels: Vec<[i8; 4]>,
}

impl JitterTexture {
    /// Creates the texture for a tile of `side` by `side` disks; the result is deterministic.
    #[must_use]
    pub fn new(side: u32) -> Self {
        let disks: Vec<Vec<[f32; 2]>> = (0..side * side).map(disk).collect();
        let signed = |value: f32| (value * 127.0).round() as i8;
        let texel = |pair: u32, disk: &Vec<[f32; 2]>| {
            let [a, b] = [0, 1]
                .map(|sample| disk.get((2 * pair + sample) as usize).copied().unwrap_or_default());
            [signed(a[0]), signed(a[1]), signed(b[0]), signed(b[1])]
        };
        let depth = DISK_SAMPLES / 2;
        let texels = (0..depth).flat_map(|pair| disks.iter().map(move |disk| texel(pair, disk)));
        Self { side, depth, texels: texels.collect() }
    }
}

/// Returns the samples of a disk of radius 1: a grid of jittered places in a square, whose rows
/// become rings of equal area and whose columns become sectors.
fn disk(number: u32) -> Vec<[f32; 2]> {
    let mut random = Random::new(number);
    let mut samples = Vec::with_capacity(DISK_SAMPLES as usize);
    for ring in (0..DISK_SAMPLES / RING).rev() {
        for sector in 0..RING {
            let u = (sector as f32 + random.unit()) / RING as f32;
            let v = (ring as f32 + random.unit()) / (DISK_SAMPLES / RING) as f32;
            let radius = v.sqrt();
            let angle_rad = TAU * u;
            samples.push([
                radius * trigonometry::cos(angle_rad),
                radius * trigonometry::sin(angle_rad),
            ]);
        }
    }
    samples
}

/// A small pseudo-random generator, the same on all machines (PCG, O'Neill 2014).
struct Random(u64);

impl Random {
    fn new(seed: u32) -> Self {
        let mut random = Self(u64::from(seed).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x853C_49E6);
        random.unit();
        random
    }

    /// Returns a number of `0.0..1.0`.
    fn unit(&mut self) -> f32 {
        let state = self.0;
        self.0 = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        let mixed = (((state >> 18) ^ state) >> 27) as u32;
        let number = mixed.rotate_right((state >> 59) as u32);
        (number >> 8) as f32 / (1 << 24) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disks_are_stratified_and_begin_with_their_edge() {
        for number in 0..64 {
            let samples = disk(number);
            assert_eq!(samples.len(), DISK_SAMPLES as usize);
            for (place, [x, y]) in samples.iter().enumerate() {
                let ring = 7 - place / 8;
                let v = x * x + y * y;
                assert!(v >= ring as f32 / 8.0 - 1e-4 && v <= (ring + 1) as f32 / 8.0 + 1e-4);
                let turn = y.atan2(*x).rem_euclid(TAU) / TAU * 8.0;
                let sector = (place % 8) as f32;
                assert!(turn >= sector - 1e-3 && turn <= sector + 1.0 + 1e-3);
            }
        }
    }

    #[test]
    fn the_area_is_covered_evenly() {
        // A quarter of the samples is within half the radius, like a quarter of the area.
        let inside = (0..256).flat_map(disk).filter(|[x, y]| x * x + y * y < 0.25).count();
        assert_eq!(inside, 256 * 16);
        let (x, y) = (0..256)
            .flat_map(disk)
            .fold((0.0, 0.0), |sum: (f32, f32), [x, y]| (sum.0 + x, sum.1 + y));
        let count = 256.0 * 64.0;
        assert!((x / count).abs() < 0.002 && (y / count).abs() < 0.002);
    }

    #[test]
    fn a_texel_holds_two_samples_as_signed_bytes() {
        let texture = JitterTexture::new(4);
        assert_eq!((texture.side, texture.depth, texture.texels.len()), (4, 32, 4 * 4 * 32));
        let samples = disk(5);
        for pair in 0..32 {
            let texel = texture.texels[pair * 16 + 5];
            let found = texel.map(|byte| f32::from(byte) / 127.0);
            let a = samples[2 * pair];
            let b = samples[2 * pair + 1];
            for (found, wanted) in found.iter().zip(a.into_iter().chain(b)) {
                assert!((found - wanted).abs() < 0.5 / 127.0 + 1e-6);
            }
        }
        assert_eq!(texture, JitterTexture::new(4));
    }
}
