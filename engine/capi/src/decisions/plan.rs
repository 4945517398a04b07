//! Plans and answers as C reads and writes them.

use cull::{
    Answer, FrameId, FramePlan, Generation, Hierarchy, NodeId, ProxyTest, QueryKind, QueryTag,
    VisibilityTest,
};

use super::hierarchy::{ANTUMBRA_NO_OBJECT, AntumbraAabb};
use crate::error::Failure;
use crate::layout::{Versioned, layout, versioned};

/// The purpose of a query: a box whose leaves are drawn if it shows.
pub const ANTUMBRA_QUERY_PROXY: u32 = 0;
/// The purpose of a query: a box on which no draw of this frame depends.
pub const ANTUMBRA_QUERY_PULL_UP: u32 = 1;
/// The purpose of a query: the box of a leaf that is drawn anyway.
pub const ANTUMBRA_QUERY_VISIBLE_BOX: u32 = 2;
/// The purpose of a query: the draw of a leaf that is drawn anyway.
pub const ANTUMBRA_QUERY_VISIBLE_DRAW: u32 = 3;

/// The mechanism that tests a box: an occlusion query.
pub const ANTUMBRA_TESTER_QUERY: u32 = 0;
/// The mechanism that tests a box: a flag that its fragments set.
pub const ANTUMBRA_TESTER_FLAG: u32 = 1;
/// The mechanism that tests a box: a comparison with the depth buffer in a compute shader.
pub const ANTUMBRA_TESTER_COMPUTE: u32 = 2;

/// The value of `AntumbraDraw::query` for a draw without a query.
pub const ANTUMBRA_NO_QUERY: u32 = u32::MAX;

/// The identity of a query. The host returns it unchanged with the answer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraQueryTag {
    /// The number of the frame, as the culler counts.
    pub frame: u64,
    /// The node that is tested.
    pub node: u32,
    /// The generation of the hierarchy that the node belongs to.
    pub generation: u32,
    /// An `ANTUMBRA_QUERY_..`.
    pub kind: u32,
    /// The box or object counts as hidden if at most this number of samples pass.
    pub sample_threshold: u32,
}
layout!(AntumbraQueryTag: frame, node, generation, kind, sample_threshold);

impl AntumbraQueryTag {
    /// Converts a tag of a plan. Kinds that plans for C do not have become proxies.
    fn new(tag: &QueryTag) -> Self {
        let kind = match tag.kind {
            QueryKind::PullUpQuery => ANTUMBRA_QUERY_PULL_UP,
            QueryKind::VisibleBoxQuery => ANTUMBRA_QUERY_VISIBLE_BOX,
            QueryKind::VisibleDrawQuery => ANTUMBRA_QUERY_VISIBLE_DRAW,
            QueryKind::Proxy | QueryKind::PerLeaf | QueryKind::Leaf => ANTUMBRA_QUERY_PROXY,
        };
        Self {
            frame: tag.frame.0,
            node: tag.node.0,
            generation: tag.generation.0,
            kind,
            sample_threshold: tag.sample_threshold,
        }
    }
}

/// The result of a query. Results may come late, twice, in any order, or never.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraAnswer {
    /// The tag, as in the plan.
    pub tag: AntumbraQueryTag,
    /// The number of samples that passed. If queries are not precise, any number above 0 means
    /// "some".
    pub samples: u32,
    /// Must be 0.
    pub reserved: u32,
}
layout!(AntumbraAnswer: tag, samples, reserved);

impl AntumbraAnswer {
    /// Returns the answer as the culler takes it.
    pub(crate) fn checked(&self, number: usize) -> Result<Answer, Failure> {
        let Self { tag, samples, .. } = *self;
        let kind = match tag.kind {
            ANTUMBRA_QUERY_PROXY => QueryKind::Proxy,
            ANTUMBRA_QUERY_PULL_UP => QueryKind::PullUpQuery,
            ANTUMBRA_QUERY_VISIBLE_BOX => QueryKind::VisibleBoxQuery,
            ANTUMBRA_QUERY_VISIBLE_DRAW => QueryKind::VisibleDrawQuery,
            kind => {
                return Err(Failure::argument(format_args!(
                    "answers[{number}] has a tag of kind {kind}, which no plan has: give back the \
                     tags of the plan"
                )));
            }
        };
        let tag = QueryTag {
            node: NodeId(tag.node),
            generation: Generation(tag.generation),
            frame: FrameId(tag.frame),
            kind,
            sample_threshold: tag.sample_threshold,
        };
        Ok(Answer { tag, samples })
    }
}

/// A leaf to draw.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraDraw {
    /// The leaf.
    pub leaf: u32,
    /// Its object.
    pub object: u32,
    /// The index in `queries` of the occlusion query around the draw; `ANTUMBRA_NO_QUERY` for none.
    pub query: u32,
}
layout!(AntumbraDraw: leaf, object, query);

/// A box to test against the depth of all that was drawn before.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntumbraTest {
    /// The identity of its query.
    pub tag: AntumbraQueryTag,
    /// The box, enlarged to make up for rounding errors.
    pub bounds: AntumbraAabb,
    /// The first of the leaves to draw in this frame if the box shows.
    pub first_leaf: u32,
    /// The number of these leaves; may be 0.
    pub leaf_count: u32,
    /// An `ANTUMBRA_TESTER_..`: the mechanism that the plan assumes. All give the same result.
    pub tester: u32,
    /// The depth of the node in the hierarchy, for debug views.
    pub level: u32,
}
layout!(AntumbraTest: tag, bounds, first_leaf, leaf_count, tester, level);

/// A range of tests that can run together, before the draws that they reveal.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraRound {
    /// The first test.
    pub first_test: u32,
    /// The number of tests, above 0.
    pub test_count: u32,
}
layout!(AntumbraRound: first_test, test_count);

/// The draws and tests of a frame.
///
/// The host clears the depth and draws `draws`, those with a query inside an occlusion query. Then,
/// for each of `rounds`, it tests the boxes of the round against the depth so far, and draws the
/// leaves of the boxes that show. A test renders front faces only, compares with "as near or
/// nearer" (`>=` for reversed depth), and does not write depth. Boxes around the eye, or cut by the
/// near plane, are not tested: their objects are drawn. A box shows if more samples than its
/// `sample_threshold` pass. Every object whose box meets the frustum appears once, in `draws` or as
/// a leaf of a test.
///
/// The arrays belong to the culler and are valid until the next call with it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraFramePlan {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The number of nodes that planning visited, a measure of its work.
    pub nodes_visited: u32,
    /// The planned frame: 1 for the first of a culler.
    pub frame: u64,
    /// The leaves to draw without a test, front to back.
    pub draws: *const AntumbraDraw,
    /// The number of `draws`.
    pub draw_count: usize,
    /// The queries of `draws`.
    pub queries: *const AntumbraQueryTag,
    /// The number of `queries`.
    pub query_count: usize,
    /// The boxes to test, front to back.
    pub tests: *const AntumbraTest,
    /// The number of `tests`.
    pub test_count: usize,
    /// Consecutive ranges of `tests`.
    pub rounds: *const AntumbraRound,
    /// The number of `rounds`.
    pub round_count: usize,
}
layout!(AntumbraFramePlan: struct_size, nodes_visited, frame, draws, draw_count, queries,
    query_count, tests, test_count, rounds, round_count);

versioned!(AntumbraFramePlan: 11, required: [], defaults: {});

/// A plan in the arrays that C reads, which are reused.
#[derive(Default)]
pub(crate) struct PlanArrays {
    draws: Vec<AntumbraDraw>,
    queries: Vec<AntumbraQueryTag>,
    tests: Vec<AntumbraTest>,
    rounds: Vec<AntumbraRound>,
}

impl PlanArrays {
    /// Copies a plan.
    pub fn fill(&mut self, hierarchy: &Hierarchy, plan: &FramePlan) {
        let object = |leaf: u32| {
            hierarchy.leaf_objects().get(leaf as usize).map_or(ANTUMBRA_NO_OBJECT, |id| id.0)
        };
        self.draws.clear();
        self.queries.clear();
        let mut plain = plan.draws.iter().map(|leaf| leaf.0);
        let mut before = 0;
        for ((leaf, tag), after) in plan.queried_draws.iter().zip(&plan.queried_after) {
            let count = (after - before) as usize;
            before = *after;
            let queried = (leaf.0, self.queries.len() as u32);
            let unqueried = plain.by_ref().take(count).map(|leaf| (leaf, ANTUMBRA_NO_QUERY));
            let next = unqueried.chain([queried]);
            self.draws.extend(next.map(|(leaf, query)| AntumbraDraw {
                leaf,
                object: object(leaf),
                query,
            }));
            self.queries.push(AntumbraQueryTag::new(tag));
        }
        let query = ANTUMBRA_NO_QUERY;
        self.draws.extend(plain.map(|leaf| AntumbraDraw { leaf, object: object(leaf), query }));
        self.tests.clear();
        self.tests.extend(plan.tests.iter().map(test));
        self.rounds.clear();
        self.rounds.extend(plan.rounds.iter().map(|round| AntumbraRound {
            first_test: round.start as u32,
            test_count: round.len() as u32,
        }));
    }

    /// Returns the plan with pointers to these arrays.
    pub fn frame_plan(&self, plan: &FramePlan) -> AntumbraFramePlan {
        AntumbraFramePlan {
            nodes_visited: plan.stats.nodes_visited,
            frame: plan.frame.0,
            draws: self.draws.as_ptr(),
            draw_count: self.draws.len(),
            queries: self.queries.as_ptr(),
            query_count: self.queries.len(),
            tests: self.tests.as_ptr(),
            test_count: self.tests.len(),
            rounds: self.rounds.as_ptr(),
            round_count: self.rounds.len(),
            ..AntumbraFramePlan::INIT
        }
    }
}

/// Returns the number of a tester in C.
pub(crate) fn tester_number(tester: VisibilityTest) -> u32 {
    match tester {
        VisibilityTest::Query => ANTUMBRA_TESTER_QUERY,
        VisibilityTest::Flag | VisibilityTest::SharedProxy(_) => ANTUMBRA_TESTER_FLAG,
        VisibilityTest::Compute => ANTUMBRA_TESTER_COMPUTE,
    }
}

/// Returns a test as C reads it. Cullers for C have no tests by leaf, so no test shares the proxy
/// of another test.
fn test(test: &ProxyTest) -> AntumbraTest {
    AntumbraTest {
        tag: AntumbraQueryTag::new(&test.tag),
        bounds: test.bounds.into(),
        first_leaf: test.leaves.first.0,
        leaf_count: test.leaves.count,
        tester: tester_number(test.tester),
        level: test.level,
    }
}
