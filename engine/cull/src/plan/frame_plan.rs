//! The messages between the culler and the executor on the GPU: a plan out, answers back.

use std::ops::Range;

use crate::geom::bounds::Aabb;
use crate::ids::{FrameId, Generation, LeafIndex, LeafRange, NodeId};
use crate::plan::strategy::Strategy;

/// The purpose of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum QueryKind {
    /// A node's proxy: the node's leaves are drawn if the proxy shows.
    Proxy,
    /// A node's proxy on which no draw depends: the node's parts are tested or drawn individually.
    /// If the proxy does not show, the parts can share one query from now on. The range of leaves
    /// is empty.
    PullUpQuery,
    /// A node's proxy; if it shows, the proxies of its leaves decide which of them are drawn.
    PerLeaf,
    /// The proxy of a leaf under a node of [`QueryKind::PerLeaf`] that showed. Such an answer
    /// exists only for leaves that show, and it comes after the answer of the node.
    Leaf,
    /// The proxy of a leaf that is drawn as visible. The range of leaves is empty.
    VisibleBoxQuery,
    /// The draw of a leaf that is taken as visible. In plans of [`DrawPhases::Two`], and without
    /// queries, the leaf's proxy with an empty range of leaves.
    VisibleDrawQuery,
}

/// The mechanism that tests a proxy. All mechanisms give the same result except for rounding, at
/// different costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum VisibilityTest {
    /// A flag that the fragments of the proxy set.
    Flag,
    /// An occlusion query.
    #[default]
    Query,
    /// A compute shader that compares the box with the depth buffer.
    Compute,
    /// The flag of another test, given by its index in the plan, whose proxy lies in front of this
    /// proxy: while the other proxy is hidden, so is this one. The other test is in the same round
    /// or an earlier one.
    SharedProxy(u32),
}

impl VisibilityTest {
    /// Returns the name of the tester in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flag => "flags",
            Self::Query => "queries",
            Self::Compute => "compute",
            Self::SharedProxy(_) => "shared proxies",
        }
    }
}

/// The places of the draws among the tests of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DrawPhases {
    /// Draws between the rounds of tests, and queries around draws of visible leaves. For renderers
    /// that can be called back while they record a frame.
    #[default]
    PerRound,
    /// All visible draws, then all tests in one round, then all draws that the tests reveal.
    /// Visible leaves are tested by their boxes instead of by their draws. For renderers that take
    /// their draws as lists.
    Two,
}

/// The testers that the device and the renderer offer; by default occlusion queries only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VisibilityTestSupport {
    /// True if [`VisibilityTest::Query`] can be used. Every device has occlusion queries, but some
    /// drivers return wrong results.
    pub queries: bool,
    /// True if [`VisibilityTest::Flag`] can be used.
    pub flags: bool,
    /// True if [`VisibilityTest::Compute`] can be used.
    pub compute: bool,
    /// True if the leaves of a node that shows can be tested individually in the same frame
    /// ([`QueryKind::PerLeaf`]).
    pub leaf_tests: bool,
    /// The order of draws and tests in a frame.
    pub draw_phases: DrawPhases,
}

impl Default for VisibilityTestSupport {
    fn default() -> Self {
        Self { queries: true, ..Self::NONE }
    }
}

impl VisibilityTestSupport {
    /// No tester at all: only the view frustum culls.
    pub const NONE: Self = Self {
        queries: false,
        flags: false,
        compute: false,
        leaf_tests: false,
        draw_phases: DrawPhases::PerRound,
    };

    /// Returns the strategy that is planned in place of `wanted`. `wanted` stays if its tester is
    /// supported or if it has no tests; [`Strategy::ANTUMBRA`] stays if queries are supported, and
    /// uses the other testers in addition. Otherwise the strategy of the first supported tester is
    /// taken, in the order flags, queries, compute test, or plain frustum culling if there is none.
    #[must_use]
    pub const fn strategy(self, wanted: Strategy) -> Strategy {
        let is_there = match wanted.tester() {
            Some(tester) => self.has(tester),
            None => self.queries || !wanted.uses_cost_model(),
        };
        match self {
            _ if is_there => wanted,
            Self { flags: true, .. } => Strategy::ANTUMBRA_FLAGS,
            Self { queries: true, .. } => Strategy::ANTUMBRA_QUERIES,
            Self { compute: true, .. } => Strategy::ANTUMBRA_COMPUTE,
            _ => Strategy::FRUSTUM,
        }
    }

    /// Returns this support without flags and the compute test if `sample_threshold` is above 0,
    /// because only queries count samples.
    #[must_use]
    pub const fn counting(self, sample_threshold: u32) -> Self {
        let is_exact = sample_threshold == 0;
        Self { flags: is_exact && self.flags, compute: is_exact && self.compute, ..self }
    }

    const fn has(self, tester: VisibilityTest) -> bool {
        match tester {
            VisibilityTest::Query => self.queries,
            VisibilityTest::Flag | VisibilityTest::SharedProxy(_) => self.flags,
            VisibilityTest::Compute => self.compute,
        }
    }
}

/// The identity of a query, which comes back with its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QueryTag {
    /// The node that was tested.
    pub node: NodeId,
    /// The generation of the hierarchy that the node belongs to.
    pub generation: Generation,
    /// The frame of the query.
    pub frame: FrameId,
    /// The purpose of the query.
    pub kind: QueryKind,
    /// The most samples that count as hidden: the [threshold](FramePlan::sample_threshold) of the
    /// plan. A result keeps its meaning if the threshold changes before it comes back.
    pub sample_threshold: u32,
}

/// The result of a query. It may come late, never, twice, and in any order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The tag of the query in the plan.
    pub tag: QueryTag,
    /// The number of samples that passed; any number but 0 for "some" if queries are not precise.
    pub samples: u32,
}

impl Answer {
    /// Returns true if more samples passed than the threshold of the tag.
    #[must_use]
    pub fn shows(&self) -> bool {
        self.samples > self.tag.sample_threshold
    }
}

/// One node of the frontier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProxyTest {
    /// The identity of the query.
    pub tag: QueryTag,
    /// The box to test, already enlarged by the view's [margin](crate::Margin).
    pub bounds: Aabb,
    /// The leaves to draw in the same frame if a sample of the box shows; empty for a pull-up
    /// query.
    pub leaves: LeafRange,
    /// The depth of the node in the hierarchy, for debug views.
    pub level: u32,
    /// The mechanism that tests the box.
    pub tester: VisibilityTest,
}

/// The draws and tests of a frame.
///
/// Execute it in this order. First draw `draws` and, each under its query, `queried_draws`, merged
/// by `queried_after`. Then for every range of `rounds`: test the proxies of the range against the
/// depth so far, front faces only, without writing; draw the leaves of proxies that show. Where
/// such a test is of [`QueryKind::PerLeaf`], first test the [proxy](crate::Margin::proxy) of each
/// leaf in the same way, and draw only the leaves that show. A query shows if it counts more
/// samples than `sample_threshold`.
///
/// Every leaf whose box meets the frustum is in exactly one place: in `draws`, in `queried_draws`
/// or in the range of one test.
#[derive(Clone, Debug)]
pub struct FramePlan {
    /// The planned frame.
    pub frame: FrameId,
    /// The most samples of a query that count as hidden
    /// ([`Culler::set_sample_threshold`](crate::Culler::set_sample_threshold)). Above 0 queries
    /// must count samples, and all tests are queries.
    pub sample_threshold: u32,
    /// The leaves that are taken as visible, front to back.
    pub draws: Vec<LeafIndex>,
    /// The leaves that are taken as visible, whose own draws are tested; front to back.
    pub queried_draws: Vec<(LeafIndex, QueryTag)>,
    /// The number of `draws` before each of `queried_draws`; ascending. A queried draw keeps its
    /// place from front to back: a large leaf would hide too little if it came last.
    pub queried_after: Vec<u32>,
    /// The frontier, front to back.
    pub tests: Vec<ProxyTest>,
    /// Contiguous slabs of `tests`, front to back, none empty.
    pub rounds: Vec<Range<usize>>,
    /// The counts of the planning.
    pub stats: PlanStats,
}

impl Default for FramePlan {
    fn default() -> Self {
        Self {
            frame: FrameId(0),
            sample_threshold: 0,
            draws: Vec::new(),
            queried_draws: Vec::new(),
            queried_after: Vec::new(),
            tests: Vec::new(),
            rounds: Vec::new(),
            stats: PlanStats::default(),
        }
    }
}

impl FramePlan {
    /// Returns the number of queries in the plan.
    #[must_use]
    pub fn query_count(&self) -> usize {
        let tests = self.tests.iter().filter(|test| test.tester == VisibilityTest::Query);
        tests.count() + self.queried_draws.len()
    }

    /// Returns true if each draw either comes before all tests or depends on a test: a plan for
    /// [`DrawPhases::Two`].
    #[must_use]
    pub fn has_two_phases(&self) -> bool {
        self.rounds.len() <= 1 && self.queried_draws.is_empty()
    }

    pub(crate) fn clear(&mut self, frame: FrameId) {
        self.frame = frame;
        self.sample_threshold = 0;
        self.draws.clear();
        self.queried_draws.clear();
        self.queried_after.clear();
        self.tests.clear();
        self.rounds.clear();
        self.stats = PlanStats::default();
    }
}

/// Counts of one plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlanStats {
    /// Nodes taken from the queue: the work of the traversal. Includes all attempts if the first
    /// had too many tests.
    pub nodes_visited: u32,
    /// Tests on which draws depend.
    pub frontier: u32,
    /// Leaves under the tests of the frontier.
    pub tested_leaves: u32,
    /// Tests of the frontier whose node is unknown.
    pub unknown: u32,
    /// Pull-up queries: tests that affect only later frames.
    pub pull_up_queries: u32,
    /// Boxes of visible leaves that are tested.
    pub visible_box_queries: u32,
    /// Tests of the frontier that share the result of another test.
    pub shared_proxies: u32,
    /// Leaves drawn because they were visible, with or without a query.
    pub visible: u32,
    /// Leaves drawn because their proxy would be cut by the near plane.
    pub too_near: u32,
    /// Leaves drawn because testing them would cost more than it saves.
    pub untested_by_cost: u32,
    /// Frames after which a calm leaf's own draw is tested again; 0 without a cost model.
    pub retest_interval_frames: u32,
    /// The expected saving of the tests, their own cost deducted; 0 without a cost model.
    pub expected_saving_ns: u64,
    /// Approximate number of pixels that the boxes of all tests cover; 0 without a cost model.
    pub proxy_pixels: u64,
    /// Rounds of tests that the cost model assigned to the compute shader as the cheapest tester.
    pub rounds_by_compute: u32,
    /// Leaves drawn as occluders because too much is unknown.
    pub occluders: u32,
    /// Leaves drawn because there were too few queries to test them.
    pub over_budget: u32,
    /// The number of times that the allowed size of tested nodes was raised to reduce the tests.
    pub coarsened: u32,
}

impl std::ops::AddAssign for PlanStats {
    /// Adds the counts of another plan; `coarsened` and `retest_interval_frames` become the
    /// largest.
    fn add_assign(&mut self, other: Self) {
        self.nodes_visited += other.nodes_visited;
        self.frontier += other.frontier;
        self.tested_leaves = self.tested_leaves.saturating_add(other.tested_leaves);
        self.unknown += other.unknown;
        self.pull_up_queries += other.pull_up_queries;
        self.visible_box_queries += other.visible_box_queries;
        self.shared_proxies += other.shared_proxies;
        self.visible += other.visible;
        self.too_near += other.too_near;
        self.untested_by_cost += other.untested_by_cost;
        self.retest_interval_frames = self.retest_interval_frames.max(other.retest_interval_frames);
        self.expected_saving_ns += other.expected_saving_ns;
        self.proxy_pixels += other.proxy_pixels;
        self.rounds_by_compute += other.rounds_by_compute;
        self.occluders += other.occluders;
        self.over_budget += other.over_budget;
        self.coarsened = self.coarsened.max(other.coarsened);
    }
}
