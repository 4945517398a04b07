//! A trial of acquires, which decides whether they wait for the display.
//!
//! An acquire may also wait for the GPU, or for a window system that copies images. Neither reveals
//! refreshes. Waits for the display end on one grid, whenever frames start. So once waits seem to
//! have a period, frames are shaken: a frame waits until the GPU is idle, and then for some part of
//! a frame more. After that, waits that follow the GPU are shifted by the same part; waits for a
//! display are not.
//!
//! A wait counts only if the frame that had to be shown first was seen finished a whole frame
//! earlier. With two images that frame is the newest one, which is never finished so early. Then
//! frames start so that it is finished when the next image is acquired.

use crate::refresh_clock::RefreshClock;
use crate::time::MILLISECOND_NS;

/// The number of consecutive shakes whose first wait must end as the earlier waits predict.
const ENOUGH: u32 = 6;
/// The tolerance, as a share of a period. A wait with a random end is within it one time in seven.
const AGREES: f64 = 0.07;
/// The longest period of a display.
const LONGEST_PERIOD_NS: f64 = 125.0 * MILLISECOND_NS;

/// The state of a shake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::pacer) enum Shaking {
    Rests,
    /// A shake is due: the next frame will be delayed.
    Due,
    /// The id of a delayed frame. No wait for this frame or a later one has ended since.
    Done(u64),
}

/// The evidence for a display that makes acquires wait.
#[derive(Clone, Debug)]
pub(in crate::pacer) struct Trial {
    clock: RefreshClock,
    agreed: u32,
    pub(in crate::pacer) is_won: bool,
    pub(in crate::pacer) shaking: Shaking,
    /// The time at which the last acquire returned.
    returned: Option<f64>,
}

impl Trial {
    pub(in crate::pacer) const fn new(hint: Option<f64>) -> Self {
        let clock = RefreshClock::new(hint);
        let shaking = Shaking::Rests;
        Self { clock, agreed: 0, is_won: false, shaking, returned: None }
    }

    /// Returns true if waits are known to be for the display.
    pub(in crate::pacer) const fn is_won(&self) -> bool {
        self.is_won
    }

    /// Notes that the acquire of `frame` returned. Returns the time at which the previous acquire
    /// returned.
    pub(in crate::pacer) fn returned(&mut self, frame: u64, to: f64) -> Option<f64> {
        if self.shaking == Shaking::Due {
            self.shaking = Shaking::Done(frame);
        }
        self.returned.replace(to)
    }

    /// Discards the evidence because it is too old.
    pub(in crate::pacer) fn restart(&mut self, hint: Option<f64>) {
        if !self.is_won {
            (self.clock, self.agreed) = (RefreshClock::new(hint), 0);
            self.shaking = Shaking::Rests;
        }
    }

    /// Notes the end of a wait for `shown` that a display may have caused. Returns the display's
    /// clock once it is certain.
    pub(in crate::pacer) fn observe(&mut self, shown: u64, at: f64) -> Option<RefreshClock> {
        // Waits for frames from before the shake are not shifted.
        if matches!(self.shaking, Shaking::Done(frame) if shown < frame) {
            return None;
        }
        let predicted = self.clock.period().zip(self.clock.at_or_after(at));
        let agrees = predicted.is_some_and(|(period, next)| {
            let early = next - at;
            early.min(period - early) < AGREES * period
        });
        match (agrees, self.shaking) {
            (true, Shaking::Done(_)) => self.agreed += 1,
            (true, _) => {}
            (false, _) => self.agreed = 0,
        }
        self.clock.observe(at);
        if self.clock.period().is_some_and(|period| period > LONGEST_PERIOD_NS) {
            (self.clock, self.agreed) = (RefreshClock::new(None), 0);
        }
        let is_periodic = self.clock.period().is_some();
        self.shaking = if is_periodic { Shaking::Due } else { Shaking::Rests };
        self.is_won = self.agreed >= ENOUGH;
        self.is_won.then(|| self.clock.clone())
    }

    /// Returns a delay of some part of the apparent period, different for each frame.
    pub(in crate::pacer) fn delay(&self, frame: u64) -> f64 {
        // SplitMix64 (Steele, Lea, Flood 2014): no periodic process follows it.
        let mut mixed = frame.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let part = (mixed >> 40) as f64 / f64::from(1_u32 << 24);
        part * self.clock.period().unwrap_or(0.0)
    }
}
