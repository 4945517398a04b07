//! Tests every object by a query and waits for each result (GPU Gems, 29.2; GPU Gems 2, 6.2): the
//! obvious method, which gave occlusion queries the reputation of being slow.

use super::recorder::{BlockingStats, BlockingStrategy, NextAction, QueryResult, Recorder};
use crate::hierarchy::front_to_back::{InSight, ViewedHierarchy};

/// The queue of objects, front to back.
#[derive(Debug, Default)]
pub(super) struct Naive {
    leaves: Vec<InSight>,
    next: usize,
}

impl BlockingStrategy for Naive {
    fn begin(&mut self, viewed: &ViewedHierarchy<'_>, stats: &mut BlockingStats) {
        stats.nodes_visited = viewed.leaves(&mut self.leaves);
        self.next = 0;
    }

    fn next(&mut self, results: &[QueryResult], recorder: &mut Recorder<'_>) -> NextAction {
        for answer in results.iter().filter(|answer| answer.samples > 0) {
            recorder.draw(answer.node);
        }
        while let Some(leaf) = self.leaves.get(self.next) {
            self.next += 1;
            match recorder.proxy(leaf.node) {
                Some(proxy) => return NextAction::Wait(recorder.test(leaf.node, proxy)),
                None => recorder.draw(leaf.node),
            }
        }
        NextAction::Done
    }
}
