//! A small seeded generator for jitter: SplitMix64 (Steele, Lea, Flood 2014).

/// A generator of deterministic random numbers. Not for secrets.
#[derive(Clone, Debug)]
pub(crate) struct SplitMix64(u64);

impl SplitMix64 {
    pub(crate) const fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// Returns a number evenly distributed in 0 to 1, 1 excluded.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1_u32 << 24) as f32
    }

    /// Returns a number evenly distributed in `low..=high`; `low` if the range is empty.
    pub(crate) fn between(&mut self, low: u32, high: u32) -> u32 {
        let span = u64::from(high.saturating_sub(low)) + 1;
        low + (self.next() % span) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stays_in_range_and_reaches_both_ends() {
        let mut rng = SplitMix64::new(7);
        let seen: Vec<u32> = (0..200).map(|_| rng.between(3, 6)).collect();
        assert!((3..=6).all(|value| seen.contains(&value)));
        assert!(seen.iter().all(|value| (3..=6).contains(value)));
        assert!((0..200).all(|_| (0.0..1.0).contains(&rng.unit())));
        assert_eq!(rng.between(9, 2), 9);
    }
}
