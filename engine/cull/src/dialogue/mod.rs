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

use crate::bounds::Aabb;
use crate::front_to_back::Sight;
use crate::hierarchy::Hierarchy;
use crate::ids::{LeafIndex, NodeId};
use crate::strategy::Strategy;
use crate::view::View;
use batched::Batched;
pub use batched::BatchedOptions;
use coherent::Coherent;
pub use coherent::{CoherentOptions, FirstPass, LeafTest};
use naive::Naive;
use stop_and_wait::StopAndWait;

/// A question of one frame. They are numbered from 0 in the order in which they are asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TestToken(pub u32);

/// A leaf to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchDraw {
    /// The leaf.
    pub leaf: LeafIndex,
    /// The question whose answer is the number of samples that the draw leaves.
    pub token: Option<TestToken>,
}

/// A box to test against the depth so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchTest {
    /// The question.
    pub token: TestToken,
    /// The box, enlarged already by the view's [margin](crate::Margin).
    pub bounds: Aabb,
}

/// What to do next: first all draws, then all tests.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// To draw, in this order.
    pub draws: Vec<BatchDraw>,
    /// To test.
    pub tests: Vec<BatchTest>,
}

impl Batch {
    /// True if there is nothing to do.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.draws.is_empty() && self.tests.is_empty()
    }

    fn clear(&mut self) {
        self.draws.clear();
        self.tests.clear();
    }
}

/// What to do once a batch is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Send it off and come back with what is home.
    Submit,
    /// Send it off, wait for the answer to this question, and come back with all that is home.
    Wait(TestToken),
    /// Nothing more is asked: the frame ends with this batch.
    Done,
}

/// What the GPU says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TestAnswer {
    /// To which question.
    pub token: TestToken,
    /// Samples that passed; where queries are not precise, any number but 0 for "some".
    pub samples: u32,
}

/// The options of the methods that have some.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DialogueOptions {
    /// Of [`Strategy::Batched`].
    pub batched: BatchedOptions,
    /// Of [`Strategy::Coherent`].
    pub coherent: CoherentOptions,
}

/// Counts of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DialogueStats {
    /// Nodes looked at.
    pub nodes_visited: u32,
    /// Boxes tested.
    pub boxes: u32,
    /// Leaves drawn under a query of their own.
    pub own_draws: u32,
    /// Leaves drawn.
    pub draws: u32,
    /// Nodes whose box would be cut by the near plane: visible without a test.
    pub too_near: u32,
    /// Times that it could not go on without an answer.
    pub waits: u32,
    /// Batches, the last one included.
    pub batches: u32,
    /// Samples of boxes that showed and whose leaves were left out all the same: at most so many pixels
    /// are wrong.
    pub neglected_samples: u64,
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

/// One of the methods.
trait Method {
    /// Begins a frame.
    fn begin(&mut self, sight: &Sight<'_>, stats: &mut DialogueStats);

    /// Takes answers, each of them once, and says what to do next.
    fn next(&mut self, heard: &[Heard], words: &mut Words<'_>) -> Step;
}

/// An answer, to whoever asked about a node.
#[derive(Clone, Copy, Debug)]
struct Heard {
    node: NodeId,
    samples: u32,
}

/// What a method says.
struct Words<'a> {
    sight: Sight<'a>,
    batch: &'a mut Batch,
    ledger: &'a mut Ledger,
    stats: &'a mut DialogueStats,
}

impl Words<'_> {
    /// Draws a leaf.
    fn draw(&mut self, node: NodeId) {
        self.stats.draws += 1;
        self.batch.draws.push(BatchDraw { leaf: self.sight.leaf(node), token: None });
    }

    /// Draws a leaf and asks how much of it shows.
    fn draw_asking(&mut self, node: NodeId) {
        self.stats.draws += 1;
        self.stats.own_draws += 1;
        let token = Some(self.ledger.ask(node));
        self.batch.draws.push(BatchDraw { leaf: self.sight.leaf(node), token });
    }

    /// Asks whether a node's box shows.
    fn ask(&mut self, node: NodeId, bounds: Aabb) -> TestToken {
        self.stats.boxes += 1;
        let token = self.ledger.ask(node);
        self.batch.tests.push(BatchTest { token, bounds });
        token
    }

    /// The box to test in place of a node; `None`, counted, where it must count as visible.
    fn proxy(&mut self, node: NodeId) -> Option<Aabb> {
        let proxy = self.sight.proxy(node);
        self.stats.too_near += u32::from(proxy.is_none());
        proxy
    }
}

/// The questions of one frame and which of them are open.
#[derive(Debug, Default)]
struct Ledger {
    /// The node that each question is about, until it is answered.
    asked: Vec<Option<NodeId>>,
    /// All questions before this one are answered.
    oldest: usize,
}

impl Ledger {
    fn clear(&mut self) {
        self.asked.clear();
        self.oldest = 0;
    }

    fn ask(&mut self, node: NodeId) -> TestToken {
        let token = TestToken(self.asked.len() as u32);
        self.asked.push(Some(node));
        token
    }

    /// Closes a question; `None` if it is not open.
    fn settle(&mut self, token: TestToken) -> Option<NodeId> {
        self.asked.get_mut(token.0 as usize)?.take()
    }

    /// The oldest open question.
    fn oldest_open(&mut self) -> Option<TestToken> {
        while self.asked.get(self.oldest)?.is_none() {
            self.oldest += 1;
        }
        Some(TestToken(self.oldest as u32))
    }
}
