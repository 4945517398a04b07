//! The executor of a blocking method: submits, waits and polls like the renderer, with all possible
//! mishaps.

use antumbra_cull::{
    Aabb, Batch, BlockingFrame, BlockingStats, CullView, Hierarchy, LeafIndex, NextAction,
    TestAnswer, TestToken,
};

use crate::device::{Solids, draw_caps, seen};
use crate::image::Image;
use crate::random::Random;

/// The mishaps of results within a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Trouble {
    /// The number of polls before a result is available without a wait.
    pub polls: usize,
    pub lost: f32,
    pub twice: f32,
}

pub struct Talk {
    pub image: Image,
    /// Leaves drawn by the last frame, in order.
    pub drawn: Vec<LeafIndex>,
    /// The queries of the last frame in the order of their execution, and the submit of each.
    pub tested: Vec<(TestToken, usize)>,
    submits: usize,
    pub trouble: Trouble,
    random: Random,
    sub_pixel_step: f64,
    under_way: Vec<UnderWay>,
}

/// A result that has not arrived yet.
#[derive(Clone, Copy)]
struct UnderWay {
    polls: usize,
    submit: usize,
    answer: TestAnswer,
}

/// The most steps, which is more than any scene of these tests needs.
const STEPS: usize = 20_000;

impl Talk {
    pub fn new(size: [u32; 2], sub_pixel_bits: u32, trouble: Trouble, seed: u64) -> Self {
        Self {
            image: Image::new(size),
            drawn: Vec::new(),
            tested: Vec::new(),
            submits: 0,
            trouble,
            random: Random::new(seed),
            sub_pixel_step: 0.5_f64.powi(sub_pixel_bits as i32),
            under_way: Vec::new(),
        }
    }

    /// Runs a whole frame and returns its counts.
    pub fn frame(
        &mut self,
        conversation: &mut BlockingFrame<'_>,
        view: &CullView,
        hierarchy: &Hierarchy,
        solids: &Solids<'_>,
    ) -> BlockingStats {
        self.image.clear();
        draw_caps(&mut self.image, view, hierarchy, solids.solids);
        self.drawn.clear();
        self.tested.clear();
        self.under_way.clear();
        let mut batch = Batch::default();
        let mut answers = Vec::new();
        for _ in 0..STEPS {
            let step = conversation.next(&answers, &mut batch);
            self.submits += 1;
            self.execute(&batch, view, hierarchy, solids);
            match step {
                NextAction::Done => return conversation.stats(),
                NextAction::Submit => self.poll(),
                NextAction::Wait(token) => self.wait(token),
            }
            answers = self.collect();
        }
        panic!("the conversation does not end");
    }

    fn execute(
        &mut self,
        batch: &Batch,
        view: &CullView,
        hierarchy: &Hierarchy,
        solids: &Solids<'_>,
    ) {
        for draw in &batch.draws {
            let object = hierarchy.leaf_objects()[draw.leaf.0 as usize].0;
            self.drawn.push(draw.leaf);
            let view = seen(hierarchy, object, view);
            let solid = &solids.solids[object as usize];
            let samples = self.image.draw(&view, solid, solids.shifts[object as usize]);
            if let Some(token) = draw.token {
                self.answer(token, samples);
            }
        }
        for test in &batch.tests {
            let samples = self.test(view, &test.bounds);
            self.answer(test.token, samples);
        }
    }

    fn test(&mut self, view: &CullView, bounds: &Aabb) -> u32 {
        let step = self.sub_pixel_step as f32;
        let shift = [0, 1].map(|_| f64::from(self.random.between(-step, step)));
        self.image.test(view, bounds, shift)
    }

    fn answer(&mut self, token: TestToken, samples: u32) {
        self.tested.push((token, self.submits));
        let copies = match () {
            () if self.random.chance(self.trouble.lost) => 0,
            () if self.random.chance(self.trouble.twice) => 2,
            () => 1,
        };
        for copy in 0..copies {
            let polls = self.trouble.polls * (1 + copy);
            let submit = self.submits;
            self.under_way.push(UnderWay { polls, submit, answer: TestAnswer { token, samples } });
        }
    }

    fn poll(&mut self) {
        for answer in &mut self.under_way {
            answer.polls = answer.polls.saturating_sub(1);
        }
    }

    /// Makes the results of a query available, and of all queries submitted before.
    fn wait(&mut self, token: TestToken) {
        let tested = self.tested.iter().find(|(tested, _)| *tested == token);
        let submit = tested.expect("only what was tested is waited for").1;
        for answer in self.under_way.iter_mut().filter(|entry| entry.submit <= submit) {
            answer.polls = 0;
        }
    }

    /// Returns the available results, in random order.
    fn collect(&mut self) -> Vec<TestAnswer> {
        let is_home = |entry: &UnderWay| entry.polls == 0;
        let mut answers: Vec<_> = self
            .under_way
            .iter()
            .filter(|entry| is_home(entry))
            .map(|entry| entry.answer)
            .collect();
        self.under_way.retain(|entry| !is_home(entry));
        for position in (1..answers.len()).rev() {
            answers.swap(position, self.random.below(position + 1));
        }
        answers
    }
}
