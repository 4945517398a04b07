//! Whether acquires wait for the display at all: a trial before their waits are believed.
//!
//! An acquire may as well wait for the GPU, or for a window system that copies pictures, and neither tells
//! of refreshes. A display gives itself away by holding an image back that the GPU is long done with, and
//! by waits that end on one grid whatever frames take. So a wait is evidence only where the frame that
//! had to be shown first was seen finished a whole frame ago. With two images that frame is the newest
//! one, and never is: there frames start so that the one before is finished when the next image is asked
//! for, every other one later by some part of a frame, so that what follows the GPU keeps to no grid.

use super::Pacer;
use crate::frames::Record;
use crate::refresh_clock::RefreshClock;
use crate::time::{MILLISECOND_NS, SECOND_NS};

/// So many waits in a row must end where the ones before foretold.
const ENOUGH: u32 = 16;
/// Of a period: what they may be off. One that ends at random does so one time in five.
const AGREES: f64 = 0.1;
/// Fewest images with which frames queue behind one that is finished.
const QUEUEING_IMAGES: u32 = 3;
/// Standard deviations that the GPU is given to finish.
const SAFE: f64 = 3.0;
/// Work that is not seen finished for so long is not waited for.
const PATIENCE_NS: f64 = SECOND_NS;
const LONGEST_DELAY_NS: f64 = 250.0 * MILLISECOND_NS;

/// What speaks for a display that makes acquires wait.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    clock: RefreshClock,
    agreed: u32,
    is_won: bool,
    /// When the last acquire returned, and how long after the one before.
    returned: Option<f64>,
    spacing: f64,
}

impl Trial {
    pub(super) const fn new(hint: Option<f64>) -> Self {
        let clock = RefreshClock::new(hint);
        Self { clock, agreed: 0, is_won: false, returned: None, spacing: 0.0 }
    }

    /// An acquire returned; answers when the one before did.
    pub(super) fn returned(&mut self, to: f64) -> Option<f64> {
        let before = self.returned.replace(to);
        self.spacing = before.map_or(0.0, |before| (to - before).max(0.0));
        before
    }

    /// What was seen so far was seen too long ago.
    pub(super) fn begin_anew(&mut self, hint: Option<f64>) {
        if !self.is_won {
            (self.clock, self.agreed) = (RefreshClock::new(hint), 0);
        }
    }

    /// A wait that only a display can have caused ended then; answers the display's clock once enough have.
    fn observe(&mut self, at: f64) -> Option<RefreshClock> {
        let foretold = self.clock.period().zip(self.clock.at_or_after(at));
        let agrees = foretold.is_some_and(|(period, next)| {
            let early = next - at;
            early.min(period - early) < AGREES * period
        });
        self.agreed = if agrees { self.agreed + 1 } else { 0 };
        self.clock.observe(at);
        self.is_won = self.agreed >= ENOUGH;
        self.is_won.then(|| self.clock.clone())
    }

    /// Some part of a frame, another one for each; none for every other frame.
    fn delay(&self, frame: u64) -> f64 {
        if frame.is_multiple_of(2) {
            return 0.0;
        }
        // Fibonacci hashing (Knuth 6.4) of a square: no period of its own.
        let mixed = frame.wrapping_mul(frame).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let part = (mixed >> 40) as f64 / f64::from(1_u32 << 24);
        part * self.spacing.min(LONGEST_DELAY_NS)
    }
}

impl Pacer {
    /// An acquire that had to wait returned, the last one before it at `before`; `shown` had to be shown
    /// for it. Answers whether that tells of a refresh.
    pub(super) fn tells_of_refresh(&mut self, shown: u64, to: f64, before: Option<f64>) -> bool {
        if self.trial.is_won {
            return true;
        }
        let seen = self.frames.record(shown).and_then(|record| record.seen_finished);
        let latest = match (self.starts_in_turn(), self.has_few_images()) {
            (true, _) => self.last_from,
            (false, false) => before,
            (false, true) => None,
        };
        if seen.zip(latest).is_some_and(|(seen, latest)| seen <= latest)
            && let Some(clock) = self.trial.observe(to)
        {
            self.clock = clock;
        }
        false
    }

    const fn has_few_images(&self) -> bool {
        self.presentation.images < QUEUEING_IMAGES
    }

    /// Whether frames start so that the one before is finished when an image is asked for.
    fn starts_in_turn(&self) -> bool {
        self.has_few_images() && self.searches_phase() && !self.trial.is_won && self.sees_finishes
    }

    /// The earliest start of the next frame while the phase is searched for.
    pub(super) fn start_in_search(&self, now: f64) -> f64 {
        if !self.starts_in_turn() {
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
        finish - self.cpu.expected() + self.trial.delay(self.frames.next())
    }
}
