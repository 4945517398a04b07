//! The times of frames on the GPU, for the cost models of the views that they showed.
//!
//! A frame's time is known when its slot is used again, together with its results and therefore its
//! draws. Costs belong to the device: where a frame shows several views, the cost model of each
//! view learns from the time of the frame and from the contents of all views.

use std::collections::VecDeque;

use cull::{CostTable, FrameContents, FrameId, Strategy};
use gpu::{Device, FrameRing, FrameTime, OptionalFeature};

use crate::costs::sent_frames::TIMES_KEPT;
use crate::error::Error;
use crate::occlusion_state::OcclusionState;

/// The interval between the timed frames of a view. Timestamps keep frames from overlapping: on a
/// software driver, a frame with timestamps takes a tenth longer.
const TIMED_INTERVAL_FRAMES: u64 = 16;

fn is_timed_after(frame: FrameId) -> bool {
    frame.0.is_multiple_of(TIMED_INTERVAL_FRAMES)
}

/// The frame times that have not reached a cost model yet.
#[derive(Debug)]
pub struct FrameTimes {
    known: VecDeque<FrameTime>,
    /// True if there are costs to correct and the device has timestamps.
    learns: bool,
}

impl FrameTimes {
    /// Creates an empty list for a device. Without `device_costs`, no frame is timed.
    pub fn new(device: &Device, device_costs: Option<&CostTable>) -> Self {
        let learns =
            device_costs.is_some() && device.capabilities().has(OptionalFeature::Timestamps);
        Self { known: VecDeque::new(), learns }
    }

    /// Enables the timing of frames in a ring, if cost models use it.
    ///
    /// # Errors
    /// A failed call.
    pub fn enable(&self, frames: &mut FrameRing) -> Result<(), Error> {
        if self.learns { Ok(frames.time_frames()?) } else { Ok(()) }
    }

    /// Returns true if the next frame, which shows all of these views, is to be timed.
    pub fn is_due<'a>(
        &self,
        strategy: Strategy,
        mut views: impl Iterator<Item = &'a OcclusionState> + Clone,
    ) -> bool {
        strategy.uses_cost_model()
            && self.learns
            && views.clone().all(OcclusionState::has_cost_model)
            && views.any(|view| is_timed_after(view.culler().frame()))
    }

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
        V: AsRef<OcclusionState> + AsMut<OcclusionState>,
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
            // A frame of several views that are no longer drawn together teaches nothing.
            false
        });
    }
}
