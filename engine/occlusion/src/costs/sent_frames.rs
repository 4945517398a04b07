//! The submitted frames of a view that are timed, with their contents.

use std::collections::VecDeque;

use cull::{FrameContents, FrameId, FramePlan};
use gpu::Tick;

use crate::outcomes::FrameStats;

/// The number of times kept for views that are not drawn at the moment; older times are lost.
pub(crate) const TIMES_KEPT: usize = 8;

/// A frame of one view that is in flight, or whose time has not been used yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SentFrame {
    tick: Tick,
    frame: FrameId,
    pub(crate) contents: FrameContents,
    /// The number of views that the frame showed.
    pub(crate) views: usize,
}

/// The latest frames of one view.
#[derive(Debug)]
pub(crate) struct SentFrames {
    frames: VecDeque<SentFrame>,
    most: usize,
}

impl SentFrames {
    pub(crate) fn new(frames_in_flight: usize) -> Self {
        let most = frames_in_flight + TIMES_KEPT;
        Self { frames: VecDeque::with_capacity(most), most }
    }

    /// Notes a submitted frame that shows `views` views.
    pub(crate) fn submitted(&mut self, tick: Tick, plan: &FramePlan, views: usize) {
        if self.frames.len() == self.most {
            self.frames.pop_front();
        }
        let contents = FrameContents::of(plan);
        self.frames.push_back(SentFrame { tick, frame: plan.frame, contents, views });
    }

    /// Notes the draws of a frame once they are known.
    pub(crate) fn drew(&mut self, outcome: &FrameStats) {
        if let Some(sent) = self.frames.iter_mut().find(|sent| sent.frame == outcome.frame) {
            sent.contents.draws = outcome.draws;
            sent.contents.triangles = outcome.triangles;
        }
    }

    pub(crate) fn of(&self, tick: Tick) -> Option<&SentFrame> {
        self.frames.iter().find(|sent| sent.tick == tick)
    }
}
