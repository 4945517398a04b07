//! Seeded random numbers for scenes, paths and mishaps.

use glam::Vec3;

/// Returns a number of seeds, times `ANTUMBRA_TIMES` if that is in the environment, as in
/// `ci/verify`.
pub fn seeds(count: u64) -> u64 {
    let times = std::env::var("ANTUMBRA_TIMES").map(|times| times.parse());
    count * times.unwrap_or(Ok(1)).expect("ANTUMBRA_TIMES is a number")
}

/// A xorshift generator; any seed is allowed.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5bf0_3635_dcd2_7f1b | 1)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// Returns a number evenly distributed in `0..end`.
    pub fn below(&mut self, end: usize) -> usize {
        ((self.next() >> 33) as usize) % end
    }

    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.next() >> 40) as f32 / (1_u32 << 24) as f32)
    }

    pub fn chance(&mut self, probability: f32) -> bool {
        self.between(0.0, 1.0) < probability
    }

    pub fn point(&mut self, low: f32, high: f32) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| self.between(low, high)))
    }
}
