//! The times of frames on the GPU, for the cost models of the views that they showed.
//!
//! A time is known when the slot of its frame is used again, together with the frame's results and
//! hence its draws. Prices belong to the device: where a frame shows several views, each of their
//! cost models learns from the time of the frame and the contents of all of them.

use std::collections::VecDeque;

use cull::{FrameContents, FrameId};
use gpu::FrameTime;

use crate::sent_frames::TIMES_KEPT;
use crate::visibility_state::VisibilityState;

/// The interval of the timed frames of a view. Timestamps keep frames from overlapping: on a
/// software driver a frame that has them takes a tenth longer.
const TIMED_INTERVAL_FRAMES: u64 = 16;

/// Returns true if the frame after `frame` is timed.
pub fn is_timed_after(frame: FrameId) -> bool {
    frame.0.is_multiple_of(TIMED_INTERVAL_FRAMES)
}

/// The times that no cost model learnt from yet.
#[derive(Debug, Default)]
pub struct FrameTimes {
    known: VecDeque<FrameTime>,
}

impl FrameTimes {
    /// Takes the time of a frame that is over.
    pub fn take(&mut self, time: FrameTime) {
        if self.known.len() == TIMES_KEPT {
            self.known.pop_front();
        }
        self.known.push_back(time);
    }

    /// Passes the times of the frames of `views`, which were drawn together, to their cost models.
    /// The results of those frames must have been read.
    pub fn teach<V>(&mut self, views: &mut [V])
    where
        V: AsRef<VisibilityState> + AsMut<VisibilityState>,
    {
        self.known.retain(|time| {
            let sent = || views.iter().filter_map(|view| view.as_ref().sent.of(time.tick));
            let Some(together) = sent().map(|sent| sent.views).next() else { return true };
            if sent().count() == together {
                let contents = sent().fold(FrameContents::default(), |mut sum, sent| {
                    sum += sent.contents;
                    sum
                });
                for view in views.iter_mut() {
                    view.as_mut().took(time, &contents);
                }
            }
            // Of a frame of several views that are not drawn together any more, nothing is learned.
            false
        });
    }
}
