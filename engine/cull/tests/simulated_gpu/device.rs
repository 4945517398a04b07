//! Executes plans like the renderer: writes results to memory that is read frames later, with all
//! possible mishaps. The same [`ResultReader`] reads them as for a real GPU.

use antumbra_cull::{
    Aabb, Answer, CullView, FrameId, FramePlan, Generation, Hierarchy, LeafIndex, LeafList,
    LeafRange, MultiView, NodeId, ObjectId, PendingTest, ProxyTest, QueryKind, QueryTag,
    ResultReader, SectionMember, SectionPlanes, VisibilityTest,
};

use crate::image::{Image, Shift};
use crate::random::Random;

/// The mishaps of answers on their way.
#[derive(Clone, Copy, Debug)]
pub struct Mishaps {
    /// The frames between a test and its answer.
    pub latency: u64,
    /// The probability that an answer takes up to three frames longer.
    pub late: f32,
    pub lost: f32,
    pub twice: f32,
    /// The number of leaves that the list of a frame can hold.
    pub listed: usize,
}

impl Mishaps {
    pub const fn none(latency: u64) -> Self {
        Self { latency, late: 0.0, lost: 0.0, twice: 0.0, listed: usize::MAX }
    }
}

/// The memory of an executed frame: its tests and their results.
struct Written {
    frame: (FrameId, Generation),
    queries: Vec<(PendingTest<()>, u32)>,
    tests: Vec<PendingTest<()>>,
    /// One value per test; the value of a test that shares another result is never written.
    values: Vec<u32>,
    /// The leaves that were tested individually and showed.
    leaves: Vec<u32>,
    /// The truth about each test: true if its node showed, or, for a shared result, if one of its
    /// leaves showed.
    showed: Vec<bool>,
}

impl Written {
    fn new(plan: &FramePlan, hierarchy: &Hierarchy) -> Self {
        let pending = |test: &ProxyTest| pending(test.tag, test.tester);
        Self {
            frame: (plan.frame, hierarchy.generation()),
            queries: Vec::new(),
            tests: plan.tests.iter().map(pending).collect(),
            values: Vec::new(),
            leaves: Vec::new(),
            showed: Vec::new(),
        }
    }

    /// Returns the answers over a hierarchy that may have changed since, nodes before their leaves.
    fn answers(&self, hierarchy: &Hierarchy, listed: usize) -> Vec<Answer> {
        let mut reader = ResultReader::default();
        for (test, samples) in &self.queries {
            // Like the two queries of a leaf with draws in two buckets.
            reader.read_query(test, samples / 2);
            reader.read_query(test, samples - samples / 2);
        }
        for (test, samples) in self.tests.iter().zip(&self.values) {
            if test.tester == VisibilityTest::Query {
                reader.read_query(test, *samples);
            }
        }
        reader.read_flags(&self.tests, &self.values);
        reader.read_computed(&self.tests, &self.values);
        let list = if self.leaves.len() > listed {
            LeafList::TooMany
        } else {
            LeafList::These(&self.leaves)
        };
        reader.read_leaves(hierarchy, self.frame.0, self.frame.1, list, |_| ());
        reader.finish();
        let answers: Vec<Answer> = reader.results().iter().map(|result| result.answer).collect();
        if hierarchy.generation() == self.frame.1 {
            self.assert_true(&answers, matches!(list, LeafList::These(_)));
        }
        answers
    }

    /// Checks the answers about tests against the draws. If the list was full, answers may report
    /// leaves as visible that are not.
    fn assert_true(&self, answers: &[Answer], is_listed: bool) {
        for (test, showed) in self.tests.iter().zip(&self.showed) {
            let same = |answer: &&Answer| {
                answer.tag.node == test.tag.node && answer.tag.kind != QueryKind::Leaf
            };
            let answer = answers.iter().find(same).expect("each test has an answer");
            let is_right =
                if is_listed { answer.shows() == *showed } else { answer.shows() || !showed };
            assert!(is_right, "{test:?} has {answer:?}, and in truth {showed}");
        }
    }
}

fn pending(tag: QueryTag, tester: VisibilityTest) -> PendingTest<()> {
    PendingTest { tag, tester, contents: () }
}

/// Returns the view for drawing an object: without section planes if they leave the object whole.
pub fn seen(hierarchy: &Hierarchy, object: u32, view: &CullView) -> CullView {
    match hierarchy.section_member(ObjectId(object)) {
        SectionMember::Cut => *view,
        SectionMember::Whole => CullView { section: SectionPlanes::default(), ..*view },
    }
}

/// Draws the cut faces of solids before anything else.
pub fn draw_caps(image: &mut Image, view: &CullView, hierarchy: &Hierarchy, solids: &[Aabb]) {
    for (object, solid) in (0..).zip(solids) {
        if !solid.is_empty() {
            image.draw_caps(&seen(hierarchy, object, view), solid);
        }
    }
}

/// The solids that are drawn inside of the bounding boxes.
pub struct Solids<'a> {
    pub solids: &'a [Aabb],
    /// The shift of each solid by the device's sub-pixel grid.
    pub shifts: &'a [Shift],
}

pub struct Device {
    /// The image of each view.
    pub images: Vec<Image>,
    /// Objects drawn by the last frame, in order.
    pub drawn: Vec<u32>,
    /// The leaves that the last frame did not draw because of its threshold, and the number of
    /// samples that showed.
    pub below_threshold: Vec<(LeafRange, u32)>,
    mishaps: Mishaps,
    random: Random,
    sub_pixel_step: f64,
    /// Frames whose results are not read yet, oldest first.
    written: Vec<Written>,
    /// The late answers, and the frame in which each arrives.
    late: Vec<(u64, Answer)>,
}

impl Device {
    pub fn new(size: [u32; 2], sub_pixel_bits: u32, mishaps: Mishaps, seed: u64) -> Self {
        Self {
            images: vec![Image::new(size)],
            drawn: Vec::new(),
            below_threshold: Vec::new(),
            mishaps,
            random: Random::new(seed),
            sub_pixel_step: 0.5_f64.powi(sub_pixel_bits as i32),
            written: Vec::new(),
            late: Vec::new(),
        }
    }

    /// Returns the answers that arrived before frame `next` is planned, in random order.
    pub fn collect(&mut self, next: u64, hierarchy: &Hierarchy) -> Vec<Answer> {
        let Mishaps { latency, late, lost, twice, listed } = self.mishaps;
        let mut answers = Vec::new();
        self.late.retain(|(arrival, answer)| {
            let is_there = *arrival <= next;
            answers.extend(is_there.then_some(*answer));
            !is_there
        });
        let is_over = |written: &Written| written.frame.0.0 + latency <= next;
        let over = self.written.iter().take_while(|written| is_over(written)).count();
        for written in self.written.drain(..over) {
            for answer in written.answers(hierarchy, listed) {
                let copies = match () {
                    () if self.random.chance(lost) => 0,
                    () if self.random.chance(twice) => 2,
                    () => 1,
                };
                for _ in 0..copies {
                    if self.random.chance(late) {
                        self.late.push((next + 1 + self.random.below(3) as u64, answer))
                    } else {
                        answers.push(answer)
                    }
                }
            }
        }
        for position in (1..answers.len()).rev() {
            answers.swap(position, self.random.below(position + 1));
        }
        answers
    }

    /// Returns the answers to `frame` that were not collected yet, nodes before their leaves.
    pub fn answers_of(&self, frame: FrameId, hierarchy: &Hierarchy) -> Vec<Answer> {
        let written = self.written.iter().filter(|written| written.frame.0 == frame);
        written.flat_map(|frame| frame.answers(hierarchy, self.mishaps.listed)).collect()
    }

    /// Executes a frame: draws and tests in the order of its plan, each in all views.
    pub fn execute<'v>(
        &mut self,
        views: impl Into<MultiView<'v>>,
        hierarchy: &Hierarchy,
        solids: &Solids<'_>,
        plan: &FramePlan,
    ) {
        let views = views.into();
        self.images.resize(views.as_slice().len(), Image::new(views.first().size));
        self.images.iter_mut().for_each(Image::clear);
        for (view, image) in views.as_slice().iter().zip(&mut self.images) {
            draw_caps(image, view, hierarchy, solids.solids);
        }
        self.drawn.clear();
        self.below_threshold.clear();
        let mut written = Written::new(plan, hierarchy);
        let mut drawn = 0;
        for ((leaf, tag), after) in plan.queried_draws.iter().zip(&plan.queried_after) {
            for leaf in &plan.draws[drawn..*after as usize] {
                self.draw(views, hierarchy, solids, *leaf);
            }
            drawn = *after as usize;
            let samples = self.draw(views, hierarchy, solids, *leaf);
            written.queries.push((pending(*tag, VisibilityTest::Query), samples));
        }
        for leaf in &plan.draws[drawn..] {
            self.draw(views, hierarchy, solids, *leaf);
        }
        for round in &plan.rounds {
            let tests = &plan.tests[round.clone()];
            written.values.extend(tests.iter().map(|test| match test.tester {
                VisibilityTest::SharedProxy(_) => 0,
                _ => self.test(views, test.tag.node, &test.bounds),
            }));
            for (number, test) in round.clone().zip(tests) {
                let samples = match test.tester {
                    VisibilityTest::SharedProxy(front) => written.values[front as usize],
                    _ => written.values[number],
                };
                if samples <= test.tag.sample_threshold {
                    written.showed.push(false);
                    self.below_threshold.extend((samples > 0).then_some((test.leaves, samples)));
                    continue;
                }
                let leaves = match test.tag.kind {
                    QueryKind::PerLeaf => self.leaves_that_show(views, hierarchy, test),
                    _ => test.leaves.iter().collect(),
                };
                let is_shared = matches!(test.tester, VisibilityTest::SharedProxy(_));
                written.showed.push(!is_shared || !leaves.is_empty());
                if test.tag.kind == QueryKind::PerLeaf {
                    written.leaves.extend(leaves.iter().map(|leaf| leaf.0));
                }
                for leaf in leaves {
                    self.draw(views, hierarchy, solids, leaf);
                }
            }
        }
        self.written.push(written);
    }

    /// Counts the samples of the proxy of a node. The same box is rounded in the same way in every
    /// frame.
    fn test(&self, views: MultiView<'_>, node: NodeId, proxy: &Aabb) -> u32 {
        let shift = self.shift(node);
        let images = views.as_slice().iter().zip(&self.images);
        images.map(|(view, image)| image.test(view, proxy, shift)).sum()
    }

    fn shift(&self, node: NodeId) -> Shift {
        let mut rounding = Random::new(node.0.into());
        [0, 1].map(|_| f64::from(rounding.between(-1.0, 1.0)) * self.sub_pixel_step)
    }

    /// Returns the leaves of a node that show in any view, tested individually with the margin of
    /// each view.
    fn leaves_that_show(
        &self,
        views: MultiView<'_>,
        hierarchy: &Hierarchy,
        test: &ProxyTest,
    ) -> Vec<LeafIndex> {
        let shows = |leaf: &LeafIndex| {
            let node = hierarchy.node_of(hierarchy.leaf_objects()[leaf.0 as usize]).unwrap();
            // A free leaf draws nothing.
            if hierarchy.bounds(node).is_empty() {
                return false;
            }
            let shows = |(view, image): (&CullView, &Image)| {
                let proxy = view.margin.proxy(&hierarchy.bounds(node));
                // Only a leaf outside of this view's frustum may be too near.
                assert!(proxy.is_some() || views.as_slice().len() > 1, "near, as its node");
                proxy.is_some_and(|proxy| image.test(view, &proxy, self.shift(node)) > 0)
            };
            views.as_slice().iter().zip(&self.images).any(shows)
        };
        test.leaves.iter().filter(shows).collect()
    }

    fn draw(
        &mut self,
        views: MultiView<'_>,
        hierarchy: &Hierarchy,
        solids: &Solids<'_>,
        leaf: LeafIndex,
    ) -> u32 {
        let object = hierarchy.leaf_objects()[leaf.0 as usize].0;
        if solids.solids[object as usize].is_empty() {
            return 0;
        }
        self.drawn.push(object);
        let solid = &solids.solids[object as usize];
        let shift = solids.shifts[object as usize];
        let images = views.as_slice().iter().zip(&mut self.images);
        images.map(|(view, image)| image.draw(&seen(hierarchy, object, view), solid, shift)).sum()
    }
}
