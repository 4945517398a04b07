//! How long the last frames took, from start to start.

use pacing::Time;

const KEPT: usize = 130;

/// The newest frames, as many as a graph shows. Allocates nothing once it was made.
#[derive(Clone, Debug)]
pub struct FrameTimes {
    ring: [f32; KEPT],
    count: usize,
    last: Option<Time>,
}

impl Default for FrameTimes {
    fn default() -> Self {
        Self { ring: [0.0; KEPT], count: 0, last: None }
    }
}

impl FrameTimes {
    /// A frame started.
    pub fn push(&mut self, started: Time) {
        if let Some(last) = self.last.replace(started) {
            self.ring[self.count % KEPT] = started.since(last).as_secs_f32() * 1e3;
            self.count += 1;
        }
    }

    /// Milliseconds a frame, oldest first.
    pub fn newest_ms(&self) -> impl Iterator<Item = f32> {
        let first = self.count.saturating_sub(KEPT);
        (first..self.count).map(|place| self.ring[place % KEPT])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_are_kept_in_their_order() {
        let mut times = FrameTimes::default();
        let mut now = 0;
        for frame in 0..300_u64 {
            now += frame * 1_000_000;
            times.push(Time::from_nanos(now));
        }
        let kept: Vec<f32> = times.newest_ms().collect();
        assert_eq!((kept.len(), kept[0], kept[KEPT - 1]), (KEPT, 170.0, 299.0));
    }
}
