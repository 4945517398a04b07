//! One view of a scene with its own visibility history: what was asked, what came home.

use std::collections::VecDeque;

use cull::{
    Answer, Culler, FrameId, FramePlan, Generation, Hierarchy, LeafIndex, LeafRange, QueryKind,
    QueryTag, Strategy, Tester, View,
};
use gpu::{
    Device, DrawRange, FlagRing, Frame, IndirectDraw, PartDraws, QueryRing, SwitchedOn, Tick,
    WordSource,
};

use crate::dialogue_frame::DialogueHistory;
use crate::error::Error;
use crate::geometry::Geometry;
use crate::pyramid_history::PyramidHistory;
use crate::questions::{FlagTag, Questions};
use crate::visible_set::VisibleSet;

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
    pub(crate) flags: FlagRing<FlagTag>,
    pub(crate) computed: FlagRing<FlagTag>,
    pub(crate) parts: PartDraws<(FrameId, Generation)>,
    pub(crate) plan: FramePlan,
    /// That of the hierarchy that the plan is for.
    pub(crate) generation: Generation,
    pub(crate) questions: Questions,
    pub(crate) dialogue: Option<DialogueHistory>,
    pyramid: Option<PyramidHistory>,
    pub(crate) frames_in_flight: usize,
    pub(crate) device: Device,
    answers: Vec<Answer>,
    behind: Vec<QueryTag>,
    newest: Vec<Answer>,
    pending: VecDeque<FrameOutcome>,
    outcomes: Vec<FrameOutcome>,
}

impl ViewHistory {
    pub(crate) fn new(
        device: &Device,
        frames_in_flight: usize,
        culler: Culler,
        hierarchy: &Hierarchy,
    ) -> Result<Self, Error> {
        let leaves = hierarchy.leaf_objects().len() as u32;
        Ok(Self {
            culler,
            queries: QueryRing::new(device, frames_in_flight, "occlusion queries")?,
            flags: FlagRing::new(device, frames_in_flight, WordSource::Fragments, "proxy flags"),
            computed: FlagRing::new(device, frames_in_flight, WordSource::Compute, "box words"),
            parts: PartDraws::new(device, frames_in_flight, leaves),
            plan: FramePlan::default(),
            generation: hierarchy.generation(),
            questions: Questions::default(),
            dialogue: None,
            pyramid: None,
            frames_in_flight,
            device: device.clone(),
            answers: Vec::new(),
            behind: Vec::new(),
            newest: Vec::new(),
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
        self.collect(completed, hierarchy);
        let Self { culler, pyramid, answers, newest: kept, pending, outcomes, .. } = self;
        for answer in answers.iter().filter(|answer| answer.samples > 0) {
            let is_drawn = matches!(answer.tag.kind, QueryKind::Proxy | QueryKind::Part);
            let outcome = pending.iter_mut().find(|pending| pending.frame == answer.tag.frame);
            if let Some(outcome) = outcome.filter(|_| is_drawn) {
                let leaves = hierarchy.leaves(answer.tag.node);
                outcome.draws += u64::from(leaves.count);
                outcome.revealed += u64::from(leaves.count);
                outcome.triangles += geometry.triangles(leaves);
            }
        }
        let mut newest = answers.iter().map(|answer| answer.tag.frame).max();
        if let Some(newest) = newest {
            kept.clear();
            kept.extend(answers.iter().filter(|answer| answer.tag.frame == newest));
        }
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

    /// Gathers the answers that are home, those of older frames first, and in a frame those for the
    /// parts of a node after the node's.
    fn collect(&mut self, completed: Tick, hierarchy: &Hierarchy) {
        let Self { queries, flags, computed, parts, answers, behind, .. } = self;
        answers.clear();
        behind.clear();
        queries.collect(completed, |tag, samples| answers.push(Answer { tag, samples }));
        flags.collect(completed, |tags, words| {
            let answer = |(number, flag): (usize, &FlagTag)| {
                let word = |number: usize| words.get(number).copied();
                let samples = match flag.tester {
                    Tester::Flag => word(number),
                    // Behind a box that shows, the leaves answer for their node, below.
                    Tester::Behind(front) => word(front as usize).filter(|word| {
                        behind.extend((*word != 0).then_some(flag.tag));
                        *word == 0
                    }),
                    Tester::Query | Tester::Compute => None,
                };
                samples.map(|samples| Answer { tag: flag.tag, samples })
            };
            answers.extend(tags.iter().enumerate().filter_map(answer));
        });
        computed.collect(completed, |tags, words| {
            let mine = tags.iter().zip(words).filter(|(flag, _)| flag.tester == Tester::Compute);
            answers.extend(mine.map(|(flag, word)| Answer { tag: flag.tag, samples: *word }));
        });
        parts.collect(completed, |(frame, generation), switched_on| match switched_on {
            SwitchedOn::These(leaves) => {
                let node = |leaf: &u32| hierarchy.leaf_objects().get(*leaf as usize);
                let nodes = leaves.iter().filter_map(node).filter_map(|id| hierarchy.node_of(*id));
                let kind = QueryKind::Part;
                answers.extend(nodes.map(|node| Answer {
                    tag: QueryTag { node, generation, frame, kind },
                    samples: 1,
                }));
                answers.extend(behind.iter().filter(|tag| tag.frame == frame).map(|tag| {
                    let range = hierarchy.leaves(tag.node);
                    let shows = leaves.iter().any(|leaf| range.contains(LeafIndex(*leaf)));
                    Answer { tag: *tag, samples: u32::from(shows) }
                }));
            }
            // Which of the leaves showed is not known: the nodes answer for all of them.
            SwitchedOn::TooMany(_) => {
                let of_frame = answers.iter_mut().filter(|answer| answer.tag.frame == frame);
                for answer in of_frame.filter(|answer| answer.tag.kind == QueryKind::Parts) {
                    answer.tag.kind = QueryKind::Proxy;
                }
            }
        });
        answers
            .sort_unstable_by_key(|answer| (answer.tag.frame, answer.tag.kind == QueryKind::Part));
    }

    /// All answers to the newest frame that has any.
    pub(crate) fn newest_answers(&self) -> &[Answer] {
        &self.newest
    }

    /// The age in frames of each answer used for the newest plan.
    pub(crate) fn answer_ages(&self) -> impl Iterator<Item = u64> {
        let now = self.plan.frame.0;
        self.answers.iter().map(move |answer| now.saturating_sub(answer.tag.frame.0))
    }

    /// Plans the next frame and lays out what it asks.
    pub(crate) fn decide(
        &mut self,
        hierarchy: &Hierarchy,
        strategy: Strategy,
        view: &View,
        query_budget: usize,
    ) {
        self.culler.plan(hierarchy, strategy, view, query_budget, &mut self.plan);
        self.generation = hierarchy.generation();
        self.questions.lay_out(&self.plan);
    }

    /// Plans a frame of which it is known what is visible.
    pub(crate) fn decide_known(&mut self, hierarchy: &Hierarchy, visible: &VisibleSet) {
        self.culler.plan_known(hierarchy, visible.leaves(), &mut self.plan);
        self.generation = hierarchy.generation();
        self.questions.clear();
    }

    /// Begins a frame that is not planned here: an empty plan without questions.
    pub(crate) fn begin_unplanned(
        &mut self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
    ) -> Result<(), Error> {
        self.culler.plan_known(hierarchy, &[], &mut self.plan);
        self.generation = hierarchy.generation();
        self.questions.clear();
        self.queries.begin(frame, &[])?;
        self.flags.begin(frame, std::iter::empty())?;
        self.computed.begin(frame, std::iter::empty())?;
        let nothing = std::iter::empty::<DrawRange>();
        let no_draw = |_| IndirectDraw::default();
        self.parts.begin(frame, (self.plan.frame, self.generation), nothing, no_draw)?;
        Ok(())
    }

    /// Begins a frame that the GPU decides about.
    pub(crate) fn begin_pyramid(
        &mut self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
    ) -> Result<&mut PyramidHistory, Error> {
        self.begin_unplanned(frame, hierarchy)?;
        let kept = match self.pyramid.take() {
            Some(kept) => kept,
            None => PyramidHistory::new(&self.device, hierarchy, self.frames_in_flight)?,
        };
        let kept = self.pyramid.insert(kept);
        kept.begin(&self.device, hierarchy, self.plan.frame, frame.slot())?;
        Ok(kept)
    }

    /// The newest frame is on its way: opens the books on it.
    pub(crate) fn submitted(&mut self, tick: Tick, geometry: &Geometry) {
        self.queries.submitted(tick);
        self.flags.submitted(tick);
        self.computed.submitted(tick);
        self.parts.submitted(tick);
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
        if self.questions.is_empty() && !is_counted_on_gpu {
            self.outcomes.push(outcome);
        } else {
            self.pending.push_back(outcome);
        }
    }
}
