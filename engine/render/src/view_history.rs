//! One view of a scene with its own visibility history: what was asked, what came home.

use std::collections::VecDeque;

use cull::{
    Answer, Culler, FrameId, FramePlan, Hierarchy, LeafRange, Policy, QueryTag, Strategy, View,
};
use gpu::{Device, DrawRange, QueryRing, Tick};

use crate::error::Error;
use crate::geometry::Geometry;
use crate::leaf_counts::Count;

/// What a frame turned out to be, known once its answers are home.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameOutcome {
    /// The frame.
    pub frame: FrameId,
    /// Objects the GPU drew: those taken as visible and those whose proxy showed.
    pub draws: u64,
    /// Triangles of those objects.
    pub triangles: u64,
    /// Objects among `draws` that were drawn because a proxy showed.
    pub revealed: u64,
}

/// A query on its way: what was asked, and what its answer decides about, counted when it was asked,
/// since the scene may change before the answer is home.
#[derive(Clone, Copy)]
pub(crate) struct Asked {
    pub(crate) tag: QueryTag,
    count: Count,
}

/// One view of a scene: its culler, its queries in flight, and the plan of its newest frame.
/// Several views may look at one scene; each has its own history.
pub struct ViewHistory {
    pub(crate) culler: Culler,
    pub(crate) queries: QueryRing<Asked>,
    pub(crate) plan: FramePlan,
    // Scratch for the newest frame, kept to allocate nothing in the steady state: what each query
    // is about, in the order of the queries: the queried draws, then the tests.
    pub(crate) tags: Vec<Asked>,
    answers: Vec<Answer>,
    pending: VecDeque<FrameOutcome>,
    outcomes: Vec<FrameOutcome>,
}

impl ViewHistory {
    pub(crate) fn new(
        device: &Device,
        frames_in_flight: usize,
        policy: Policy,
    ) -> Result<Self, Error> {
        Ok(Self {
            culler: Culler::new(policy),
            queries: QueryRing::new(device, frames_in_flight, "occlusion queries")?,
            plan: FramePlan::default(),
            tags: Vec::new(),
            answers: Vec::new(),
            pending: VecDeque::new(),
            outcomes: Vec::new(),
        })
    }

    /// The plan of the newest frame.
    pub fn plan(&self) -> &FramePlan {
        &self.plan
    }

    /// Takes the outcomes of the frames whose answers came home since the last call.
    pub fn take_outcomes(&mut self) -> std::vec::Drain<'_, FrameOutcome> {
        self.outcomes.drain(..)
    }

    /// Picks up every answer that is home and lets the history move on. Never waits.
    pub(crate) fn ingest(&mut self, completed: Tick, hierarchy: &Hierarchy) {
        let Self { culler, queries, answers, pending, outcomes, .. } = self;
        answers.clear();
        queries.collect(completed, |Asked { tag, count }, samples| {
            answers.push(Answer { tag, samples });
            let outcome = pending.iter_mut().find(|pending| pending.frame == tag.frame);
            if let Some(outcome) = outcome
                && samples > 0
                && tag.kind == cull::QueryKind::Proxy
            {
                outcome.draws += count.draws;
                outcome.revealed += count.draws;
                outcome.triangles += count.triangles;
            }
        });
        if let Some(newest) = answers.iter().map(|answer| answer.tag.frame).max() {
            while let Some(outcome) = pending.pop_front_if(|outcome| outcome.frame <= newest) {
                outcomes.push(outcome);
            }
        }
        culler.ingest(hierarchy, answers.iter().copied());
    }

    /// The answers of the last [`ViewHistory::ingest`].
    pub(crate) fn answers(&self) -> &[Answer] {
        &self.answers
    }

    /// The age in frames of each answer used for the newest plan.
    pub(crate) fn answer_ages(&self) -> impl Iterator<Item = u64> {
        let now = self.plan.frame.0;
        self.answers.iter().map(move |answer| now.saturating_sub(answer.tag.frame.0))
    }

    /// Plans the next frame and lists its queries.
    pub(crate) fn decide(
        &mut self,
        hierarchy: &Hierarchy,
        geometry: &Geometry,
        strategy: Strategy,
        view: &View,
        query_budget: usize,
    ) {
        self.culler.plan(hierarchy, strategy, view, query_budget, &mut self.plan);
        let nothing = Count::default();
        let own =
            self.plan.queried_draws.iter().map(|(_, tag)| Asked { tag: *tag, count: nothing });
        let tests = self.plan.tests.iter();
        let tests = tests.map(|test| Asked { tag: test.tag, count: geometry.count(test.leaves) });
        self.tags.clear();
        self.tags.extend(own.chain(tests));
    }

    /// What each query decides about, in the order of the queries.
    pub(crate) fn draw_ranges(&self) -> impl ExactSizeIterator<Item = DrawRange> {
        let own = self.plan.queried_draws.len();
        (0..self.tags.len()).map(move |query| {
            let test = query.checked_sub(own).and_then(|test| self.plan.tests.get(test));
            test.map_or(DrawRange::default(), |test| DrawRange {
                first: test.leaves.first.0,
                count: test.leaves.count,
            })
        })
    }

    /// The newest frame is on its way: opens the books on it.
    pub(crate) fn submitted(&mut self, tick: Tick, geometry: &Geometry) {
        self.queries.submitted(tick);
        let taken = self.plan.draws.iter().copied();
        let taken = taken.chain(self.plan.queried_draws.iter().map(|(leaf, _)| *leaf));
        let mut outcome =
            FrameOutcome { frame: self.plan.frame, draws: 0, triangles: 0, revealed: 0 };
        for first in taken {
            outcome.draws += 1;
            outcome.triangles += geometry.count(LeafRange { first, count: 1 }).triangles;
        }
        if self.tags.is_empty() {
            self.outcomes.push(outcome);
        } else {
            self.pending.push_back(outcome);
        }
    }
}
