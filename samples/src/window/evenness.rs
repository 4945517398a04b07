//! How evenly frames came in the present mode that is in use: another mode begins anew.

use gpu::PresentMode;
use pacing::{FrameId, FrameStatistics, FrameTiming, HitchRule, PacingError, Summary};

/// Statistics are over so many frames.
const FRAMES: usize = 600;

/// The newest frames of one present mode.
#[derive(Debug)]
pub struct Evenness {
    statistics: FrameStatistics,
    mode: PresentMode,
    /// The first frame of the mode.
    first: FrameId,
}

impl Evenness {
    /// No frame was shown yet.
    ///
    /// # Errors
    /// None that can come with the number of frames that is built in.
    pub fn new(mode: PresentMode) -> Result<Self, PacingError> {
        let statistics = FrameStatistics::new(FRAMES, HitchRule::default())?;
        Ok(Self { statistics, mode, first: FrameId(0) })
    }

    /// From the frame `next` on they are shown in this mode. Those of another one are forgotten.
    pub fn follow(&mut self, mode: PresentMode, next: FrameId) {
        if std::mem::replace(&mut self.mode, mode) != mode {
            self.statistics.clear();
            self.first = next;
        }
    }

    /// Takes a frame in, unless it was shown in the mode before: of some that is known only later.
    pub fn record(&mut self, frame: FrameId, timing: FrameTiming) {
        if frame >= self.first {
            self.statistics.record(timing);
        }
    }

    /// All numbers over the frames held.
    pub fn summary(&mut self) -> Summary {
        self.statistics.summary()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn record(evenness: &mut Evenness, frames: std::ops::Range<u64>, interval_ms: u64) {
        for frame in frames {
            let interval = Some(Duration::from_millis(interval_ms));
            let timing = FrameTiming {
                present_interval: interval,
                latency: interval,
                missed: Some(1),
                ..FrameTiming::default()
            };
            evenness.record(FrameId(frame), timing);
        }
    }

    #[test]
    fn another_mode_begins_anew() {
        let mut evenness = Evenness::new(PresentMode::Fifo).unwrap();
        record(&mut evenness, 0..10, 16);
        evenness.follow(PresentMode::Fifo, FrameId(12));
        assert_eq!(evenness.summary().missed_refreshes, Some(10));
        evenness.follow(PresentMode::Immediate, FrameId(12));
        assert_eq!(evenness.summary(), Summary::default());
        record(&mut evenness, 10..12, 16);
        assert_eq!(evenness.summary().frames, 0, "these were shown in the mode before");
        record(&mut evenness, 12..15, 2);
        let summary = evenness.summary();
        assert_eq!((summary.frames, summary.missed_refreshes), (3, Some(3)));
        let worst = Duration::from_millis(2);
        assert_eq!(summary.present_intervals.unwrap().worst, worst);
        assert_eq!(summary.latencies.unwrap().worst, worst);
    }
}
