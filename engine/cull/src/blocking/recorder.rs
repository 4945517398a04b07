//! The messages between a method and the GPU within a frame: batches, actions, results.

use std::fmt;

use crate::geom::bounds::Aabb;
use crate::hierarchy::front_to_back::ViewedHierarchy;
use crate::ids::{LeafIndex, NodeId};

/// A query of one frame. Queries are numbered from 0 in the order in which they are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TestToken(pub u32);

/// A leaf to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchDraw {
    /// The leaf that is drawn, under a query if there is a token.
    pub leaf: LeafIndex,
    /// The query that counts the samples of the draw.
    pub token: Option<TestToken>,
}

/// A box to test against the depth so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchTest {
    /// The identity of the query, unique within its frame.
    pub token: TestToken,
    /// The box, already enlarged by the view's [margin](crate::Margin).
    pub bounds: Aabb,
}

/// The commands to record next: first all draws, then all tests.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// The draws, in the order of recording.
    pub draws: Vec<BatchDraw>,
    /// The boxes to test after the draws, in the order of recording.
    pub tests: Vec<BatchTest>,
}

impl Batch {
    /// Returns true if there are no draws and no tests.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.draws.is_empty() && self.tests.is_empty()
    }

    pub(super) fn clear(&mut self) {
        self.draws.clear();
        self.tests.clear();
    }
}

/// The next step after a batch is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NextAction {
    /// Submit the batch, and call again with the available results.
    Submit,
    /// Submit the batch, wait for the result of this query, and call again with all available
    /// results.
    Wait(TestToken),
    /// Submit the batch, which is the last of the frame.
    Done,
}

/// The result of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TestAnswer {
    /// The identity of the query, unique within its frame.
    pub token: TestToken,
    /// The number of samples that passed; any number but 0 for "some" if queries are not precise.
    pub samples: u32,
}

/// Counts of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlockingStats {
    /// Nodes of the hierarchy that the traversal visited.
    pub nodes_visited: u32,
    /// Boxes of nodes and leaves tested by a query each.
    pub boxes: u32,
    /// Leaves drawn under a query on the draw.
    pub visible_draw_queries: u32,
    /// Leaves drawn, with or without a query.
    pub draws: u32,
    /// Nodes whose box the near plane would cut: visible without a test.
    pub too_near: u32,
    /// Waits for a result.
    pub waits: u32,
    /// Batches, including the last one.
    pub batches: u32,
    /// Samples of boxes that showed although their leaves were not drawn: the most pixels that can
    /// be wrong.
    pub samples_below_threshold: u64,
}

/// A blocking method.
pub(super) trait BlockingStrategy: fmt::Debug + Send {
    /// Begins a frame.
    fn begin(&mut self, viewed: &ViewedHierarchy<'_>, stats: &mut BlockingStats);

    /// Takes results, each once, and returns what to do next.
    fn next(&mut self, results: &[QueryResult], recorder: &mut Recorder<'_>) -> NextAction;
}

/// A result with the tested node.
#[derive(Clone, Copy, Debug)]
pub(super) struct QueryResult {
    pub(super) node: NodeId,
    pub(super) samples: u32,
}

/// The recorder of a method's commands.
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

    /// Draws a leaf under a query.
    pub(super) fn draw_under_query(&mut self, node: NodeId) {
        self.stats.draws += 1;
        self.stats.visible_draw_queries += 1;
        let token = Some(self.pending.begin(node));
        self.batch.draws.push(BatchDraw { leaf: self.viewed.leaf(node), token });
    }

    /// Tests a node's box.
    pub(super) fn test(&mut self, node: NodeId, bounds: Aabb) -> TestToken {
        self.stats.boxes += 1;
        let token = self.pending.begin(node);
        self.batch.tests.push(BatchTest { token, bounds });
        token
    }

    /// Returns the box to test in place of a node. Counts and returns `None` for a node that must
    /// count as visible.
    pub(super) fn proxy(&mut self, node: NodeId) -> Option<Aabb> {
        let proxy = self.viewed.proxy(node);
        self.stats.too_near += u32::from(proxy.is_none());
        proxy
    }
}

/// The queries of one frame, and which of them are open.
#[derive(Debug, Default)]
pub(super) struct PendingQueries {
    /// The tested node of each query, until its result arrives.
    nodes: Vec<Option<NodeId>>,
    /// The first query that may be open: all queries before it have results.
    oldest: usize,
}

impl PendingQueries {
    pub(super) fn clear(&mut self) {
        self.nodes.clear();
        self.oldest = 0;
    }

    pub(super) fn begin(&mut self, node: NodeId) -> TestToken {
        let token = TestToken(self.nodes.len() as u32);
        self.nodes.push(Some(node));
        token
    }

    /// Closes a query; `None` if it is not open.
    pub(super) fn settle(&mut self, token: TestToken) -> Option<NodeId> {
        self.nodes.get_mut(token.0 as usize)?.take()
    }

    pub(super) fn oldest_open(&mut self) -> Option<TestToken> {
        while self.nodes.get(self.oldest)?.is_none() {
            self.oldest += 1;
        }
        Some(TestToken(self.oldest as u32))
    }
}
