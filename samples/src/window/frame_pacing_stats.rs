//! The frame pacing statistics under the current conditions; a change of conditions resets them.

use antumbra::pacing::{
    FrameStatistics, FrameTiming, HitchRule, PacedFrameId, PacingError, Summary,
};

use super::conditions::Conditions;

/// The number of frames in the statistics.
const FRAMES: usize = 600;

/// The newest frames under the same conditions.
#[derive(Debug)]
pub struct FramePacingStats {
    statistics: FrameStatistics,
    conditions: Option<Conditions>,
    /// The first frame under these conditions. Its time began with a frame under other conditions.
    first: Option<PacedFrameId>,
}

impl FramePacingStats {
    /// Creates statistics without frames.
    ///
    /// # Errors
    /// An invalid number of frames. The built-in number is valid.
    pub fn new() -> Result<Self, PacingError> {
        let statistics = FrameStatistics::new(FRAMES, HitchRule::default())?;
        Ok(Self { statistics, conditions: None, first: None })
    }

    /// Notes that the frame `next` and later ones have `conditions`. Frames under other conditions
    /// are removed.
    pub fn follow(&mut self, conditions: Conditions, next: PacedFrameId) {
        if self.conditions != Some(conditions) {
            self.statistics.clear();
            self.first = self.conditions.replace(conditions).map(|_| next);
        }
    }

    /// Records a frame. Late timings of frames under earlier conditions are ignored.
    pub fn record(&mut self, frame: PacedFrameId, timing: FrameTiming) {
        if self.first.is_none_or(|first| frame > first) {
            self.statistics.record(timing);
        }
    }

    /// Returns the statistics of the recorded frames.
    pub fn summary(&mut self) -> Summary {
        self.statistics.summary()
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use antumbra::gpu::PresentMode;

    use super::*;
    use bench::strategy::Strategy;

    fn record(evenness: &mut FramePacingStats, frames: std::ops::Range<u64>, interval_ms: u64) {
        for frame in frames {
            let interval = Some(Duration::from_millis(interval_ms));
            let timing = FrameTiming {
                present_interval: interval,
                latency: interval,
                missed: Some(1),
                ..FrameTiming::default()
            };
            evenness.record(PacedFrameId(frame), timing);
        }
    }

    #[test]
    fn other_conditions_start_anew() {
        let old = Conditions {
            strategy: Strategy::ANTUMBRA,
            size: [640, 360],
            frames_in_flight: 2,
            present_mode: Some(PresentMode::Fifo),
            scene: 0,
            is_comparing: false,
        };
        for new in [
            Conditions { strategy: Strategy::FRUSTUM, ..old },
            Conditions { size: [640, 361], ..old },
            Conditions { frames_in_flight: 3, ..old },
            Conditions { present_mode: Some(PresentMode::Immediate), ..old },
            Conditions { scene: 1, ..old },
            Conditions { is_comparing: true, ..old },
        ] {
            let mut evenness = FramePacingStats::new().unwrap();
            evenness.follow(old, PacedFrameId(0));
            record(&mut evenness, 0..10, 16);
            evenness.follow(old, PacedFrameId(12));
            assert_eq!(evenness.summary().missed_refreshes, Some(10));
            evenness.follow(new, PacedFrameId(12));
            assert_eq!(evenness.summary(), Summary::default(), "{new:?}");
            record(&mut evenness, 10..13, 16);
            assert_eq!(evenness.summary().frames, 0, "these began under the conditions before");
            record(&mut evenness, 13..16, 2);
            let summary = evenness.summary();
            assert_eq!((summary.frames, summary.missed_refreshes), (3, Some(3)));
            let worst = Duration::from_millis(2);
            assert_eq!(summary.present_intervals.unwrap().worst, worst);
            assert_eq!(summary.latencies.unwrap().worst, worst);
        }
    }
}
