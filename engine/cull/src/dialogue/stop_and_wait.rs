//! The hierarchy from the root down, a query and a wait at every node (GPU Gems 2, 6.3).

use super::words::{DialogueStats, Heard, Method, Step, Words};
use crate::hierarchy::front_to_back::{InSight, Sight};

/// The walk down the tree, the nearer child first.
#[derive(Debug, Default)]
pub(super) struct StopAndWait {
    stack: Vec<InSight>,
    /// The node that was asked about.
    asked: Option<InSight>,
}

impl StopAndWait {
    /// Goes on below a node that shows.
    fn open(&mut self, node: &InSight, words: &mut Words<'_>) {
        match words.sight.children(node) {
            None => words.draw(node.node),
            Some(children) => {
                let first = self.stack.len();
                self.stack.extend(children);
                // The last on the stack comes next.
                self.stack[first..].reverse();
            }
        }
    }
}

impl Method for StopAndWait {
    fn begin(&mut self, sight: &Sight<'_>, _: &mut DialogueStats) {
        self.asked = None;
        self.stack.clear();
        self.stack.extend(sight.root());
    }

    fn next(&mut self, heard: &[Heard], words: &mut Words<'_>) -> Step {
        if let Some(asked) = self.asked.take()
            && heard.iter().any(|answer| answer.node == asked.node && answer.samples > 0)
        {
            self.open(&asked, words);
        }
        while let Some(node) = self.stack.pop() {
            words.stats.nodes_visited += 1;
            match words.proxy(node.node) {
                Some(proxy) => {
                    self.asked = Some(node);
                    return Step::Wait(words.ask(node.node, proxy));
                }
                None => self.open(&node, words),
            }
        }
        Step::Done
    }
}
