//! The outcomes of frames, in the order of the frames.

use std::collections::VecDeque;

use cull::{Answer, FrameId, QueryKind, TestResult};

use crate::leaf_table::LeafCount;

/// The outcome of a frame, known once its results are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameStats {
    /// The number of the frame in its view.
    pub frame: FrameId,
    /// The number of objects that the GPU drew, either taken as visible or revealed by a test.
    pub draws: u64,
    /// The number of triangles of these objects. For leaves that were tested individually,
    /// triangles are counted when results are read: if a leaf was reused meanwhile, the triangles
    /// of its new object count.
    pub triangles: u64,
    /// The objects among `draws` that a test revealed.
    pub revealed: u64,
    /// The number of samples in tests that passed but not above the threshold, so that their leaves
    /// were not drawn: at most this number of pixels is wrong. 0 without a threshold.
    pub samples_below_threshold: u64,
}

/// An outcome that is not reported yet, since frames are reported in their order.
#[derive(Clone, Copy, Debug)]
struct Pending {
    outcome: FrameStats,
    /// True if nothing was tested, so no results are to come.
    is_known: bool,
}

/// The highest number of outcomes kept until the caller takes them.
const OUTCOMES_KEPT: usize = 1024;

/// The outcomes of one view's frames: outcomes that wait for results, and known ones that have not
/// been taken yet.
#[derive(Debug, Default)]
pub struct Outcomes {
    pending: VecDeque<Pending>,
    known: VecDeque<FrameStats>,
    newest: Option<FrameStats>,
}

impl Outcomes {
    /// Adds a submitted frame. Returns its outcome if this and all earlier outcomes are known.
    pub(crate) fn push(&mut self, outcome: FrameStats, is_known: bool) -> Option<FrameStats> {
        if is_known && self.pending.is_empty() {
            self.keep(outcome);
            return Some(outcome);
        }
        self.pending.push_back(Pending { outcome, is_known });
        None
    }

    /// Returns the outcome of a frame that is not reported yet.
    pub fn of(&mut self, frame: FrameId) -> Option<&mut FrameStats> {
        let mut outcomes = self.pending.iter_mut().map(|pending| &mut pending.outcome);
        outcomes.find(|outcome| outcome.frame == frame)
    }

    /// Adds the draws of a result to the outcome of its frame, or its samples below the threshold.
    pub(crate) fn add(&mut self, result: &TestResult<LeafCount>) {
        let Answer { tag, samples } = result.answer;
        let is_drawn = matches!(tag.kind, QueryKind::Proxy | QueryKind::Leaf);
        let Some(outcome) = self.of(tag.frame) else { return };
        if !result.answer.shows() {
            let decides = is_drawn || tag.kind == QueryKind::PerLeaf;
            outcome.samples_below_threshold += u64::from(samples) * u64::from(decides);
        } else if is_drawn {
            outcome.draws += result.contents.draws;
            outcome.revealed += result.contents.draws;
            outcome.triangles += result.contents.triangles;
        }
    }

    /// Takes the next known outcome. The results of all frames up to `newest` have been read.
    pub(crate) fn settle(&mut self, newest: Option<FrameId>) -> Option<FrameStats> {
        let is_over = |pending: &mut Pending| {
            pending.is_known || newest.is_some_and(|newest| pending.outcome.frame <= newest)
        };
        let Pending { outcome, .. } = self.pending.pop_front_if(is_over)?;
        self.keep(outcome);
        Some(outcome)
    }

    /// Forgets the unknown outcomes, whose results were dropped.
    pub(crate) fn forget_pending(&mut self) {
        self.pending.clear();
    }

    /// Takes all known outcomes, at most the latest 1024.
    pub(crate) fn take(&mut self) -> std::collections::vec_deque::Drain<'_, FrameStats> {
        self.known.drain(..)
    }

    fn keep(&mut self, outcome: FrameStats) {
        if self.known.len() == OUTCOMES_KEPT {
            self.known.pop_front();
        }
        self.known.push_back(outcome);
        self.newest = Some(outcome);
    }

    /// Returns the newest known outcome, even if it was already taken.
    pub(crate) fn newest(&self) -> Option<FrameStats> {
        self.newest
    }
}
