//! The results of tests, read from the memory that testers write and converted to answers. Includes
//! the results of proxies that share another result, and of nodes above a list of leaves.

use crate::hierarchy::Hierarchy;
use crate::ids::{FrameId, Generation, LeafIndex, LeafRange};
use crate::plan::frame_plan::{Answer, QueryKind, QueryTag, VisibilityTest};

/// A test in flight, with its contents (`C`) from the time of planning: the scene may change before
/// the result is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PendingTest<C> {
    /// The identity of the test.
    pub tag: QueryTag,
    /// The tester that writes the result.
    pub tester: VisibilityTest,
    /// The objects that are drawn if the test shows.
    pub contents: C,
}

/// An answer with the objects that are drawn if it shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TestResult<C> {
    /// The tag of the test and the samples that passed.
    pub answer: Answer,
    /// The objects that depend on the answer.
    pub contents: C,
}

/// The leaves of one frame that were tested individually and showed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeafList<'a> {
    /// The leaves, each once, in any order.
    These(&'a [u32]),
    /// More leaves than the list can hold.
    TooMany,
}

/// The reader that converts results to answers. It keeps its memory between readings.
#[derive(Debug)]
pub struct ResultReader<C> {
    results: Vec<TestResult<C>>,
    /// Tests that share a proxy that showed: the results of their leaves decide.
    shared: Vec<PendingTest<C>>,
}

impl<C> Default for ResultReader<C> {
    fn default() -> Self {
        Self { results: Vec::new(), shared: Vec::new() }
    }
}

impl<C: Copy> ResultReader<C> {
    /// Begins a reading and clears the results of the last one.
    pub fn clear(&mut self) {
        self.results.clear();
        self.shared.clear();
    }

    /// Reads the result of a query. Adds up the samples of consecutive queries with equal tags: a
    /// visible leaf has one query for each part of its draws.
    pub fn read_query(&mut self, test: &PendingTest<C>, samples: u32) {
        let last = self.results.last_mut().map(|last| &mut last.answer);
        match last.filter(|last| last.tag == test.tag) {
            Some(last) => last.samples = last.samples.saturating_add(samples),
            None => self.results.push(result(test, samples)),
        }
    }

    /// Reads the flags of one frame, one value per test of its plan.
    pub fn read_flags(&mut self, tests: &[PendingTest<C>], values: &[u32]) {
        for (number, test) in tests.iter().enumerate() {
            let value = |number: usize| values.get(number).copied();
            let samples = match test.tester {
                VisibilityTest::Flag => value(number),
                // If the shared proxy shows, the leaves decide about their node in `read_leaves`.
                VisibilityTest::SharedProxy(front) => value(front as usize).filter(|value| {
                    self.shared.extend((*value != 0).then_some(*test));
                    *value == 0
                }),
                VisibilityTest::Query | VisibilityTest::Compute => None,
            };
            self.results.extend(samples.map(|samples| result(test, samples)));
        }
    }

    /// Reads the values that a compute shader wrote in one frame, one per test of its plan.
    pub fn read_computed(&mut self, tests: &[PendingTest<C>], values: &[u32]) {
        let computed = tests.iter().zip(values);
        let computed = computed.filter(|(test, _)| test.tester == VisibilityTest::Compute);
        self.results.extend(computed.map(|(test, value)| result(test, *value)));
    }

    /// Reads the list of leaves of one frame; must come after its flags. `contents` describes
    /// leaves in their present state.
    pub fn read_leaves(
        &mut self,
        hierarchy: &Hierarchy,
        frame: FrameId,
        generation: Generation,
        list: LeafList<'_>,
        contents: impl Fn(LeafRange) -> C,
    ) {
        let shared = self.shared.iter().filter(|test| test.tag.frame == frame);
        let LeafList::These(leaves) = list else {
            // It is unknown which of the leaves showed, so the answers of the nodes stand for all
            // their leaves.
            self.results.extend(shared.map(|test| result(test, 1)));
            let tags = self.results.iter_mut().map(|result| &mut result.answer.tag);
            for tag in tags.filter(|tag| tag.frame == frame && tag.kind == QueryKind::PerLeaf) {
                tag.kind = QueryKind::Proxy;
            }
            return;
        };
        self.results.extend(shared.map(|test| {
            let range = hierarchy.leaves(test.tag.node);
            result(test, u32::from(leaves.iter().any(|leaf| range.contains(LeafIndex(*leaf)))))
        }));
        self.results.extend(leaves.iter().filter_map(|leaf| {
            // If the leaf has another object since, its node is younger than the answer, which is
            // then ignored.
            let object = hierarchy.leaf_objects().get(*leaf as usize)?;
            let node = hierarchy.node_of(*object)?;
            let kind = QueryKind::Leaf;
            // Fragments wrote it, which do not count samples.
            let tag = QueryTag { node, generation, frame, kind, sample_threshold: 0 };
            let answer = Answer { tag, samples: 1 };
            let leaf = LeafRange { first: LeafIndex(*leaf), count: 1 };
            Some(TestResult { answer, contents: contents(leaf) })
        }));
    }

    /// Ends a reading: sorts the results, older frames first, and within a frame leaves after
    /// nodes. Fragments list leaves in any order; after sorting, equal frames have equal results.
    pub fn finish(&mut self) {
        self.results.sort_unstable_by_key(|TestResult { answer: Answer { tag, .. }, .. }| {
            (tag.frame, tag.kind == QueryKind::Leaf, tag.node)
        });
    }

    /// Returns the results of the newest reading.
    pub fn results(&self) -> &[TestResult<C>] {
        &self.results
    }
}

fn result<C: Copy>(test: &PendingTest<C>, samples: u32) -> TestResult<C> {
    TestResult { answer: Answer { tag: test.tag, samples }, contents: test.contents }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::{Aabb, NodeId};

    fn hierarchy() -> Hierarchy {
        let boxes = (0..4).map(|x| Vec3::X * x as f32 * 3.0);
        let boxes: Vec<Aabb> = boxes.map(|low| Aabb::new(low, low + Vec3::ONE)).collect();
        Hierarchy::build(&boxes).unwrap()
    }

    fn test(node: NodeId, tester: VisibilityTest, kind: QueryKind) -> PendingTest<u32> {
        let generation = Generation(0);
        let tag = QueryTag { node, generation, frame: FrameId(7), kind, sample_threshold: 0 };
        PendingTest { tag, tester, contents: 10 }
    }

    /// Reads the root's flag, a leaf that shares this flag, and then the list of leaves.
    fn read(value: u32, list: Option<LeafList<'_>>) -> Vec<(NodeId, QueryKind, u32)> {
        let hierarchy = hierarchy();
        let root = hierarchy.root().unwrap();
        let first = hierarchy.node_of(hierarchy.leaf_objects()[0]).unwrap();
        let tests = [
            test(root, VisibilityTest::Flag, QueryKind::PerLeaf),
            test(first, VisibilityTest::SharedProxy(0), QueryKind::PerLeaf),
        ];
        let mut reader = ResultReader::default();
        reader.read_flags(&tests, &[value, 0]);
        if let Some(list) = list {
            reader.read_leaves(&hierarchy, FrameId(7), Generation(0), list, |_| 1);
        }
        reader.finish();
        let shown = |test_result: &TestResult<u32>| {
            (test_result.answer.tag.node, test_result.answer.tag.kind, test_result.answer.samples)
        };
        reader.results().iter().map(shown).collect()
    }

    #[test]
    fn a_shared_proxy_that_is_hidden_answers_for_all_that_share_it() {
        let results = read(0, None);
        assert_eq!(results.len(), 2);
        assert!(
            results.iter().all(|(_, kind, samples)| (*kind, *samples) == (QueryKind::PerLeaf, 0))
        );
    }

    #[test]
    fn where_a_shared_proxy_shows_the_leaves_answer_for_their_node() {
        let hierarchy = hierarchy();
        let node = |leaf: usize| hierarchy.node_of(hierarchy.leaf_objects()[leaf]).unwrap();
        let root = hierarchy.root().unwrap();
        assert_eq!(read(5, None), [(root, QueryKind::PerLeaf, 5)], "the list is not read yet");
        let of = |results: &[(NodeId, QueryKind, u32)], node| {
            let found =
                results.iter().find(|result| result.0 == node && result.1 == QueryKind::PerLeaf);
            found.map(|found| found.2)
        };
        let hidden = read(5, Some(LeafList::These(&[2])));
        assert_eq!(of(&hidden, node(0)), Some(0));
        assert_eq!(hidden.last(), Some(&(node(2), QueryKind::Leaf, 1)));
        let shown = read(5, Some(LeafList::These(&[0, 2])));
        assert_eq!(of(&shown, node(0)), Some(1));
    }

    #[test]
    fn nodes_answer_for_their_leaves_where_the_list_is_full() {
        let results = read(5, Some(LeafList::TooMany));
        assert_eq!(results.len(), 2);
        assert!(results.iter().all(|(_, kind, samples)| *kind == QueryKind::Proxy && *samples > 0));
    }

    #[test]
    fn the_queries_on_the_draws_of_one_leaf_count_together() {
        let hierarchy = hierarchy();
        let of = |node| PendingTest {
            tag: QueryTag {
                sample_threshold: 4,
                ..test(node, VisibilityTest::Query, QueryKind::Leaf).tag
            },
            ..test(node, VisibilityTest::Query, QueryKind::VisibleDrawQuery)
        };
        let [first, second] = [0, 1]
            .map(|leaf: usize| of(hierarchy.node_of(hierarchy.leaf_objects()[leaf]).unwrap()));
        let mut reader = ResultReader::default();
        for (test, samples) in [(first, 3), (first, 0), (first, 2), (second, 4), (first, 1)] {
            reader.read_query(&test, samples);
        }
        let samples: Vec<u32> =
            reader.results().iter().map(|result| result.answer.samples).collect();
        assert_eq!(samples, [5, 4, 1]);
        assert!(reader.results()[0].answer.shows(), "none of its draws shows by itself");
    }

    #[test]
    fn a_threshold_is_for_what_counts() {
        let hierarchy = hierarchy();
        let mut node = test(hierarchy.root().unwrap(), VisibilityTest::Query, QueryKind::PerLeaf);
        node.tag.sample_threshold = 4;
        let mut reader = ResultReader::default();
        reader.read_query(&node, 4);
        node.tag.frame = FrameId(8);
        reader.read_query(&node, 5);
        let frame = FrameId(7);
        let generation = Generation(0);
        reader.read_leaves(&hierarchy, frame, generation, LeafList::These(&[2]), |_| 1);
        let shows: Vec<bool> =
            reader.results().iter().map(|result| result.answer.shows()).collect();
        assert_eq!(shows, [false, true, true]);
    }
}
