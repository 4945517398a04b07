//! The changes of the history by an answer: if a node showed, its ancestors become visible
//! (pull-up), and its parts are tested next (pull-down; "Hardware Occlusion Queries Made Useful",
//! 6.4).
//!
//! The literature also makes a parent hidden if its children are hidden. But in many views its box
//! shows although the boxes of its children do not, and all of its leaves would be drawn. So a
//! pull-up query tests the parent first, unless the leaves below a node that shows are tested
//! individually in the same frame.

use crate::hierarchy::{NO_NODE, Topology};
use crate::history::record::{FrameStamp, NodeRecord, NodeState};
use crate::history::records::{History, retest_interval};
use crate::plan::config::CullConfig;
use crate::plan::frame_plan::QueryKind;
use crate::rng::SplitMix64;

/// The time after a hidden own draw within which a visible proxy counts as too loose in this view.
/// Halving or doubling it changes no count of a walk by more than 1 % (docs/lab/cull_config.md).
const FLICKER_FRAMES: u32 = 16;

/// The update of the history by an answer.
pub(crate) struct Ingest<'a> {
    pub(crate) history: &'a mut History,
    pub(crate) topology: &'a Topology,
    pub(crate) config: &'a CullConfig,
    pub(crate) rng: &'a mut SplitMix64,
    /// The frame planned last.
    pub(crate) now: FrameStamp,
    pub(crate) tested: FrameStamp,
}

impl Ingest<'_> {
    pub(crate) fn apply(&mut self, node: u32, kind: QueryKind, samples: u32) {
        let Some(record) = self.history.record_mut(node) else {
            return;
        };
        // The answer about a leaf refines the answer about its node, which came first.
        let is_old = match kind {
            QueryKind::Leaf => record.answered > self.tested,
            _ => record.answered >= self.tested,
        };
        if is_old {
            return;
        }
        record.answered = self.tested;
        // The GPU tested the node even if the traversal did not visit it: leaves that are tested
        // because their node showed are not visited. The frame of the test counts, not the present
        // frame, so a record stays stale after a very late answer.
        record.visited = record.visited.max(self.tested);
        match (kind, samples) {
            (QueryKind::Leaf, 0) => {}
            (QueryKind::Leaf, _) => self.leaf_showed(node),
            (QueryKind::PerLeaf, 0) => self.proxy_hidden(node),
            (QueryKind::PerLeaf, _) => self.leaves_showed(node),
            (QueryKind::Proxy, 0) => self.proxy_hidden(node),
            (QueryKind::Proxy, _) if self.is_leaf(node) => self.leaf_showed(node),
            (QueryKind::Proxy, _) => self.inner_showed(node),
            (QueryKind::PullUpQuery, 0) => self.merge(node),
            (QueryKind::PullUpQuery, _) => self.pull_up_failed(node),
            (QueryKind::VisibleDrawQuery | QueryKind::VisibleBoxQuery, 0) => self.set_hidden(node),
            (QueryKind::VisibleBoxQuery, _) => self.visible_box_showed(node),
            (QueryKind::VisibleDrawQuery, _) => self.visible_draw_showed(node),
        }
    }

    fn is_leaf(&self, node: u32) -> bool {
        self.topology.nodes[node as usize].is_leaf()
    }

    /// Changes the record of a node that is known to exist.
    fn update(&mut self, node: u32, change: impl FnOnce(&mut NodeRecord)) {
        if let Some(record) = self.history.record_mut(node) {
            change(record);
        }
    }

    fn proxy_hidden(&mut self, node: u32) {
        let record = self.history.record(node);
        let is_open = record.state == NodeState::Visible && record.due > self.now;
        // The test was in flight when the node was opened; its parts have their own tests now.
        if is_open && !self.is_leaf(node) {
            return;
        }
        self.set_hidden(node);
    }

    fn set_hidden(&mut self, node: u32) {
        let tested = self.tested;
        self.update(node, |record| {
            if record.state != NodeState::Hidden {
                record.state = NodeState::Hidden;
                record.since = tested;
            }
            record.stable_queries = 0;
        });
    }

    fn leaf_showed(&mut self, node: u32) {
        let mut record = self.history.record(node);
        if record.state != NodeState::Visible {
            let was_brief = record.state == NodeState::Hidden
                && self.tested.since(record.since) <= FLICKER_FRAMES;
            // A leaf that became hidden by the answer of its node in the same frame was not hidden
            // before.
            if record.since != self.tested {
                record.flicker_count =
                    if was_brief { record.flicker_count.saturating_add(1) } else { 0 };
            }
            record.state = NodeState::Visible;
            record.since = self.tested;
            record.stable_queries = 0;
            record.due = self.now.plus(retest_interval(&record, self.config, self.rng));
            self.update(node, |slot| *slot = record);
        }
        self.pull_up(node);
    }

    /// Notes that the box of a visible leaf showed. This says little, because the box may show
    /// where the leaf does not; after some such answers the leaf's own draw is tested.
    fn visible_box_showed(&mut self, node: u32) {
        self.update(node, |record| record.stable_queries = record.stable_queries.saturating_add(1));
    }

    fn visible_draw_showed(&mut self, node: u32) {
        let mut record = self.history.record(node);
        if record.state != NodeState::Visible {
            record.state = NodeState::Visible;
            record.since = self.tested;
            record.stable_queries = 0;
        }
        record.flicker_count = 0;
        record.stable_queries = record.stable_queries.saturating_add(1);
        record.due = self.now.plus(retest_interval(&record, self.config, self.rng));
        self.update(node, |slot| *slot = record);
        self.pull_up(node);
    }

    fn inner_showed(&mut self, node: u32) {
        let record = self.history.record(node);
        if record.state != NodeState::Visible || record.due <= self.now {
            self.open(node);
        }
        self.pull_up(node);
    }

    /// Marks a node that showed after its leaves were tested individually: leaves that showed have
    /// answers of their own, and all other leaves are hidden.
    fn leaves_showed(&mut self, top: u32) {
        let failures = self.failures_of(top);
        let end = self.topology.nodes[top as usize].end(top);
        for node in top..end {
            let tested = self.tested;
            self.update(node, |record| {
                if record.answered < tested {
                    if record.state != NodeState::Hidden {
                        record.state = NodeState::Hidden;
                        record.since = tested;
                    }
                    record.stable_queries = 0;
                }
                // The GPU tested this node even if the traversal did not visit it.
                record.visited = record.visited.max(tested);
            });
        }
        let due = self.open_until(failures);
        let tested = self.tested;
        self.update(top, |record| {
            if record.state != NodeState::Visible {
                record.state = NodeState::Visible;
                record.since = tested;
            }
            record.due = due;
            record.stable_queries = failures;
        });
        self.pull_up(top);
    }

    /// Returns the number of times that a node which shows was tested as one in vain: in many views
    /// its box shows although the boxes of its parts do not.
    fn failures_of(&self, node: u32) -> u8 {
        if self.is_leaf(node) {
            return 0;
        }
        let children = self.topology.nodes[node as usize].children(node);
        let is_hidden = |child| self.history.record(child).state == NodeState::Hidden;
        if children.into_iter().all(is_hidden) {
            self.history.record(node).stable_queries.saturating_add(1)
        } else {
            0
        }
    }

    /// Opens a node that showed and some levels below it, so that small parts are tested next. A
    /// part that was visible becomes unknown unless it has a newer answer.
    fn open(&mut self, top: u32) {
        let top_level = self.topology.nodes[top as usize].level;
        let mut node = top;
        let end = self.topology.nodes[top as usize].end(top);
        while node < end {
            let links = self.topology.nodes[node as usize];
            let depth = links.level - top_level;
            let is_opened = !links.is_leaf()
                && (depth < self.config.tuning.open_levels
                    || (depth < self.config.tuning.open_levels_max
                        && links.leaf_count > self.config.tuning.open_leaves));
            if is_opened {
                let tested = self.tested;
                let due = self.open_until(0);
                self.update(node, |record| {
                    record.state = NodeState::Visible;
                    record.since = tested;
                    record.due = due;
                    record.stable_queries = 0;
                });
                node += 1;
                continue;
            }
            let tested = self.tested;
            self.update(node, |record| {
                if record.state == NodeState::Visible && record.answered < tested {
                    record.state = NodeState::Unknown;
                }
            });
            node = links.end(node);
        }
    }

    fn open_until(&mut self, failures: u8) -> FrameStamp {
        let exponent = u32::from(failures).min(self.config.tuning.pull_up_backoff).min(16);
        let frames = self.config.tuning.open_frames.saturating_mul(1 << exponent);
        let jitter = self.rng.between(0, self.config.tuning.open_jitter);
        self.now.plus(frames.saturating_add(jitter))
    }

    /// Merges an open node whose pull-up query did not show: from now on one query tests it.
    fn merge(&mut self, node: u32) {
        if self.is_leaf(node) {
            return;
        }
        let children = self.topology.nodes[node as usize].children(node);
        let since = children
            .map(|child| self.history.record(child))
            .iter()
            .filter(|child| child.state == NodeState::Hidden)
            .map(|child| child.since)
            .max()
            .unwrap_or(self.tested);
        self.update(node, |record| {
            if record.state != NodeState::Hidden {
                record.state = NodeState::Hidden;
                record.since = since;
            }
            record.stable_queries = 0;
        });
    }

    fn pull_up_failed(&mut self, node: u32) {
        let failures = self.history.record(node).stable_queries;
        let due = self.open_until(failures);
        self.update(node, |record| {
            record.due = due;
            record.stable_queries = failures.saturating_add(1);
        });
    }

    /// Marks the ancestors of a node that showed as visible. Stops at the first ancestor that is
    /// already marked or was found hidden in a later frame.
    fn pull_up(&mut self, node: u32) {
        let mut parent = self.topology.nodes[node as usize].parent;
        while parent != NO_NODE {
            let record = self.history.record(parent);
            let is_told = record.state == NodeState::Visible && record.answered >= self.tested;
            let knows_better = record.state == NodeState::Hidden && record.answered > self.tested;
            if is_told || knows_better {
                return;
            }
            let due =
                if record.state == NodeState::Visible { record.due } else { self.open_until(0) };
            let tested = self.tested;
            self.update(parent, |record| {
                if record.state != NodeState::Visible {
                    record.state = NodeState::Visible;
                    record.since = tested;
                    record.stable_queries = 0;
                }
                record.answered = record.answered.max(tested);
                record.visited = record.visited.max(tested);
                record.due = due;
            });
            parent = self.topology.nodes[parent as usize].parent;
        }
    }
}
