//! Executes plans as the renderer does, and brings answers home with all mishaps there are.

use antumbra_cull::{
    Aabb, Answer, FramePlan, Hierarchy, LeafIndex, LeafRange, ProxyTest, QueryKind, QueryTag,
    Tester, View,
};

use crate::image::{Image, Shift};
use crate::random::Random;

/// What can happen to an answer on its way.
#[derive(Clone, Copy, Debug)]
pub struct Mishaps {
    /// Frames between asking and knowing.
    pub latency: u64,
    /// Probability that it takes up to three frames longer.
    pub late: f32,
    pub lost: f32,
    pub twice: f32,
}

impl Mishaps {
    pub const fn none(latency: u64) -> Self {
        Self { latency, late: 0.0, lost: 0.0, twice: 0.0 }
    }
}

/// The solids that are drawn: what is inside of the bounding boxes.
pub struct Solids<'a> {
    pub solids: &'a [Aabb],
    /// How the device's grid shifts each.
    pub shifts: &'a [Shift],
}

pub struct Device {
    pub image: Image,
    /// Objects drawn by the last frame, in order.
    pub drawn: Vec<u32>,
    /// What shows no more samples than this is not drawn.
    pub threshold_samples: u32,
    /// The leaves that were left out so by the last frame, and the samples that showed.
    pub neglected: Vec<(LeafRange, u32)>,
    mishaps: Mishaps,
    random: Random,
    sub_pixel_step: f64,
    /// Answers on their way, and the frame they arrive at.
    under_way: Vec<(u64, Answer)>,
}

impl Device {
    pub fn new(size: [u32; 2], sub_pixel_bits: u32, mishaps: Mishaps, seed: u64) -> Self {
        Self {
            image: Image::new(size),
            drawn: Vec::new(),
            threshold_samples: 0,
            neglected: Vec::new(),
            mishaps,
            random: Random::new(seed),
            sub_pixel_step: 0.5_f64.powi(sub_pixel_bits as i32),
            under_way: Vec::new(),
        }
    }

    /// Returns the answers that are home when frame `next` is planned, in random order.
    pub fn collect(&mut self, next: u64) -> Vec<Answer> {
        let mut home = Vec::new();
        self.under_way.retain(|(arrival, answer)| {
            let is_home = *arrival <= next;
            if is_home {
                home.push(*answer);
            }
            !is_home
        });
        for position in (1..home.len()).rev() {
            home.swap(position, self.random.below(position + 1));
        }
        home
    }

    /// Returns the answers to `frame` that are still under way, those of nodes before those of
    /// their parts.
    pub fn answers_of(&self, frame: u64) -> Vec<Answer> {
        let all = self.under_way.iter().map(|(_, answer)| *answer);
        all.filter(|answer| answer.tag.frame.0 == frame).collect()
    }

    /// A frame, in the order that a plan asks for.
    pub fn execute(
        &mut self,
        view: &View,
        hierarchy: &Hierarchy,
        solids: &Solids<'_>,
        plan: &FramePlan,
    ) {
        self.image.clear();
        self.drawn.clear();
        self.neglected.clear();
        let mut drawn = 0;
        for ((leaf, tag), after) in plan.queried_draws.iter().zip(&plan.queried_after) {
            for leaf in &plan.draws[drawn..*after as usize] {
                self.draw(view, hierarchy, solids, *leaf);
            }
            drawn = *after as usize;
            let samples = self.draw(view, hierarchy, solids, *leaf);
            self.answer(*tag, samples);
        }
        for leaf in &plan.draws[drawn..] {
            self.draw(view, hierarchy, solids, *leaf);
        }
        let mut words = Vec::new();
        for round in &plan.rounds {
            let tests = &plan.tests[round.clone()];
            let shown: Vec<u32> = tests
                .iter()
                .map(|test| {
                    if let Tester::SharedProxy(_) = test.tester {
                        return 0;
                    }
                    let step = self.sub_pixel_step;
                    // A device rounds the same box in the same way in every frame.
                    let mut rounding = Random::new(test.tag.node.0.into());
                    let shift = [0, 1].map(|_| f64::from(rounding.between(-1.0, 1.0)) * step);
                    self.image.test(view, &test.bounds, shift)
                })
                .collect();
            words.extend(shown);
            for (number, test) in round.clone().zip(tests) {
                let samples = match test.tester {
                    Tester::SharedProxy(front) => words[front as usize],
                    _ => words[number],
                };
                let is_behind = matches!(test.tester, Tester::SharedProxy(_));
                if samples == 0 || !is_behind {
                    self.answer(test.tag, samples);
                }
                if samples <= self.threshold_samples {
                    self.neglected.extend((samples > 0).then_some((test.leaves, samples)));
                    continue;
                }
                let parts = match test.tag.kind {
                    QueryKind::PerLeaf => self.parts(view, hierarchy, test),
                    _ => test.leaves.iter().collect(),
                };
                if is_behind {
                    // Behind a box that shows, the leaves answer for their node.
                    self.answer(test.tag, parts.len() as u32);
                }
                for leaf in parts {
                    self.draw(view, hierarchy, solids, leaf);
                }
            }
        }
    }

    /// Returns the leaves of a node that show, tested one by one; their answers go with the node's.
    fn parts(&mut self, view: &View, hierarchy: &Hierarchy, test: &ProxyTest) -> Vec<LeafIndex> {
        let mut shown = Vec::new();
        for leaf in test.leaves.iter() {
            let node = hierarchy.node_of(hierarchy.leaf_objects()[leaf.0 as usize]).unwrap();
            let bounds =
                view.margin.proxy(&hierarchy.bounds(node)).expect("far enough, as its node is");
            let step = self.sub_pixel_step;
            let mut rounding = Random::new(node.0.into());
            let shift = [0, 1].map(|_| f64::from(rounding.between(-1.0, 1.0)) * step);
            let samples = self.image.test(view, &bounds, shift);
            if samples > 0 {
                shown.push(leaf);
                self.answer(QueryTag { node, kind: QueryKind::Leaf, ..test.tag }, samples);
            }
        }
        shown
    }

    fn draw(
        &mut self,
        view: &View,
        hierarchy: &Hierarchy,
        solids: &Solids<'_>,
        leaf: LeafIndex,
    ) -> u32 {
        let object = hierarchy.leaf_objects()[leaf.0 as usize].0;
        if solids.solids[object as usize].is_empty() {
            return 0;
        }
        self.drawn.push(object);
        let (solid, shift) = (&solids.solids[object as usize], solids.shifts[object as usize]);
        self.image.draw(view, solid, shift)
    }

    fn answer(&mut self, tag: QueryTag, samples: u32) {
        let copies = match () {
            () if self.random.chance(self.mishaps.lost) => 0,
            () if self.random.chance(self.mishaps.twice) => 2,
            () => 1,
        };
        for _ in 0..copies {
            let delay = if self.random.chance(self.mishaps.late) {
                1 + self.random.below(3) as u64
            } else {
                0
            };
            let arrival = tag.frame.0 + self.mishaps.latency + delay;
            self.under_way.push((arrival, Answer { tag, samples }));
        }
    }
}
