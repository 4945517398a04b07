//! The layout of a plan's tests on the GPU: the query, flag and result of each test.

use std::ops::Range;

use cull::{FramePlan, LeafRange, ProxyTest, QueryKind, Tester};
use gpu::{DrawRange, PredicatedRange, ResultSource, Reveal};

use crate::leaf_table::{LeafCount, LeafTable};

/// The predicate that a test decides: its number among those that depend on results of one source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PredicateSlot {
    pub(crate) source: ResultSource,
    pub(crate) number: u32,
}

/// A test on its way, with the counts of its draws.
pub(crate) type PendingTest = cull::PendingTest<LeafCount>;

/// The layout of one frame's tests, kept to allocate nothing in the steady state.
#[derive(Debug, Default)]
pub(crate) struct TestLayout {
    /// The test of each query: first those on visible draws, then the tests by query.
    pub(crate) query_tags: Vec<PendingTest>,
    /// The number of the queries that are on visible draws.
    pub(crate) visible_draw_queries: u32,
    /// The test of each flag: a place for every test if there are flags at all.
    pub(crate) flag_tags: Vec<PendingTest>,
    /// The decision of each test.
    decisions: Vec<PredicateSlot>,
    pub(crate) rounds: Vec<RoundLayout>,
    /// The draws that depend on the results of queries, on flags, and on the results of the compute
    /// shader.
    query_decides: Vec<PredicatedRange>,
    flag_decides: Vec<PredicatedRange>,
    compute_decides: Vec<PredicatedRange>,
    /// The test of each result of the compute shader: a place for every test if there are any.
    pub(crate) compute_tags: Vec<PendingTest>,
}

/// The tests of one round. Tests of one kind follow each other, as the plan orders them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RoundLayout {
    pub(crate) tests: Range<usize>,
    /// The tests by flag.
    pub(crate) flags: Range<u32>,
    /// Those, and the tests that share their results.
    pub(crate) flag_decisions: Range<u32>,
    /// The tests by a compute shader.
    pub(crate) computed: Range<u32>,
    /// The tests by query.
    pub(crate) queried_tests: Range<u32>,
    /// The queries of `queried_tests`, by index.
    pub(crate) queries: Range<u32>,
    /// True if there are tests whose leaves are tested one by one.
    pub(crate) has_leaf_tests: bool,
}

impl TestLayout {
    /// Lays out `plan` for a scene as it is now.
    pub(crate) fn lay_out(&mut self, plan: &FramePlan, leaves: &LeafTable) {
        self.lay_out_counted(plan, |range| leaves.count(range));
    }

    fn lay_out_counted(&mut self, plan: &FramePlan, count: impl Fn(LeafRange) -> LeafCount) {
        self.query_tags.clear();
        // Drawn with any result: nothing depends on it.
        let own = |tag| PendingTest { tag, tester: Tester::Query, contents: LeafCount::default() };
        self.query_tags.extend(plan.queried_draws.iter().map(|(_, tag)| own(*tag)));
        self.visible_draw_queries = self.query_tags.len() as u32;
        self.query_decides.clear();
        self.query_decides.resize(self.query_tags.len(), PredicatedRange::default());
        self.decisions.clear();
        self.rounds.clear();
        for round in &plan.rounds {
            self.lay_out_round(plan, round.clone(), &count);
        }
        let decide = |(number, test): (u32, &ProxyTest)| {
            let result = match test.tester {
                Tester::SharedProxy(front) => front,
                _ => number,
            };
            predicated(test, result)
        };
        let tag = |test: &ProxyTest| pending_test(test, &count);
        let lists = [
            (Tester::Flag, &mut self.flag_tags, &mut self.flag_decides),
            (Tester::Compute, &mut self.compute_tags, &mut self.compute_decides),
        ];
        for (tester, tags, decides) in lists {
            tags.clear();
            decides.clear();
            if plan.tests.iter().any(|test| test.tester == tester) {
                tags.extend(plan.tests.iter().map(tag));
                decides.extend((0..).zip(&plan.tests).map(decide));
            }
        }
    }

    /// Returns the draws of the tests whose leaves are tested one by one.
    pub(crate) fn refined(plan: &FramePlan) -> impl Iterator<Item = DrawRange> {
        let tests = plan.tests.iter();
        tests.filter(|test| test.tag.kind == QueryKind::PerLeaf).map(draw_range)
    }

    fn lay_out_round(
        &mut self,
        plan: &FramePlan,
        tests: Range<usize>,
        count: &impl Fn(LeafRange) -> LeafCount,
    ) {
        let none = tests.start as u32..tests.start as u32;
        let first_query = self.query_tags.len() as u32;
        let mut round = RoundLayout {
            tests: tests.clone(),
            flags: none.clone(),
            flag_decisions: none.clone(),
            computed: none.clone(),
            queried_tests: none,
            queries: first_query..first_query,
            has_leaf_tests: false,
        };
        for (number, test) in (tests.start as u32..).zip(&plan.tests[tests]) {
            let decision = match test.tester {
                Tester::Query => {
                    let query = self.query_tags.len() as u32;
                    self.query_tags.push(pending_test(test, count));
                    self.query_decides.push(predicated(test, query));
                    extend(&mut round.queried_tests, number);
                    PredicateSlot { source: ResultSource::Queries, number: query }
                }
                Tester::Compute => {
                    extend(&mut round.computed, number);
                    PredicateSlot { source: ResultSource::Compute, number }
                }
                Tester::Flag | Tester::SharedProxy(_) => {
                    extend(&mut round.flag_decisions, number);
                    if test.tester == Tester::Flag {
                        extend(&mut round.flags, number);
                    }
                    PredicateSlot { source: ResultSource::Fragments, number }
                }
            };
            self.decisions.push(decision);
            round.has_leaf_tests |= test.tag.kind == QueryKind::PerLeaf;
        }
        round.queries.end = self.query_tags.len() as u32;
        self.rounds.push(round);
    }

    /// Clears the layout: no test.
    pub(crate) fn clear(&mut self) {
        self.lay_out_counted(&FramePlan::default(), |_| LeafCount::default());
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.query_tags.is_empty() && self.decisions.is_empty()
    }

    pub(crate) fn tests_by_compute(&self) -> bool {
        !self.compute_tags.is_empty()
    }

    /// Returns the draws that depend on the results of `source`.
    pub(crate) fn decided(&self, source: ResultSource) -> &[PredicatedRange] {
        match source {
            ResultSource::Queries => &self.query_decides,
            ResultSource::Fragments => &self.flag_decides,
            ResultSource::Compute => &self.compute_decides,
        }
    }

    /// Returns the decisions of a round's tests whose draws are revealed in this way.
    pub(crate) fn revealing(
        &self,
        round: Option<&RoundLayout>,
        reveal: Reveal,
    ) -> impl Iterator<Item = PredicateSlot> {
        let decisions = round.map_or(&[][..], |round| &self.decisions[round.tests.clone()]);
        let decided = |it: &PredicateSlot| self.decided(it.source).get(it.number as usize);
        decisions.iter().copied().filter(move |decision| {
            decided(decision).is_some_and(|it| it.range.count > 0 && it.reveal == reveal)
        })
    }

    /// Returns true if nothing of this frame depends on a round of queries, which serves later
    /// frames only.
    pub(crate) fn is_for_later(&self, round: &RoundLayout) -> bool {
        let decides = |reveal| self.revealing(Some(round), reveal).next().is_some();
        round.queries.len() == round.tests.len()
            && !decides(Reveal::Whole)
            && !decides(Reveal::PerLeaf)
    }

    /// Returns the decisions that are made once the proxies of `round` were drawn.
    pub(crate) fn made(&self, round: &RoundLayout) -> Vec<(ResultSource, Range<u32>)> {
        let lanes = [
            (ResultSource::Queries, round.queries.clone()),
            (ResultSource::Fragments, round.flag_decisions.clone()),
            (ResultSource::Compute, round.computed.clone()),
        ];
        lanes.into_iter().filter(|lane| !lane.1.is_empty()).collect()
    }
}

fn extend(range: &mut Range<u32>, by: u32) {
    let start = if range.start < range.end { range.start } else { by };
    *range = start..by + 1;
}

fn pending_test(test: &ProxyTest, count: impl Fn(LeafRange) -> LeafCount) -> PendingTest {
    PendingTest { tag: test.tag, tester: test.tester, contents: count(test.leaves) }
}

/// Returns the draws that a test decides about.
fn draw_range(test: &ProxyTest) -> DrawRange {
    DrawRange { first: test.leaves.first.0, count: test.leaves.count }
}

fn predicated(test: &ProxyTest, result: u32) -> PredicatedRange {
    let reveal = match test.tag.kind {
        QueryKind::PerLeaf => Reveal::PerLeaf,
        _ => Reveal::Whole,
    };
    PredicatedRange { result, range: draw_range(test), reveal }
}
