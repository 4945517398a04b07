//! Methods that need results of a frame within this frame.
//!
//! A [`BlockingCuller`] is the CPU's part of the published methods with occlusion queries, each as
//! in its paper. It returns what to draw and to test next, takes the results so far, and may have
//! to wait for a result. It is a pure state machine: the executor submits, waits and polls.
//!
//! One frame:
//!
//! 1. [`BlockingCuller::begin`] with the hierarchy and the view.
//! 2. [`BlockingFrame::next`] fills a [`Batch`] and returns a [`NextAction`]. The executor records
//!    the batch: first its draws in their order, each under a query if it has a token, then its
//!    tests, front faces of the boxes only, without writing. A batch may be empty.
//! 3. For [`NextAction::Submit`] the executor submits, and calls again at once with the available
//!    results. For [`NextAction::Wait`] it submits, waits for this result, and calls again with all
//!    available results. After [`NextAction::Done`] the frame is complete with this batch.
//!
//! A result may be missing after a wait: its node then counts as visible. Results that come twice,
//! or that belong to queries never sent, are ignored. So every frame ends, and its image is the
//! same as with everything drawn, for the reason in [`Margin`](crate::Margin). A visibility
//! threshold above 0 gives this exactness up.

mod batched;
mod chc;
mod naive;
mod recorder;
mod stop_and_wait;

use crate::geom::view::CullView;
use crate::hierarchy::Hierarchy;
use crate::hierarchy::front_to_back::ViewedHierarchy;
use batched::Batched;
pub use batched::BatchedOptions;
use chc::Chc;
pub use chc::{ChcOptions, FirstPass, LeafTest};
use naive::Naive;
pub use recorder::{Batch, BatchDraw, BatchTest, BlockingStats, NextAction, TestAnswer, TestToken};
use recorder::{BlockingStrategy, PendingQueries, QueryResult, Recorder};
use stop_and_wait::StopAndWait;

/// The blocking methods of the literature, with their options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlockingKind {
    /// A query per object and a wait for each (GPU Gems, 29.2).
    Naive,
    /// A query per object after some large occluders, and a wait for all queries (GPU Gems, 29.3).
    Batched(BatchedOptions),
    /// The hierarchy from the root down, with a wait at each node (GPU Gems 2, 6.3).
    StopAndWait,
    /// Coherent hierarchical culling as published, with several submits per frame and results read
    /// between them (GPU Gems 2, 6.4 and 6.5).
    Chc(ChcOptions),
}

impl BlockingKind {
    /// Returns true if its queries must count samples, because it has a threshold above 0.
    #[must_use]
    pub const fn counts_samples(&self) -> bool {
        matches!(self, Self::Chc(options) if options.visibility_threshold_samples > 0)
    }

    /// Returns the contents of its batches: the shaded image, or only its depth.
    #[must_use]
    pub const fn first_pass(&self) -> FirstPass {
        match self {
            Self::Chc(options) => options.first_pass,
            Self::Naive | Self::Batched(_) | Self::StopAndWait => FirstPass::Shaded,
        }
    }
}

/// The CPU's part of a blocking method for one view, with its history if the method has one.
#[derive(Debug)]
pub struct BlockingCuller {
    strategy: Box<dyn BlockingStrategy>,
    pending: PendingQueries,
    results: Vec<QueryResult>,
}

/// One frame of a blocking method.
pub struct BlockingFrame<'a> {
    strategy: &'a mut dyn BlockingStrategy,
    viewed: ViewedHierarchy<'a>,
    pending: &'a mut PendingQueries,
    results: &'a mut Vec<QueryResult>,
    waits_for: Option<TestToken>,
    stats: BlockingStats,
}

impl BlockingCuller {
    /// Creates a culler without history.
    #[must_use]
    pub fn new(kind: BlockingKind) -> Self {
        let strategy: Box<dyn BlockingStrategy> = match kind {
            BlockingKind::Naive => Box::new(Naive::default()),
            BlockingKind::Batched(options) => Box::new(Batched::new(options)),
            BlockingKind::StopAndWait => Box::new(StopAndWait::default()),
            BlockingKind::Chc(options) => Box::new(Chc::new(options)),
        };
        Self { strategy, pending: PendingQueries::default(), results: Vec::new() }
    }

    /// Begins a frame.
    pub fn begin<'a>(
        &'a mut self,
        hierarchy: &'a Hierarchy,
        view: &'a CullView,
    ) -> BlockingFrame<'a> {
        self.pending.clear();
        let viewed = ViewedHierarchy { hierarchy, view };
        let mut stats = BlockingStats::default();
        self.strategy.begin(&viewed, &mut stats);
        let Self { strategy, pending, results } = self;
        let strategy = strategy.as_mut();
        BlockingFrame { strategy, viewed, pending, results, waits_for: None, stats }
    }
}

impl BlockingFrame<'_> {
    /// Takes the results since the last call and returns what to do next. Overwrites `batch`. After
    /// [`NextAction::Done`] the frame has no further actions.
    pub fn next(&mut self, answers: &[TestAnswer], batch: &mut Batch) -> NextAction {
        batch.clear();
        self.results.clear();
        for answer in answers {
            let node = self.pending.settle(answer.token);
            self.results.extend(node.map(|node| QueryResult { node, samples: answer.samples }));
        }
        // A node counts as visible if its result was waited for and did not arrive.
        if let Some(node) = self.waits_for.take().and_then(|token| self.pending.settle(token)) {
            self.results.push(QueryResult { node, samples: u32::MAX });
        }
        let mut recorder =
            Recorder { viewed: self.viewed, batch, pending: self.pending, stats: &mut self.stats };
        let step = self.strategy.next(self.results, &mut recorder);
        self.stats.batches += 1;
        if let NextAction::Wait(token) = step {
            self.stats.waits += 1;
            self.waits_for = Some(token);
        }
        step
    }

    /// Returns the counts so far.
    #[must_use]
    pub fn stats(&self) -> BlockingStats {
        self.stats
    }
}
