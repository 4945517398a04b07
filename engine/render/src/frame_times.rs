//! What frames took on the GPU goes to the governors of the views that they showed.
//!
//! A time comes home with the slot of its frame, as the answers to that frame do; then it is known what
//! was drawn. Prices are the device's: where a frame shows several views, each of their governors is
//! told the time of the frame and the contents of all of them.

use std::collections::VecDeque;

use cull::{FrameContents, FrameId, FramePlan};
use gpu::{FrameTime, Tick};

use crate::view_state::FrameOutcome;
use crate::views::ViewTarget;

/// Times that are kept for views that are not drawn at the moment; older ones are lost.
const TIMES_KEPT: usize = 8;

/// One of so many frames of a view is timed. Timestamps keep frames from overlapping: on a software
/// driver a frame that has them takes a tenth longer.
const TIMED_INTERVAL_FRAMES: u64 = 16;

/// Whether the frame after `frame` is timed.
pub(crate) fn is_turn(frame: FrameId) -> bool {
    frame.0.is_multiple_of(TIMED_INTERVAL_FRAMES)
}

/// Times that are home and that no governor was told of yet.
#[derive(Debug, Default)]
pub(crate) struct FrameTimes {
    home: VecDeque<FrameTime>,
}

impl FrameTimes {
    /// Takes the time of a frame that is over.
    pub(crate) fn take(&mut self, time: FrameTime) {
        if self.home.len() == TIMES_KEPT {
            self.home.pop_front();
        }
        self.home.push_back(time);
    }

    /// Tells governors of the frames that showed their views. Their answers are home too.
    pub(crate) fn tell(&mut self, eyes: &mut [ViewTarget<'_>]) {
        self.home.retain(|time| {
            let sent = || eyes.iter().filter_map(|eye| eye.history.sent.of(time.tick));
            let Some(views) = sent().map(|sent| sent.views).next() else { return true };
            if sent().count() == views {
                let contents = sent().fold(FrameContents::default(), |mut sum, sent| {
                    sum += sent.contents;
                    sum
                });
                for eye in eyes.iter_mut() {
                    eye.history.took(time, &contents);
                }
            }
            // Of a frame of several views that are not drawn together any more, nothing is learned.
            false
        });
    }
}

/// A frame of one view that is on its way, or whose time is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SentFrame {
    tick: Tick,
    frame: FrameId,
    contents: FrameContents,
    /// How many views the frame showed.
    views: usize,
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

    fn of(&self, tick: Tick) -> Option<&SentFrame> {
        self.frames.iter().find(|sent| sent.tick == tick)
    }
}
