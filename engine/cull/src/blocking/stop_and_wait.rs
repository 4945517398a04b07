//! Tests the hierarchy from the root down, with a query and a wait at every node (GPU Gems 2, 6.3).

use super::recorder::{BlockingStats, BlockingStrategy, NextAction, QueryResult, Recorder};
use crate::hierarchy::front_to_back::{InSight, ViewedHierarchy};

/// The walk down the tree, the nearer child first.
#[derive(Debug, Default)]
pub(super) struct StopAndWait {
    stack: Vec<InSight>,
    /// The node whose query is open.
    tested: Option<InSight>,
}

impl StopAndWait {
    /// Queues the children of a node that shows.
    fn open(&mut self, node: &InSight, recorder: &mut Recorder<'_>) {
        match recorder.viewed.children(node) {
            None => recorder.draw(node.node),
            Some(children) => {
                let first = self.stack.len();
                self.stack.extend(children);
                // The last node on the stack is visited next.
                self.stack[first..].reverse();
            }
        }
    }
}

impl BlockingStrategy for StopAndWait {
    fn begin(&mut self, viewed: &ViewedHierarchy<'_>, _: &mut BlockingStats) {
        self.tested = None;
        self.stack.clear();
        self.stack.extend(viewed.root());
    }

    fn next(&mut self, results: &[QueryResult], recorder: &mut Recorder<'_>) -> NextAction {
        if let Some(tested) = self.tested.take()
            && results.iter().any(|answer| answer.node == tested.node && answer.samples > 0)
        {
            self.open(&tested, recorder);
        }
        while let Some(node) = self.stack.pop() {
            recorder.stats.nodes_visited += 1;
            match recorder.proxy(node.node) {
                Some(proxy) => {
                    self.tested = Some(node);
                    return NextAction::Wait(recorder.test(node.node, proxy));
                }
                None => self.open(&node, recorder),
            }
        }
        NextAction::Done
    }
}
