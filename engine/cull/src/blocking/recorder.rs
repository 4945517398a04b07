//! What a method and the GPU say to each other in a frame: batches, steps, answers.

use crate::geom::bounds::Aabb;
use crate::hierarchy::front_to_back::ViewedHierarchy;
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
    /// Returns true if there is nothing to do.
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
pub enum NextAction {
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
pub struct BlockingStats {
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
    /// Samples of boxes that showed and whose leaves were left out all the same: at most so many
    /// pixels are wrong.
    pub neglected_samples: u64,
}

/// One of the methods.
pub(super) trait BlockingStrategy {
    /// Begins a frame.
    fn begin(&mut self, viewed: &ViewedHierarchy<'_>, stats: &mut BlockingStats);

    /// Takes answers, each of them once, and says what to do next.
    fn next(&mut self, results: &[QueryResult], recorder: &mut Recorder<'_>) -> NextAction;
}

/// An answer, to whoever asked about a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct QueryResult {
    pub(super) node: NodeId,
    pub(super) samples: u32,
}

/// What a method says.
pub(super) struct Recorder<'a> {
    pub(super) viewed: ViewedHierarchy<'a>,
    pub(super) batch: &'a mut Batch,
    pub(super) pending: &'a mut PendingQueries,
    pub(super) stats: &'a mut BlockingStats,
}

impl Recorder<'_> {
    /// Draws a leaf.
    pub(super) fn draw(&mut self, node: NodeId) {
        self.stats.draws += 1;
        self.batch.draws.push(BatchDraw { leaf: self.viewed.leaf(node), token: None });
    }

    /// Draws a leaf and asks how much of it shows.
    pub(super) fn draw_asking(&mut self, node: NodeId) {
        self.stats.draws += 1;
        self.stats.own_draws += 1;
        let token = Some(self.pending.ask(node));
        self.batch.draws.push(BatchDraw { leaf: self.viewed.leaf(node), token });
    }

    /// Asks whether a node's box shows.
    pub(super) fn ask(&mut self, node: NodeId, bounds: Aabb) -> TestToken {
        self.stats.boxes += 1;
        let token = self.pending.ask(node);
        self.batch.tests.push(BatchTest { token, bounds });
        token
    }

    /// Returns the box to test in place of a node; `None`, counted, where it must count as visible.
    pub(super) fn proxy(&mut self, node: NodeId) -> Option<Aabb> {
        let proxy = self.viewed.proxy(node);
        self.stats.too_near += u32::from(proxy.is_none());
        proxy
    }
}

/// The questions of one frame and which of them are open.
#[derive(Debug, Default)]
pub(super) struct PendingQueries {
    /// The node that each question is about, until it is answered.
    asked: Vec<Option<NodeId>>,
    /// All questions before this one are answered.
    oldest: usize,
}

impl PendingQueries {
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

    /// Returns the oldest open question.
    pub(super) fn oldest_open(&mut self) -> Option<TestToken> {
        while self.asked.get(self.oldest)?.is_none() {
            self.oldest += 1;
        }
        Some(TestToken(self.oldest as u32))
    }
}
