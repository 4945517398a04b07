//! The trial of acquires: finds the cause of their waits from the frames of a pacer.

use super::super::Pacer;
use super::super::trial::Shaking;
use crate::frames::Record;
use crate::time::SECOND_NS;

/// The fewest images with which frames can queue after a finished frame.
const QUEUEING_IMAGES: u32 = 3;
/// The number of standard deviations that the GPU is given to finish.
const SAFE: f64 = 3.0;
/// The time after which the pacer no longer waits for unfinished work.
const PATIENCE_NS: f64 = SECOND_NS;

impl Pacer {
    /// Returns true if an acquire that had to wait and returned at `to` reveals a refresh. The
    /// previous acquire returned at `before`; frame `shown` had to be shown first.
    pub(in crate::pacer) fn tells_of_refresh(
        &mut self,
        shown: u64,
        to: f64,
        before: Option<f64>,
    ) -> bool {
        if self.trial.is_won {
            return true;
        }
        let seen = self.frames.record(shown).and_then(|record| record.seen_finished);
        let latest = if self.has_few_images() { self.last_from } else { before };
        if self.is_tried()
            && seen.zip(latest).is_some_and(|(seen, latest)| seen <= latest)
            && let Some(clock) = self.trial.observe(shown, to)
        {
            self.clock = clock;
        }
        false
    }

    const fn has_few_images(&self) -> bool {
        self.presentation.images < QUEUEING_IMAGES
    }

    fn is_tried(&self) -> bool {
        self.searches_phase() && !self.trial.is_won && self.sees_finishes
    }

    /// Returns the earliest start of the next frame during a phase search.
    pub(in crate::pacer) fn start_in_search(&self, now: f64) -> f64 {
        let is_shaken = self.trial.shaking == Shaking::Due;
        if !self.is_tried() || !(is_shaken || self.has_few_images()) {
            return now;
        }
        let Some((_, newest)) = self.frames.newest_first().next() else { return now };
        let awaited = |record: &Record| {
            !record.dropped && record.queued.is_some_and(|queued| now - queued < PATIENCE_NS)
        };
        if !awaited(newest) {
            return now;
        }
        let finish = newest.seen_finished.unwrap_or_else(|| {
            self.knowledge(f64::NEG_INFINITY).finish(newest, 0.0) + SAFE * self.gpu.spread()
        });
        match (is_shaken, newest.seen_finished) {
            (true, None) => now + self.some_period_ns(),
            (true, Some(seen)) => seen + self.trial.delay(self.frames.next()),
            (false, _) => finish - self.cpu.expected(),
        }
    }
}
