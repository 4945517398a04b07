//! The layout of a plan on the GPU: its visible draws, and the query, flag, result and predicates
//! of each test.

use std::ops::Range;

use cull::{FramePlan, ProxyTest, QueryKind, VisibilityTest};
use gpu::{DrawRange, PredicatedRange, ResultSource, Reveal};

use crate::leaf_table::{BucketId, LeafCount, LeafTable, draw_range};
use crate::visible_draws::VisibleDraws;

/// A range of draws or boxes that a test reveals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct RevealedRange {
    /// The bucket of the draws. For boxes it has no meaning.
    pub(crate) bucket: BucketId,
    /// The test that decides.
    pub(crate) test: u32,
    pub(crate) source: ResultSource,
    /// The index of the predicate among the predicates of the source.
    pub(crate) predicate: u32,
}

/// A test in flight, with the counts of its draws.
pub(crate) type PendingTest = cull::PendingTest<LeafCount>;

/// The layout of the draws and tests of one frame, kept to allocate nothing in the steady state.
#[derive(Debug, Default)]
pub(crate) struct TestLayout {
    pub(crate) visible: VisibleDraws,
    /// The test of each query: first those on visible draws, then the tests by query.
    pub(crate) query_tags: Vec<PendingTest>,
    /// The number of queries on visible draws.
    pub(crate) visible_draw_queries: u32,
    /// The test of each flag: an entry per test of the plan, or empty if no test uses flags.
    pub(crate) flag_tags: Vec<PendingTest>,
    /// The ranges that tests reveal, round by round: draws, boxes, and draws that these enable.
    revealed: Vec<RevealedRange>,
    pub(crate) rounds: Vec<RoundLayout>,
    /// The ranges that depend on the results of each source.
    decided: [Vec<PredicatedRange>; ResultSource::ALL.len()],
    /// The test of each result of the compute shader: an entry per test of the plan, or empty if
    /// none uses it.
    pub(crate) compute_tags: Vec<PendingTest>,
}

/// The tests of one round. Tests of one kind follow each other, as the plan orders them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RoundLayout {
    pub(crate) tests: Range<usize>,
    /// The tests by flag.
    pub(crate) flags: Range<u32>,
    /// The tests by a compute shader.
    pub(crate) computed: Range<u32>,
    /// The tests by query.
    pub(crate) queried_tests: Range<u32>,
    /// The queries of `queried_tests`, by index.
    pub(crate) queries: Range<u32>,
    /// True if there are tests whose leaves are tested individually.
    pub(crate) has_leaf_tests: bool,
    /// The predicates of the round's tests, for each source.
    predicates: [Range<u32>; ResultSource::ALL.len()],
    /// The draws that the round's tests reveal, by bucket. The boxes, and the draws that boxes
    /// enable, follow.
    draws: Range<usize>,
    boxes: Range<usize>,
    enabled_draws: Range<usize>,
}

/// The rounds whose results decide about the draws of a rendering.
#[derive(Clone, Copy)]
pub(crate) struct StepRounds<'a> {
    /// The round before, if its leaves were tested individually.
    pub(crate) before: Option<&'a RoundLayout>,
    /// The round just tested, if there is one.
    pub(crate) known: Option<&'a RoundLayout>,
}

impl TestLayout {
    /// Lays out `plan` for the present state of the scene.
    pub(crate) fn lay_out(&mut self, plan: &FramePlan, leaves: &LeafTable) {
        self.clear();
        let Self { visible, query_tags, .. } = self;
        // These leaves are drawn with any result.
        let own = |tag| PendingTest {
            tag,
            tester: VisibilityTest::Query,
            contents: LeafCount::default(),
        };
        visible.lay_out(plan, &leaves.layout, |tag| query_tags.push(own(tag)));
        self.visible_draw_queries = self.query_tags.len() as u32;
        for round in &plan.rounds {
            self.lay_out_round(plan, round.clone(), leaves);
        }
        let lists = [
            (VisibilityTest::Flag, &mut self.flag_tags),
            (VisibilityTest::Compute, &mut self.compute_tags),
        ];
        for (tester, tags) in lists {
            if plan.tests.iter().any(|test| test.tester == tester) {
                tags.extend(plan.tests.iter().map(|test| pending_test(test, leaves)));
            }
        }
    }

    fn lay_out_round(&mut self, plan: &FramePlan, tests: Range<usize>, leaves: &LeafTable) {
        let none = tests.start as u32..tests.start as u32;
        let first_query = self.query_tags.len() as u32;
        let predicates = |decided: &Vec<PredicatedRange>| decided.len() as u32;
        let first_predicates = self.decided.each_ref().map(predicates);
        let mut round = RoundLayout {
            tests: tests.clone(),
            flags: none.clone(),
            computed: none.clone(),
            queried_tests: none,
            queries: first_query..first_query,
            has_leaf_tests: false,
            predicates: Default::default(),
            draws: 0..0,
            boxes: 0..0,
            enabled_draws: 0..0,
        };
        for (number, test) in (tests.start as u32..).zip(&plan.tests[tests.clone()]) {
            match test.tester {
                VisibilityTest::Query => {
                    self.query_tags.push(pending_test(test, leaves));
                    extend(&mut round.queried_tests, number);
                }
                VisibilityTest::Compute => extend(&mut round.computed, number),
                VisibilityTest::Flag => extend(&mut round.flags, number),
                VisibilityTest::SharedProxy(_) => {}
            }
            round.has_leaf_tests |= test.tag.kind == QueryKind::PerLeaf;
        }
        round.queries.end = self.query_tags.len() as u32;
        let kinds = [
            (Reveal::Draws, &mut round.draws),
            (Reveal::Boxes, &mut round.boxes),
            (Reveal::EnabledDraws, &mut round.enabled_draws),
        ];
        for (reveal, revealed) in kinds {
            let first = self.revealed.len();
            self.reveal(plan, tests.clone(), first_query, reveal, leaves);
            *revealed = first..self.revealed.len();
            // Draws of one pipeline come together, front to back.
            self.revealed[revealed.clone()]
                .sort_unstable_by_key(|range| (range.bucket, range.test));
        }
        let lists = first_predicates.into_iter().zip(&self.decided);
        for (to, (first, decided)) in round.predicates.iter_mut().zip(lists) {
            *to = first..predicates(decided);
        }
        self.rounds.push(round);
    }

    /// Adds the ranges of one kind that the tests of a round reveal.
    fn reveal(
        &mut self,
        plan: &FramePlan,
        tests: Range<usize>,
        mut next_query: u32,
        reveal: Reveal,
        leaves: &LeafTable,
    ) {
        let Self { revealed, decided, .. } = self;
        for (number, test) in (tests.start as u32..).zip(&plan.tests[tests]) {
            let (source, result) = match test.tester {
                VisibilityTest::Query => {
                    next_query += 1;
                    (ResultSource::Queries, next_query - 1)
                }
                VisibilityTest::Compute => (ResultSource::Compute, number),
                VisibilityTest::Flag => (ResultSource::Fragments, number),
                VisibilityTest::SharedProxy(front) => (ResultSource::Fragments, front),
            };
            let is_per_leaf = test.tag.kind == QueryKind::PerLeaf;
            if is_per_leaf == (reveal == Reveal::Draws) {
                continue;
            }
            let decided = &mut decided[source as usize];
            let mut add = |bucket, range| {
                let predicate = decided.len() as u32;
                revealed.push(RevealedRange { bucket, test: number, source, predicate });
                decided.push(PredicatedRange { result, range, reveal });
            };
            match reveal {
                Reveal::Boxes if test.leaves.is_empty() => {}
                Reveal::Boxes => add(BucketId(0), draw_range(test.leaves)),
                Reveal::Draws | Reveal::EnabledDraws => leaves.layout.ranges(test.leaves, add),
            }
        }
    }

    /// Clears the layout: no draw and no test.
    pub(crate) fn clear(&mut self) {
        self.visible.clear();
        self.query_tags.clear();
        self.visible_draw_queries = 0;
        self.flag_tags.clear();
        self.compute_tags.clear();
        self.revealed.clear();
        self.decided.each_mut().into_iter().for_each(Vec::clear);
        self.rounds.clear();
    }

    /// Returns the draws of the tests whose leaves are tested individually.
    pub(crate) fn refined(&self) -> impl Iterator<Item = DrawRange> {
        let enabled =
            self.rounds.iter().flat_map(|round| &self.revealed[round.enabled_draws.clone()]);
        enabled.filter_map(|enabled| {
            Some(self.decided(enabled.source).get(enabled.predicate as usize)?.range)
        })
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.query_tags.is_empty() && self.rounds.is_empty()
    }

    pub(crate) fn tests_by_compute(&self) -> bool {
        !self.compute_tags.is_empty()
    }

    /// Returns the ranges that depend on the results of `source`.
    pub(crate) fn decided(&self, source: ResultSource) -> &[PredicatedRange] {
        &self.decided[source as usize]
    }

    /// Returns the ranges of one kind that a round's tests reveal. The ranges of a bucket are
    /// contiguous.
    pub(crate) fn revealed(&self, round: Option<&RoundLayout>, reveal: Reveal) -> &[RevealedRange] {
        let Some(round) = round else { return &[] };
        let range = match reveal {
            Reveal::Draws => &round.draws,
            Reveal::Boxes => &round.boxes,
            Reveal::EnabledDraws => &round.enabled_draws,
        };
        &self.revealed[range.clone()]
    }

    /// Returns the number of renderings after the first: one per round, and one more if the last
    /// round has leaves that are tested individually.
    pub(crate) fn step_count(&self) -> usize {
        let refined = self.rounds.last().is_some_and(|round| round.has_leaf_tests);
        self.rounds.len() + usize::from(refined)
    }

    /// Returns the rounds whose results decide about the draws of a rendering.
    pub(crate) fn step(&self, step: usize) -> StepRounds<'_> {
        let before = step.checked_sub(1).and_then(|round| self.rounds.get(round));
        StepRounds {
            before: before.filter(|round| round.has_leaf_tests),
            known: self.rounds.get(step),
        }
    }

    /// Returns true if a round has only queries that serve later frames: no draw of this frame
    /// depends on them.
    pub(crate) fn is_for_later(&self, round: &RoundLayout) -> bool {
        round.queries.len() == round.tests.len() && round.draws.is_empty() && round.boxes.is_empty()
    }

    /// Returns the predicates that are decided once the proxies of `round` have been drawn.
    pub(crate) fn made(&self, round: &RoundLayout) -> [(ResultSource, Range<u32>); 3] {
        ResultSource::ALL.map(|source| (source, round.predicates[source as usize].clone()))
    }
}

fn extend(range: &mut Range<u32>, by: u32) {
    let start = if range.start < range.end { range.start } else { by };
    *range = start..by + 1;
}

fn pending_test(test: &ProxyTest, leaves: &LeafTable) -> PendingTest {
    PendingTest { tag: test.tag, tester: test.tester, contents: leaves.count(test.leaves) }
}

/// Takes the ranges of a bucket from the start of the list, if there are any.
pub(crate) fn take_bucket<'a>(
    list: &mut &'a [RevealedRange],
    bucket: BucketId,
) -> &'a [RevealedRange] {
    let (taken, left) = list.split_at(list.partition_point(|entry| entry.bucket == bucket));
    *list = left;
    taken
}
