//! The frames of a view that were submitted and are timed: what they were made of.

use std::collections::VecDeque;

use cull::{FrameContents, FrameId, FramePlan};
use gpu::Tick;

use crate::outcomes::FrameOutcome;

/// Times that are kept for views that are not drawn at the moment; older ones are lost.
pub(crate) const TIMES_KEPT: usize = 8;

/// A frame of one view that is on its way, or whose time is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SentFrame {
    tick: Tick,
    frame: FrameId,
    pub(crate) contents: FrameContents,
    /// How many views the frame showed.
    pub(crate) views: usize,
}

/// Those of one view, the latest ones.
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

    /// A frame is on its way that shows so many views.
    pub(crate) fn submitted(&mut self, tick: Tick, plan: &FramePlan, views: usize) {
        if self.frames.len() == self.most {
            self.frames.pop_front();
        }
        let contents = FrameContents::of(plan);
        self.frames.push_back(SentFrame { tick, frame: plan.frame, contents, views });
    }

    /// It is known what a frame drew.
    pub(crate) fn drew(&mut self, outcome: &FrameOutcome) {
        if let Some(sent) = self.frames.iter_mut().find(|sent| sent.frame == outcome.frame) {
            sent.contents.draws = outcome.draws;
            sent.contents.triangles = outcome.triangles;
        }
    }

    /// Returns the frame of a tick.
    pub(crate) fn of(&self, tick: Tick) -> Option<&SentFrame> {
        self.frames.iter().find(|sent| sent.tick == tick)
    }
}
