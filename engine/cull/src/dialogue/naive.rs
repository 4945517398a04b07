//! A query for every object, and a wait for each (GPU Gems, 29.2; GPU Gems 2, 6.2): what one would
//! write first, and the reason why occlusion queries were thought to be slow.

use super::words::{DialogueStats, Heard, Method, Step, Words};
use crate::hierarchy::front_to_back::{InSight, Sight};

/// Objects front to back, one at a time.
#[derive(Debug, Default)]
pub(super) struct Naive {
    leaves: Vec<InSight>,
    next: usize,
}

impl Method for Naive {
    fn begin(&mut self, sight: &Sight<'_>, stats: &mut DialogueStats) {
        stats.nodes_visited = sight.leaves(&mut self.leaves);
        self.next = 0;
    }

    fn next(&mut self, heard: &[Heard], words: &mut Words<'_>) -> Step {
        for answer in heard.iter().filter(|answer| answer.samples > 0) {
            words.draw(answer.node);
        }
        while let Some(leaf) = self.leaves.get(self.next) {
            self.next += 1;
            match words.proxy(leaf.node) {
                Some(proxy) => return Step::Wait(words.ask(leaf.node, proxy)),
                None => words.draw(leaf.node),
            }
        }
        Step::Done
    }
}
