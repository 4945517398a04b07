//! The history of a flare: its counts as they arrive, and the brightness that follows from them.

use std::collections::VecDeque;

use cull::FrameId;

/// The counts of a flare's block in a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlareSamples {
    /// The frame of the counts.
    pub frame: FrameId,
    /// The age of that frame, in frames of the view, when it decided about the newest frame. With N
    /// frames in flight it is N, once a frame of that age has been drawn.
    pub age_frames: u64,
    /// The number of samples at which no opaque or masked object is nearer than the light.
    pub visible: u32,
    /// The number of samples in the image.
    pub total: u32,
    /// The number of samples in the whole block, inside and outside of the image.
    pub block: u32,
    /// The share of the light, 0 to 1, that transparent objects in front of it let through, as the
    /// mean over the visible samples. Each object takes its alpha. The resolution is 1/32.
    pub let_through: f32,
}

impl FlareSamples {
    /// Returns the counts of a block with `total` samples in the image and `block` samples in all,
    /// none of them visible.
    pub(super) fn of(frame: FrameId, total: u32, block: u32) -> Self {
        Self { frame, age_frames: 0, visible: 0, total, block, let_through: 1.0 }
    }

    /// Returns the visible share of the block's samples in the image, 0 to 1, times the share that
    /// transparent objects let through; 0 if no sample is in the image.
    #[must_use]
    pub fn fraction(&self) -> f32 {
        match self.total {
            0 => 0.0,
            total => self.visible as f32 / total as f32 * self.let_through,
        }
    }

    /// Returns the share of the block that is in the image, 0 to 1, which lets a light leave the
    /// image smoothly.
    #[must_use]
    pub fn in_image(&self) -> f32 {
        self.total as f32 / self.block.max(1) as f32
    }
}

/// The state of a flare in the newest frame of a view.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FlareState {
    /// The counts that decided; `None` before the first counts.
    pub samples: Option<FlareSamples>,
    /// The brightness that the flare was drawn with, 0 to 1, which follows the fraction.
    pub brightness: f32,
}

impl FlareState {
    /// Returns the fraction of the counts that decided; 0 without counts.
    #[must_use]
    pub fn fraction(&self) -> f32 {
        self.samples.map_or(0.0, |samples| samples.fraction())
    }
}

/// The highest change of the brightness from one frame to the next, since the few samples of a
/// distant light come and go in steps.
const FADE_A_FRAME: f32 = 0.25;

/// The additional age, beyond the frames in flight, above which counts are not used (frames).
const TOO_OLD_FRAMES: u64 = 8;

/// The counts of one flare in one view.
#[derive(Default)]
pub(super) struct FlareHistory {
    /// The counts that no frame has used yet, from the oldest on.
    arrived: VecDeque<FlareSamples>,
    state: FlareState,
    /// The brightness in the newest frame that was submitted.
    shown: f32,
}

impl FlareHistory {
    /// Takes counts, in any order.
    pub(super) fn take(&mut self, samples: FlareSamples) {
        let place = self.arrived.partition_point(|known| known.frame <= samples.frame);
        self.arrived.insert(place, samples);
    }

    /// Decides about frame `now` by the newest counts that are at least `delay_frames` old, even if
    /// younger ones have arrived: their arrival depends on the time that the GPU takes, and the
    /// image must not.
    pub(super) fn advance(&mut self, now: FrameId, delay_frames: u64) -> FlareState {
        let is_due = |samples: &FlareSamples| samples.frame.0 + delay_frames <= now.0;
        while self.arrived.front().is_some_and(is_due) {
            self.state.samples = self.arrived.pop_front();
        }
        if let Some(samples) = &mut self.state.samples {
            samples.age_frames = now.0.saturating_sub(samples.frame.0);
        }
        let fresh = |flare_samples: &FlareSamples| {
            flare_samples.age_frames <= delay_frames + TOO_OLD_FRAMES
        };
        let known = self.state.samples.filter(fresh);
        let wanted = known.map_or(0.0, |samples| samples.fraction() * samples.in_image());
        let change = wanted - self.shown;
        self.state.brightness = self.shown + change.clamp(-FADE_A_FRAME, FADE_A_FRAME);
        self.state
    }

    /// Forgets counts that no frame has used, of frames before the numbers of frames began anew.
    /// The brightness stays until the next counts.
    pub(super) fn forget_arrived(&mut self) {
        self.arrived.clear();
    }

    /// Notes that the newest frame was submitted. Frames that are not submitted change no
    /// brightness.
    pub(super) fn submitted(&mut self) {
        self.shown = self.state.brightness;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(frame: u64, visible: u32) -> FlareSamples {
        FlareSamples {
            frame: FrameId(frame),
            age_frames: 0,
            visible,
            total: 16,
            block: 16,
            let_through: 1.0,
        }
    }

    #[test]
    fn fractions_are_of_what_is_in_the_image_and_of_what_is_let_through() {
        let whole = counted(1, 8);
        assert_eq!((whole.fraction(), whole.in_image()), (0.5, 1.0));
        let transmitted = FlareSamples { let_through: 0.5, ..whole };
        assert_eq!(transmitted.fraction(), 0.25);
        let cut = FlareSamples { total: 8, ..whole };
        assert_eq!((cut.fraction(), cut.in_image()), (1.0, 0.5));
        let outside = FlareSamples { total: 0, visible: 0, ..whole };
        assert_eq!((outside.fraction(), outside.in_image()), (0.0, 0.0));
    }

    #[test]
    fn counts_of_the_same_age_decide_whenever_they_arrive() {
        let counts = [16, 0, 8, 8, 16, 4, 0, 16, 2, 2, 10];
        // In time, all at once in the wrong order, and as early as possible.
        let arrivals: [fn(u64) -> u64; 3] = [|frame| frame + 2, |_| 1, |frame| frame + frame % 3];
        let runs = arrivals.map(|arrival| {
            let mut history = FlareHistory::default();
            let mut states = Vec::new();
            for now in 1..=counts.len() as u64 {
                for (visible, frame) in counts.into_iter().zip(1_u32..12).rev() {
                    let frame = u64::from(frame);
                    if arrival(frame) == now {
                        history.take(counted(frame, visible));
                    }
                }
                states.push(history.advance(FrameId(now), 2));
                history.submitted();
            }
            states
        });
        for states in &runs {
            assert_eq!(states[1].samples, None);
            for (state, (frame, visible)) in states[2..].iter().zip((1..).zip(counts)) {
                let expected = FlareSamples { age_frames: 2, ..counted(frame, visible) };
                assert_eq!(state.samples, Some(expected));
            }
            assert_eq!(states, &runs[0]);
        }
    }

    #[test]
    fn brightness_follows_in_steps_and_goes_without_counts() {
        let mut history = FlareHistory::default();
        let mut before = 0.0_f32;
        let mut seen = Vec::new();
        for now in 1..40 {
            if now < 20 {
                history.take(counted(now, if now < 10 { 16 } else { 6 }));
            }
            // A frame that is never submitted comes before each frame.
            history.advance(FrameId(now), 1);
            let state = history.advance(FrameId(now), 1);
            history.submitted();
            assert!((state.brightness - before).abs() <= FADE_A_FRAME, "{now}");
            before = state.brightness;
            seen.push(state.brightness);
        }
        assert_eq!(seen[..6], [0.0, 0.25, 0.5, 0.75, 1.0, 1.0]);
        assert_eq!(seen[16], 6.0 / 16.0);
        // The last counts are of frame 19.
        assert_eq!(seen[26], 6.0 / 16.0);
        assert_eq!(seen[38], 0.0);
    }
}
