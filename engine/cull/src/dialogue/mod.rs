//! Methods that need answers before a frame can go on: a conversation with the GPU.
//!
//! A [`Dialogue`] is the CPU's half of what the literature does with occlusion queries, each method
//! as it was published: it says what to draw and to test next, takes what is known so far, and may
//! say that it cannot go on without an answer. It is a pure state machine: who submits, waits and
//! polls is the executor.
//!
//! One frame:
//!
//! 1. [`Dialogue::begin`] with the strategy and the view.
//! 2. [`Conversation::next`] fills a [`Batch`] and answers with a [`Step`]. The executor records the
//!    batch: its draws in their order, those with a token under a query of their own; then its tests,
//!    front faces of the boxes only, without writing. A batch may be empty.
//! 3. [`Step::Submit`]: submits, and comes back at once with what is home. [`Step::Wait`]: submits,
//!    waits for that answer, and comes back with it and what else is home. [`Step::Done`]: the
//!    frame is complete with this batch.
//!
//! An answer may be missing after a wait: what was asked about then counts as visible. Answers that
//! come twice, or to what was never asked, are ignored. So every conversation ends, and its image is
//! that of drawing everything, for the reason in [`Margin`](crate::Margin); a visibility threshold
//! above 0 gives that up.

mod batched;
mod coherent;
mod naive;
mod stop_and_wait;
mod words;

use crate::geom::view::View;
use crate::hierarchy::Hierarchy;
use crate::hierarchy::front_to_back::Sight;
use crate::plan::strategy::Strategy;
use batched::Batched;
pub use batched::BatchedOptions;
use coherent::Coherent;
pub use coherent::{CoherentOptions, FirstPass, LeafTest};
use naive::Naive;
use stop_and_wait::StopAndWait;
pub use words::{Batch, BatchDraw, BatchTest, DialogueStats, Step, TestAnswer, TestToken};
use words::{Heard, Ledger, Method, Words};

/// The options of the methods that have some.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DialogueOptions {
    /// Of [`Strategy::Batched`].
    pub batched: BatchedOptions,
    /// Of [`Strategy::Coherent`].
    pub coherent: CoherentOptions,
}

/// The CPU's half of one view's conversations, with the history of the methods that keep one.
#[derive(Debug)]
pub struct Dialogue {
    naive: Naive,
    batched: Batched,
    stop_and_wait: StopAndWait,
    coherent: Coherent,
    ledger: Ledger,
    heard: Vec<Heard>,
}

/// One frame of a dialogue.
pub struct Conversation<'a> {
    method: &'a mut dyn Method,
    sight: Sight<'a>,
    ledger: &'a mut Ledger,
    heard: &'a mut Vec<Heard>,
    waits_for: Option<TestToken>,
    stats: DialogueStats,
}

impl Dialogue {
    /// Knows nothing yet.
    #[must_use]
    pub fn new(options: DialogueOptions) -> Self {
        Self {
            naive: Naive::default(),
            batched: Batched::new(options.batched),
            stop_and_wait: StopAndWait::default(),
            coherent: Coherent::new(options.coherent),
            ledger: Ledger::default(),
            heard: Vec::new(),
        }
    }

    /// Begins a frame; `None` for a strategy that is no dialogue
    /// ([`Strategy::is_dialogue`]).
    pub fn begin<'a>(
        &'a mut self,
        hierarchy: &'a Hierarchy,
        strategy: Strategy,
        view: &'a View,
    ) -> Option<Conversation<'a>> {
        let method: &mut dyn Method = match strategy {
            Strategy::Naive => &mut self.naive,
            Strategy::Batched => &mut self.batched,
            Strategy::StopAndWait => &mut self.stop_and_wait,
            Strategy::Coherent => &mut self.coherent,
            _ => return None,
        };
        self.ledger.clear();
        let sight = Sight { hierarchy, view };
        let mut stats = DialogueStats::default();
        method.begin(&sight, &mut stats);
        let (ledger, heard) = (&mut self.ledger, &mut self.heard);
        Some(Conversation { method, sight, ledger, heard, waits_for: None, stats })
    }
}

impl Conversation<'_> {
    /// Takes what is home since the last call and says what to do next; `batch` is reused. After
    /// [`Step::Done`] there is nothing more to say.
    pub fn next(&mut self, answers: &[TestAnswer], batch: &mut Batch) -> Step {
        batch.clear();
        self.heard.clear();
        for answer in answers {
            let node = self.ledger.settle(answer.token);
            self.heard.extend(node.map(|node| Heard { node, samples: answer.samples }));
        }
        // What was waited for and did not come counts as visible.
        if let Some(node) = self.waits_for.take().and_then(|token| self.ledger.settle(token)) {
            self.heard.push(Heard { node, samples: u32::MAX });
        }
        let mut words =
            Words { sight: self.sight, batch, ledger: self.ledger, stats: &mut self.stats };
        let step = self.method.next(self.heard, &mut words);
        self.stats.batches += 1;
        if let Step::Wait(token) = step {
            self.stats.waits += 1;
            self.waits_for = Some(token);
        }
        step
    }

    /// What happened so far.
    #[must_use]
    pub fn stats(&self) -> DialogueStats {
        self.stats
    }
}
