//! Coherent hierarchical culling as published (GPU Gems 2, 6.4 and 6.5): the visibility of the last
//! frame predicts the present one, so that CPU and GPU stay busy, and every prediction is checked
//! within the frame.
//!
//! Leaves that were visible are drawn at once, and their own geometry is the test. Hidden leaves
//! are tested by the boxes of the topmost hidden nodes. Results are taken as they arrive; the CPU
//! waits for a result only when there is nothing else to do.
//!
//! In place of the listing's flag and frame number, a node keeps the last frame in which it was
//! found visible. It was visible in the last frame if the two are equal.
//!
//! A query starts only when its commands are submitted, so queries are sent in batches.

use std::sync::Arc;

use super::recorder::{BlockingStats, BlockingStrategy, NextAction, QueryResult, Recorder};
use crate::geom::bounds::Aabb;
use crate::geom::frustum::PlaneMask;
use crate::hierarchy::Hierarchy;
use crate::hierarchy::front_to_back::{InSight, NearestFirst, ViewedHierarchy};
use crate::ids::{FrameId, Generation, NodeId, ObjectId};
use crate::rng::SplitMix64;

/// The test of a visible leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LeafTest {
    /// The leaf's own draw, which is needed anyway (6.5.2).
    #[default]
    OwnGeometry,
    /// The leaf's box, in addition to its draw.
    Box,
}

/// The draws of the phase with tests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FirstPass {
    /// The draws of the image.
    #[default]
    Shaded,
    /// Draws of the depth only. The image is drawn at the end of the frame, when every result is
    /// known (6.5.3). If two faces of an object have equal depth at a pixel, the last one then wins
    /// instead of the first.
    DepthOnly,
}

/// The options of [`BlockingKind::Chc`](crate::BlockingKind::Chc).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChcOptions {
    /// The test of a visible leaf.
    pub leaf_test: LeafTest,
    /// The draws of the phase with tests.
    pub first_pass: FirstPass,
    /// The most samples that an object may show and still count as hidden (6.5.4). Above 0 the
    /// image is not exact, and the device must count samples precisely.
    pub visibility_threshold_samples: u32,
    /// The number of frames for which a leaf found visible is drawn without a test (6.5.5). The
    /// first such period is randomly shorter, so that leaves are not all tested in the same frame.
    pub assumed_visible_frames: u32,
    /// The number of boxes per submit. With fewer, results come back sooner; with more, there are
    /// fewer submits.
    pub tests_per_submit: usize,
    /// The number of draws per submit, so that the GPU has work from the beginning.
    pub draws_per_submit: usize,
}

impl Default for ChcOptions {
    fn default() -> Self {
        Self {
            leaf_test: LeafTest::OwnGeometry,
            first_pass: FirstPass::Shaded,
            visibility_threshold_samples: 0,
            assumed_visible_frames: 8,
            tests_per_submit: 32,
            draws_per_submit: 256,
        }
    }
}

/// The record of an object. Frame 0 stands for never.
#[derive(Clone, Copy, Debug)]
struct LastTest {
    /// The last frame that drew it.
    drawn: FrameId,
    /// The last frame in which it was visible.
    shown: FrameId,
    /// The last frame in which it counts as visible without a test.
    assumed_until: FrameId,
}

impl LastTest {
    const NEW: Self = Self { drawn: FrameId(0), shown: FrameId(0), assumed_until: FrameId(0) };
}

/// The history and the traversal of one view.
#[derive(Debug)]
pub(super) struct Chc {
    options: ChcOptions,
    frame: FrameId,
    /// For each node, the last frame in which a part of it was visible.
    shown: Vec<FrameId>,
    /// The records by object.
    records: Vec<LastTest>,
    /// The identity of the hierarchy of `shown`, and the generation of its nodes.
    known: Option<(Arc<()>, Generation)>,
    queue: NearestFirst,
    rng: SplitMix64,
}

impl Chc {
    pub(super) fn new(options: ChcOptions) -> Self {
        Self {
            options: ChcOptions {
                tests_per_submit: options.tests_per_submit.max(1),
                draws_per_submit: options.draws_per_submit.max(1),
                ..options
            },
            frame: FrameId(0),
            shown: Vec::new(),
            records: Vec::new(),
            known: None,
            queue: NearestFirst::default(),
            rng: SplitMix64::new(0x636f_6865_7265_6e74),
        }
    }

    /// Updates the history to the present generation of the hierarchy. A leaf was visible when its
    /// object was, and an inner node when one of its children was. An object inserted since has no
    /// history, even if its id was in use before.
    fn adopt(&mut self, hierarchy: &Hierarchy) {
        let identity = hierarchy.journal().identity();
        let generation = hierarchy.generation();
        let is_known = |known: &(Arc<()>, Generation)| {
            Arc::ptr_eq(&known.0, identity) && known.1 == generation
        };
        if self.known.as_ref().is_some_and(is_known) {
            return;
        }
        if let Some((_, since)) = self.known.take_if(|known| Arc::ptr_eq(&known.0, identity)) {
            for (object, record) in (0..).map(ObjectId).zip(&mut self.records) {
                if !hierarchy.is_same_object_since(object, since) {
                    *record = LastTest::NEW;
                }
            }
        }
        self.known = Some((Arc::clone(identity), generation));
        self.records.resize(hierarchy.leaf_objects().len(), LastTest::NEW);
        self.shown.clear();
        self.shown.resize(hierarchy.node_count(), FrameId(0));
        for (object, record) in (0..).map(ObjectId).zip(&self.records) {
            if let Some(node) = hierarchy.node_of(object) {
                self.shown[node.0 as usize] = record.shown;
            }
        }
        // Children follow their parents.
        for node in (0..self.shown.len()).rev() {
            if let Some(parent) = hierarchy.parent(NodeId(node as u32)) {
                let parent = parent.0 as usize;
                self.shown[parent] = self.shown[parent].max(self.shown[node]);
            }
        }
    }

    fn was_visible(&self, node: NodeId) -> bool {
        let shown = self.shown.get(node.0 as usize).copied().unwrap_or(FrameId(0));
        shown.0 > 0 && shown.0 + 1 == self.frame.0
    }

    /// Marks a node and all nodes above it as visible.
    fn pull_up(&mut self, node: NodeId, viewed: &ViewedHierarchy<'_>) {
        let frame = self.frame;
        if let Some(record) = self.record(node, viewed) {
            record.shown = frame;
        }
        let mut above = Some(node);
        while let Some(node) = above {
            match self.shown.get_mut(node.0 as usize) {
                Some(shown) if *shown != frame => *shown = frame,
                _ => return,
            }
            above = viewed.hierarchy.parent(node);
        }
    }

    /// Returns the record of the object of a leaf; `None` for an inner node.
    fn record(&mut self, node: NodeId, viewed: &ViewedHierarchy<'_>) -> Option<&mut LastTest> {
        let leaves = viewed.hierarchy.leaves(node);
        let object = viewed.hierarchy.leaf_objects().get(leaves.first.0 as usize)?;
        self.records.get_mut(object.0 as usize).filter(|_| leaves.count == 1)
    }

    /// Queues the children of a node, or draws a leaf that is not drawn yet.
    fn traverse(&mut self, node: &InSight, recorder: &mut Recorder<'_>) {
        if let Some(children) = recorder.viewed.children(node) {
            self.queue.extend(children);
        } else if self.draws_now(node.node, &recorder.viewed) {
            recorder.draw(node.node);
        }
    }

    /// Returns true if a leaf must be drawn, which is the case once per frame.
    fn draws_now(&mut self, leaf: NodeId, viewed: &ViewedHierarchy<'_>) -> bool {
        let frame = self.frame;
        let Some(record) = self.record(leaf, viewed) else { return true };
        std::mem::replace(&mut record.drawn, frame) != frame
    }

    /// Takes a result: the first part of the published listing.
    fn take(&mut self, answer: &QueryResult, recorder: &mut Recorder<'_>) {
        if answer.samples <= self.options.visibility_threshold_samples {
            // A leaf that was visible in the last frame is drawn in addition to its test.
            let frame = self.frame;
            let record = self.record(answer.node, &recorder.viewed);
            if record.is_none_or(|record| record.drawn != frame) {
                recorder.stats.samples_below_threshold += u64::from(answer.samples);
            }
            return;
        }
        let longest = self.options.assumed_visible_frames;
        let was_visible = self.was_visible(answer.node);
        let frames = if was_visible { longest } else { self.rng.between(0, longest) };
        let until = FrameId(self.frame.0 + u64::from(frames));
        if let Some(record) = self.record(answer.node, &recorder.viewed) {
            record.assumed_until = until;
        }
        self.pull_up(answer.node, &recorder.viewed);
        if let Some(node) = recorder.viewed.look(answer.node, PlaneMask::ALL) {
            self.traverse(&node, recorder);
        }
    }

    /// Visits a node: the second part of the published listing.
    fn visit(&mut self, node: &InSight, recorder: &mut Recorder<'_>) {
        recorder.stats.nodes_visited += 1;
        let was_visible = self.was_visible(node.node);
        let is_leaf = recorder.viewed.is_leaf(node.node);
        match recorder.proxy(node.node) {
            None => {
                self.pull_up(node.node, &recorder.viewed);
                self.traverse(node, recorder);
            }
            Some(_) if was_visible && !is_leaf => self.traverse(node, recorder),
            Some(proxy) if was_visible => self.draw_visible(node.node, proxy, recorder),
            Some(proxy) => _ = recorder.test(node.node, proxy),
        }
    }

    /// Draws a leaf that was visible in the last frame, and tests it if a test is due.
    fn draw_visible(&mut self, leaf: NodeId, proxy: Aabb, recorder: &mut Recorder<'_>) {
        let frame = self.frame;
        let is_assumed =
            self.record(leaf, &recorder.viewed).is_some_and(|record| record.assumed_until >= frame);
        if !self.draws_now(leaf, &recorder.viewed) {
            return;
        }
        if is_assumed {
            self.pull_up(leaf, &recorder.viewed);
            return recorder.draw(leaf);
        }
        match self.options.leaf_test {
            LeafTest::OwnGeometry => recorder.draw_under_query(leaf),
            LeafTest::Box => {
                recorder.test(leaf, proxy);
                recorder.draw(leaf);
            }
        }
    }
}

impl BlockingStrategy for Chc {
    fn begin(&mut self, viewed: &ViewedHierarchy<'_>, _: &mut BlockingStats) {
        self.adopt(viewed.hierarchy);
        self.frame.0 += 1;
        self.queue.clear();
        self.queue.extend(viewed.root());
    }

    fn next(&mut self, results: &[QueryResult], recorder: &mut Recorder<'_>) -> NextAction {
        for answer in results {
            self.take(answer, recorder);
        }
        while let Some(node) = self.queue.pop() {
            self.visit(&node, recorder);
            let is_full = recorder.batch.tests.len() >= self.options.tests_per_submit
                || recorder.batch.draws.len() >= self.options.draws_per_submit;
            if is_full {
                return NextAction::Submit;
            }
        }
        recorder.pending.oldest_open().map_or(NextAction::Done, NextAction::Wait)
    }
}
