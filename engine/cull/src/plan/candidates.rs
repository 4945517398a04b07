//! The lists of a plan in the making: draws and tests, in their order.

use crate::geom::bounds::Aabb;
use crate::geom::multi_view::{MultiView, ViewMasks};
use crate::history::record::FrameStamp;
use crate::ids::LeafIndex;
use crate::plan::frame_plan::{PlanStats, QueryKind};

/// The squared distance from the eye as sortable bits: non-negative floats sort like their bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Nearness(u32);

impl Nearness {
    pub(crate) fn of(bounds: &Aabb, views: MultiView<'_>) -> Self {
        Self(views.distance_squared(bounds).to_bits())
    }

    pub(crate) fn distance(self) -> f32 {
        f32::from_bits(self.0).sqrt()
    }
}

/// A node in the frustum that is to be visited.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waiting {
    pub(crate) node: u32,
    pub(crate) nearness: Nearness,
    pub(crate) above: Above,
}

/// The state that a node inherits from the nodes above.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Above {
    pub(crate) masks: ViewMasks,
    /// The frame since which a node above has been hidden as a whole.
    pub(crate) hidden_since: Option<FrameStamp>,
}

/// A leaf to draw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draw {
    pub(crate) nearness: Nearness,
    pub(crate) leaf: LeafIndex,
}

/// A leaf to draw under a query.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Retest {
    pub(crate) nearness: Nearness,
    pub(crate) leaf: LeafIndex,
    pub(crate) node: u32,
    /// The number of draws before it.
    pub(crate) after: u32,
}

/// A node to test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) nearness: Nearness,
    pub(crate) node: u32,
    /// The kind: proxy, pull-up query or own box.
    pub(crate) kind: QueryKind,
    pub(crate) proxy: Aabb,
    pub(crate) leaf_count: u32,
    /// The frame since which a node above it was hidden, unless something newer is known.
    pub(crate) inherited: Option<FrameStamp>,
    /// The number of frames for which the node has been hidden; `None` if it is not known to be
    /// hidden. 0 for pull-up queries and own boxes, whose nodes are visible.
    pub(crate) hidden_frames: Option<u32>,
}

impl Candidate {
    pub(crate) fn is_unknown(&self) -> bool {
        self.hidden_frames.is_none()
    }
}

/// The expected saving of tests, and the cost of interrupting rendering for them (ns).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Prospect {
    pub(crate) saving_ns: f32,
    pub(crate) break_ns: f32,
}

/// The lists of one plan in the making, kept so that steady frames do not allocate.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    pub(crate) waiting: Vec<Waiting>,
    pub(crate) draws: Vec<Draw>,
    pub(crate) retests: Vec<Retest>,
    pub(crate) tests: Vec<Candidate>,
    pub(crate) visited: Vec<u32>,
    /// Each leaf drawn without a test although nothing is known of it, with the node left untested.
    pub(crate) assumed: Vec<[u32; 2]>,
    pub(crate) stack: Vec<(u32, ViewMasks)>,
    pub(crate) by_size: Vec<u32>,
    pub(crate) is_dropped: Vec<bool>,
    /// The prospect of all tests that pay individually.
    pub(crate) prospect: Prospect,
    /// The expected time of the draws that these tests reveal, over the frames for which the leaves
    /// then count as visible.
    pub(crate) revealed_ns: f32,
}

impl Scratch {
    pub(crate) fn clear(&mut self) {
        self.waiting.clear();
        self.draws.clear();
        self.retests.clear();
        self.tests.clear();
        self.visited.clear();
        self.assumed.clear();
    }

    /// Finds the place of each retest among the draws.
    pub(crate) fn place_retests(&mut self) {
        for retest in &mut self.retests {
            let before = self.draws.partition_point(|draw| draw.nearness <= retest.nearness);
            retest.after = before as u32;
        }
        self.sort_retests();
    }

    pub(crate) fn sort_retests(&mut self) {
        self.retests.sort_unstable_by_key(|retest| (retest.nearness, retest.leaf));
    }

    pub(crate) fn sort_tests(&mut self) {
        self.tests.sort_unstable_by_key(|test| (test.nearness, test.node));
    }

    /// Returns the tests that decide about draws.
    pub(crate) fn frontier(&self) -> impl Iterator<Item = &Candidate> {
        self.tests.iter().filter(|test| test.kind == QueryKind::Proxy)
    }

    /// Draws the retests from index `first` on without a query.
    pub(crate) fn draw_unasked(&mut self, first: usize) {
        let excess = self.retests.drain(first.min(self.retests.len())..);
        self.draws
            .extend(excess.map(|retest| Draw { nearness: retest.nearness, leaf: retest.leaf }));
    }

    /// Unmarks all tests.
    pub(crate) fn keep_all(&mut self) {
        self.is_dropped.clear();
        self.is_dropped.resize(self.tests.len(), false);
    }

    /// Removes the marked tests and unmarks the rest.
    pub(crate) fn discard(&mut self) {
        let mut marks = self.is_dropped.iter();
        self.tests.retain(|_| !marks.next().copied().unwrap_or(false));
        self.keep_all();
    }

    pub(crate) fn sort_draws(&mut self) {
        self.draws.sort_unstable_by_key(|draw| (draw.nearness, draw.leaf));
    }

    /// Adds the planned draws and tests to the counts.
    pub(crate) fn count(&self, stats: &mut PlanStats) {
        let visible_box_queries =
            self.tests.iter().filter(|test| test.kind == QueryKind::VisibleBoxQuery);
        stats.visible_box_queries = visible_box_queries.count() as u32;
        for test in self.frontier() {
            stats.frontier += 1;
            stats.tested_leaves = stats.tested_leaves.saturating_add(test.leaf_count);
            stats.unknown += u32::from(test.is_unknown());
        }
    }
}
