//! The messages between the culler and whoever drives the GPU: a plan out, answers back.

use std::ops::Range;

use crate::bounds::Aabb;
use crate::ids::{FrameId, Generation, LeafIndex, LeafRange, NodeId};

/// What a query was for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum QueryKind {
    /// A node's proxy, whose leaves are drawn if it shows.
    Proxy,
    /// A node's proxy that nothing hangs on: its parts are tested or drawn on their own, and the
    /// answer says whether they could share one query from now on. Its range of leaves is empty.
    Probe,
    /// The draw of a leaf that is taken as visible.
    OwnDraw,
}

/// Goes with a query to the GPU and comes back with its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QueryTag {
    /// The node that was asked about.
    pub node: NodeId,
    /// The generation of the hierarchy that the node belongs to.
    pub generation: Generation,
    /// The frame that asked.
    pub frame: FrameId,
    /// What was drawn under the query.
    pub kind: QueryKind,
}

/// The result of a query. It may come late, never, twice, and in any order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// As it was given out in the plan.
    pub tag: QueryTag,
    /// Samples that passed; where queries are not precise, any number but 0 for "some".
    pub samples: u32,
}

/// One node of the frontier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProxyTest {
    /// For the query.
    pub tag: QueryTag,
    /// The box to test, enlarged already by the view's [margin](crate::Margin).
    pub bounds: Aabb,
    /// What to draw in this same frame if a sample of the box shows; empty for a probe.
    pub leaves: LeafRange,
    /// How deep the node lies, for views that explain what happens.
    pub level: u32,
}

/// What a frame draws and asks.
///
/// To be executed in this order: `draws`; `queried_draws`, each under its query; then for every
/// range of `rounds`: test the proxies of the range against the depth so far, front faces only,
/// without writing; draw the leaves of those that show.
///
/// Every leaf whose box meets the frustum is in exactly one place: in `draws`, in `queried_draws`
/// or in the range of one test.
#[derive(Clone, Debug)]
pub struct FramePlan {
    /// The frame that this is the plan of.
    pub frame: FrameId,
    /// Taken as visible, front to back.
    pub draws: Vec<LeafIndex>,
    /// Taken as visible and asked about on their own draw; front to back, after `draws`.
    pub queried_draws: Vec<(LeafIndex, QueryTag)>,
    /// The frontier, front to back.
    pub tests: Vec<ProxyTest>,
    /// Contiguous slabs of `tests`, front to back, none empty.
    pub rounds: Vec<Range<usize>>,
    /// What happened on the way.
    pub stats: PlanStats,
}

impl Default for FramePlan {
    fn default() -> Self {
        Self {
            frame: FrameId(0),
            draws: Vec::new(),
            queried_draws: Vec::new(),
            tests: Vec::new(),
            rounds: Vec::new(),
            stats: PlanStats::default(),
        }
    }
}

impl FramePlan {
    /// Queries that the plan asks for.
    #[must_use]
    pub fn query_count(&self) -> usize {
        self.tests.len() + self.queried_draws.len()
    }

    pub(crate) fn clear(&mut self, frame: FrameId) {
        self.frame = frame;
        self.draws.clear();
        self.queried_draws.clear();
        self.tests.clear();
        self.rounds.clear();
        self.stats = PlanStats::default();
    }
}

/// Counts of one plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlanStats {
    /// Nodes taken from the queue: the work of the traversal. All attempts together, if the
    /// first had more tests than queries.
    pub nodes_visited: u32,
    /// Tests that decide about draws.
    pub frontier: u32,
    /// Leaves under these tests.
    pub tested_leaves: u32,
    /// Tests among them of which nothing was known before.
    pub unknown: u32,
    /// Tests that decide about nothing but the next frames.
    pub probes: u32,
    /// Leaves drawn because they were visible, queried or not.
    pub visible: u32,
    /// Leaves drawn because their proxy would be cut by the near plane.
    pub too_near: u32,
    /// Leaves drawn to have occluders when nothing is known.
    pub occluders: u32,
    /// Leaves drawn because there were too few queries to test them.
    pub over_budget: u32,
    /// How often the allowed size of tested nodes was raised to make do with fewer tests.
    pub coarsened: u32,
}

impl std::ops::AddAssign for PlanStats {
    /// Of several plans together; `coarsened` is that of the coarsest.
    fn add_assign(&mut self, other: Self) {
        self.nodes_visited += other.nodes_visited;
        self.frontier += other.frontier;
        self.tested_leaves = self.tested_leaves.saturating_add(other.tested_leaves);
        self.unknown += other.unknown;
        self.probes += other.probes;
        self.visible += other.visible;
        self.too_near += other.too_near;
        self.occluders += other.occluders;
        self.over_budget += other.over_budget;
        self.coarsened = self.coarsened.max(other.coarsened);
    }
}
