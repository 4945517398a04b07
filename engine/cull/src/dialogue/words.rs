//! What a method and the GPU say to each other in a frame: batches, steps, answers.

use crate::geom::bounds::Aabb;
use crate::hierarchy::front_to_back::Sight;
use crate::ids::{LeafIndex, NodeId};

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

    pub(super) fn clear(&mut self) {
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

/// One of the methods.
pub(super) trait Method {
    /// Begins a frame.
    fn begin(&mut self, sight: &Sight<'_>, stats: &mut DialogueStats);

    /// Takes answers, each of them once, and says what to do next.
    fn next(&mut self, heard: &[Heard], words: &mut Words<'_>) -> Step;
}

/// An answer, to whoever asked about a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heard {
    pub(super) node: NodeId,
    pub(super) samples: u32,
}

/// What a method says.
pub(super) struct Words<'a> {
    pub(super) sight: Sight<'a>,
    pub(super) batch: &'a mut Batch,
    pub(super) ledger: &'a mut Ledger,
    pub(super) stats: &'a mut DialogueStats,
}

impl Words<'_> {
    /// Draws a leaf.
    pub(super) fn draw(&mut self, node: NodeId) {
        self.stats.draws += 1;
        self.batch.draws.push(BatchDraw { leaf: self.sight.leaf(node), token: None });
    }

    /// Draws a leaf and asks how much of it shows.
    pub(super) fn draw_asking(&mut self, node: NodeId) {
        self.stats.draws += 1;
        self.stats.own_draws += 1;
        let token = Some(self.ledger.ask(node));
        self.batch.draws.push(BatchDraw { leaf: self.sight.leaf(node), token });
    }

    /// Asks whether a node's box shows.
    pub(super) fn ask(&mut self, node: NodeId, bounds: Aabb) -> TestToken {
        self.stats.boxes += 1;
        let token = self.ledger.ask(node);
        self.batch.tests.push(BatchTest { token, bounds });
        token
    }

    /// The box to test in place of a node; `None`, counted, where it must count as visible.
    pub(super) fn proxy(&mut self, node: NodeId) -> Option<Aabb> {
        let proxy = self.sight.proxy(node);
        self.stats.too_near += u32::from(proxy.is_none());
        proxy
    }
}

/// The questions of one frame and which of them are open.
#[derive(Debug, Default)]
pub(super) struct Ledger {
    /// The node that each question is about, until it is answered.
    asked: Vec<Option<NodeId>>,
    /// All questions before this one are answered.
    oldest: usize,
}

impl Ledger {
    pub(super) fn clear(&mut self) {
        self.asked.clear();
        self.oldest = 0;
    }

    pub(super) fn ask(&mut self, node: NodeId) -> TestToken {
        let token = TestToken(self.asked.len() as u32);
        self.asked.push(Some(node));
        token
    }

    /// Closes a question; `None` if it is not open.
    pub(super) fn settle(&mut self, token: TestToken) -> Option<NodeId> {
        self.asked.get_mut(token.0 as usize)?.take()
    }

    /// The oldest open question.
    pub(super) fn oldest_open(&mut self) -> Option<TestToken> {
        while self.asked.get(self.oldest)?.is_none() {
            self.oldest += 1;
        }
        Some(TestToken(self.oldest as u32))
    }
}
