//! What frames turned out to be, in the order of the frames.

use std::collections::VecDeque;

use cull::{Answer, FrameId, QueryKind, TestResult};

use crate::leaf_table::LeafCount;

/// The outcome of a frame, known once its results are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameOutcome {
    /// The frame.
    pub frame: FrameId,
    /// Objects the GPU drew: those taken as visible and those whose proxy showed.
    pub draws: u64,
    /// Triangles of those objects. Where leaves were drawn one by one, as many as they have when
    /// that is known: if others moved in meanwhile, those count.
    pub triangles: u64,
    /// Objects among `draws` that were drawn because a proxy showed.
    pub revealed: u64,
    /// Samples of tests that showed, but not more than the threshold, so that what they stand for
    /// was left out: at most so many pixels are wrong. 0 without a threshold.
    pub neglected_samples: u64,
}

/// An outcome that is not known yet: frames are reported in their order.
#[derive(Clone, Copy, Debug)]
struct Pending {
    outcome: FrameOutcome,
    /// Nothing was asked, so that no result is to come.
    is_known: bool,
}

/// Outcomes that are kept for who asks seldom, or never.
const OUTCOMES_KEPT: usize = 1024;

/// The outcomes of one view's frames: those whose results are to come, and those that nobody took
/// yet.
#[derive(Debug, Default)]
pub struct Outcomes {
    pending: VecDeque<Pending>,
    known: VecDeque<FrameOutcome>,
}

impl Outcomes {
    /// Adds a frame that was submitted. Returns its outcome if that is known and no earlier one is
    /// not.
    pub(crate) fn push(&mut self, outcome: FrameOutcome, is_known: bool) -> Option<FrameOutcome> {
        if is_known && self.pending.is_empty() {
            self.keep(outcome);
            return Some(outcome);
        }
        self.pending.push_back(Pending { outcome, is_known });
        None
    }

    /// Returns the outcome of a frame that is not known yet.
    pub fn of(&mut self, frame: FrameId) -> Option<&mut FrameOutcome> {
        let mut outcomes = self.pending.iter_mut().map(|pending| &mut pending.outcome);
        outcomes.find(|outcome| outcome.frame == frame)
    }

    /// Adds to the outcome of its frame what a result drew, or what was neglected by the threshold.
    pub(crate) fn add(&mut self, result: &TestResult<LeafCount>, threshold_samples: u32) {
        let Answer { tag, samples } = result.answer;
        let is_drawn = matches!(tag.kind, QueryKind::Proxy | QueryKind::Leaf);
        let Some(outcome) = self.of(tag.frame) else { return };
        if !result.shows(threshold_samples) {
            let decides = is_drawn || tag.kind == QueryKind::PerLeaf;
            outcome.neglected_samples += u64::from(samples) * u64::from(decides);
        } else if is_drawn {
            outcome.draws += result.contents.draws;
            outcome.revealed += result.contents.draws;
            outcome.triangles += result.contents.triangles;
        }
    }

    /// Takes the next outcome that is known: no results of frames up to `newest` are to come.
    pub(crate) fn settle(&mut self, newest: Option<FrameId>) -> Option<FrameOutcome> {
        let is_over = |it: &mut Pending| {
            it.is_known || newest.is_some_and(|newest| it.outcome.frame <= newest)
        };
        let Pending { outcome, .. } = self.pending.pop_front_if(is_over)?;
        self.keep(outcome);
        Some(outcome)
    }

    /// Forgets what is not known: its results were dropped.
    pub(crate) fn forget_pending(&mut self) {
        self.pending.clear();
    }

    /// Takes all that are known: the latest 1024, if there are more.
    pub(crate) fn take(&mut self) -> std::collections::vec_deque::Drain<'_, FrameOutcome> {
        self.known.drain(..)
    }

    fn keep(&mut self, outcome: FrameOutcome) {
        if self.known.len() == OUTCOMES_KEPT {
            self.known.pop_front();
        }
        self.known.push_back(outcome);
    }
}
