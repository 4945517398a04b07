//! One view of a scene with its own visibility history: what was asked, what came home.

use std::collections::VecDeque;

use cull::{
    Answer, Culler, FrameId, FramePlan, Hierarchy, LeafRange, Policy, QueryTag, Strategy, View,
};
use gpu::{Device, DrawRange, Frame, QueryRing, Tick};

use crate::error::Error;
use crate::geometry::Geometry;
use crate::pyramid_history::PyramidHistory;

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

/// One view of a scene: its culler, its queries in flight, and the plan of its newest frame.
/// Several views may look at one scene; each has its own history.
pub struct ViewHistory {
    pub(crate) culler: Culler,
    pub(crate) queries: QueryRing<QueryTag>,
    pub(crate) plan: FramePlan,
    // Scratch for the newest frame, kept to allocate nothing in the steady state: what each query
    // is about, in the order of the queries: the queried draws, then the tests.
    pub(crate) tags: Vec<QueryTag>,
    pyramid: Option<PyramidHistory>,
    frames_in_flight: usize,
    device: Device,
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
            pyramid: None,
            frames_in_flight,
            device: device.clone(),
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
    pub(crate) fn ingest(&mut self, completed: Tick, hierarchy: &Hierarchy, geometry: &Geometry) {
        let Self { culler, queries, pyramid, answers, pending, outcomes, .. } = self;
        answers.clear();
        queries.collect(completed, |tag, samples| answers.push(Answer { tag, samples }));
        for answer in answers.iter() {
            let outcome = pending.iter_mut().find(|pending| pending.frame == answer.tag.frame);
            if let Some(outcome) = outcome
                && answer.samples > 0
                && answer.tag.kind == cull::QueryKind::Proxy
            {
                let leaves = hierarchy.leaves(answer.tag.node);
                outcome.draws += u64::from(leaves.count);
                outcome.revealed += u64::from(leaves.count);
                outcome.triangles += geometry.triangles(leaves);
            }
        }
        let mut newest = answers.iter().map(|answer| answer.tag.frame).max();
        while let Some(counts) = pyramid.as_mut().and_then(|kept| kept.take_counts(completed)) {
            newest = newest.max(Some(counts.frame));
            if let Some(outcome) = pending.iter_mut().find(|pending| pending.frame == counts.frame)
            {
                let [first, second] = counts.phases;
                outcome.draws = u64::from(first.draws) + u64::from(second.draws);
                outcome.triangles = first.triangles() + second.triangles();
                outcome.revealed = second.draws.into();
            }
        }
        if let Some(newest) = newest {
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
        strategy: Strategy,
        view: &View,
        query_budget: usize,
    ) {
        self.culler.plan(hierarchy, strategy, view, query_budget, &mut self.plan);
        let own = self.plan.queried_draws.iter().map(|(_, tag)| *tag);
        self.tags.clear();
        self.tags.extend(own.chain(self.plan.tests.iter().map(|test| test.tag)));
    }

    /// Begins a frame that the GPU decides about: an empty plan without queries.
    pub(crate) fn begin_pyramid(
        &mut self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
    ) -> Result<&mut PyramidHistory, Error> {
        self.culler.plan_known(hierarchy, &[], &mut self.plan);
        self.tags.clear();
        self.queries.begin(frame, &self.tags)?;
        let kept = match self.pyramid.take() {
            Some(kept) => kept,
            None => PyramidHistory::new(&self.device, hierarchy, self.frames_in_flight)?,
        };
        let kept = self.pyramid.insert(kept);
        kept.begin(&self.device, hierarchy, self.plan.frame, frame.slot())?;
        Ok(kept)
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
            outcome.triangles += geometry.triangles(LeafRange { first, count: 1 });
        }
        let is_counted_on_gpu =
            self.pyramid.as_mut().is_some_and(|kept| kept.submitted(tick, outcome.frame));
        if self.tags.is_empty() && !is_counted_on_gpu {
            self.outcomes.push(outcome);
        } else {
            self.pending.push_back(outcome);
        }
    }
}
