//! Draws some large occluders, then tests all other objects by queries, then waits for all results
//! (GPU Gems, 29.3).
//!
//! No query waits for another, so no test profits from objects that another test revealed: only
//! objects that were drawn before all queries, without a test, are occluders (29.3.2).

use super::recorder::{BlockingStats, BlockingStrategy, NextAction, QueryResult, Recorder};
use crate::hierarchy::front_to_back::{InSight, ViewedHierarchy};
use crate::ids::NodeId;

/// The options of [`BlockingKind::Batched`](crate::BlockingKind::Batched).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchedOptions {
    /// The size from which on an object is drawn first, without a test: the diagonal of its box
    /// over its distance (nearly radians).
    pub occluder_angle: f32,
    /// The number of tests per submit: the GPU starts while the CPU records the next ones.
    pub tests_per_submit: usize,
}

impl Default for BatchedOptions {
    fn default() -> Self {
        Self { occluder_angle: 0.75, tests_per_submit: 256 }
    }
}

/// The phase of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    #[default]
    Occluders,
    Testing,
    Reading,
}

/// The state of a frame whose queries are all sent before their results are used.
#[derive(Debug)]
pub(super) struct Batched {
    options: BatchedOptions,
    phase: Phase,
    leaves: Vec<InSight>,
    next: usize,
    /// The nodes that showed while queries were still being sent.
    shown: Vec<NodeId>,
}

impl Batched {
    pub(super) fn new(options: BatchedOptions) -> Self {
        let tests_per_submit = options.tests_per_submit.max(1);
        Self {
            options: BatchedOptions { tests_per_submit, ..options },
            phase: Phase::default(),
            leaves: Vec::new(),
            next: 0,
            shown: Vec::new(),
        }
    }

    /// Draws the occluders and the objects that cannot be tested, and keeps the others.
    fn draw_occluders(&mut self, recorder: &mut Recorder<'_>) {
        let viewed = recorder.viewed;
        self.leaves.retain(|leaf| {
            let diagonal = 2.0 * viewed.hierarchy.bounds(leaf.node).half_extent().length();
            let metres_per_radian = viewed.view.rays.metres_per_radian(leaf.distance());
            let is_drawn = diagonal >= self.options.occluder_angle * metres_per_radian
                || recorder.proxy(leaf.node).is_none();
            if is_drawn {
                recorder.draw(leaf.node);
            }
            !is_drawn
        });
    }

    fn test(&mut self, recorder: &mut Recorder<'_>) {
        let left = &self.leaves[self.next.min(self.leaves.len())..];
        let tested = left.len().min(self.options.tests_per_submit);
        for leaf in &left[..tested] {
            match recorder.viewed.proxy(leaf.node) {
                Some(proxy) => _ = recorder.test(leaf.node, proxy),
                None => recorder.draw(leaf.node),
            }
        }
        self.next += tested;
    }
}

impl BlockingStrategy for Batched {
    fn begin(&mut self, viewed: &ViewedHierarchy<'_>, stats: &mut BlockingStats) {
        stats.nodes_visited = viewed.leaves(&mut self.leaves);
        self.phase = Phase::Occluders;
        self.next = 0;
        self.shown.clear();
    }

    fn next(&mut self, results: &[QueryResult], recorder: &mut Recorder<'_>) -> NextAction {
        self.shown
            .extend(results.iter().filter(|result| result.samples > 0).map(|result| result.node));
        match self.phase {
            Phase::Occluders => {
                self.draw_occluders(recorder);
                self.phase = Phase::Testing;
                return NextAction::Submit;
            }
            Phase::Testing => {
                self.test(recorder);
                if self.next < self.leaves.len() {
                    return NextAction::Submit;
                }
                self.phase = Phase::Reading;
            }
            Phase::Reading => {}
        }
        if self.phase == Phase::Reading && recorder.batch.tests.is_empty() {
            self.shown.drain(..).for_each(|node| recorder.draw(node));
        }
        recorder.pending.oldest_open().map_or(NextAction::Done, NextAction::Wait)
    }
}
