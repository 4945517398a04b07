//! One view of a scene with its own visibility history: what was asked, what came home.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};

use cull::{
    Answer, Corrections, CostModel, Culler, FrameContents, FrameId, FramePlan, Generation,
    Hierarchy, LeafIndex, LeafRange, QueryKind, QueryTag, Strategy, Tester, View,
};
use gpu::{
    Counting, Device, DrawRange, FlagRing, Frame, FrameTime, IndirectDraw, PartDraws, QueryRing,
    SwitchedOn, Tick, WordSource,
};

use crate::dialogue_frame::DialogueHistory;
use crate::error::Error;
use crate::frame_times::SentFrames;
use crate::geometry::Geometry;
use crate::leaf_counts::Count;
use crate::pyramid_history::PyramidHistory;
use crate::questions::{Asked, Questions};
use crate::renderer::Renderer;
use crate::sample_counts::SampleCounts;
use crate::visible_set::VisibleSet;

/// What a frame turned out to be, known once its answers are home.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameOutcome {
    /// The frame.
    pub frame: FrameId,
    /// Objects the GPU drew: those taken as visible and those whose proxy showed.
    pub draws: u64,
    /// Triangles of those objects. Where leaves were drawn one by one, as many as they have when that
    /// is known: if others moved in meanwhile, those count.
    pub triangles: u64,
    /// Objects among `draws` that were drawn because a proxy showed.
    pub revealed: u64,
    /// Samples of tests that showed, but not more than the threshold, so that what they stand for was
    /// left out: at most so many pixels are wrong. 0 without a threshold.
    pub neglected_samples: u64,
}

/// An answer that is home, and what was drawn if it says that something shows.
struct Answered {
    answer: Answer,
    count: Count,
}

/// The outcome of a frame that is not told yet: frames are told in their order.
#[derive(Clone, Copy)]
struct Pending {
    outcome: FrameOutcome,
    /// Nothing was asked, so that no answer is to come.
    is_known: bool,
}

/// Which renderer a view is of: its rings, its draws and what it knows fit no other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct RendererId(u64);

impl RendererId {
    /// One that no other renderer of the process has.
    pub(crate) fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// One view of a scene: its culler, its queries in flight, and the plan of its newest frame.
/// Several views may look at one scene; each has its own history.
pub struct ViewState {
    pub(crate) renderer: RendererId,
    pub(crate) culler: Culler,
    pub(crate) queries: QueryRing<Asked>,
    pub(crate) flags: FlagRing<Asked>,
    pub(crate) computed: FlagRing<Asked>,
    pub(crate) parts: PartDraws<(FrameId, Generation)>,
    pub(crate) plan: FramePlan,
    /// That of the hierarchy that the plan is for.
    pub(crate) generation: Generation,
    pub(crate) questions: Questions,
    pub(crate) counts: SampleCounts,
    pub(crate) dialogue: Option<DialogueHistory>,
    pyramid: Option<PyramidHistory>,
    pub(crate) frames_in_flight: usize,
    /// What the frames were made of whose time is not home.
    pub(crate) sent: SentFrames,
    pub(crate) device: Device,
    /// Up to which change of a draw `parts` knows the draws.
    seen_changes: u64,
    threshold_samples: u32,
    /// By the dialogue of the newest frame.
    pub(crate) neglected_by_dialogue: u64,
    answers: Vec<Answered>,
    behind: Vec<Asked>,
    newest: Vec<Answer>,
    pending: VecDeque<Pending>,
    outcomes: VecDeque<FrameOutcome>,
}

/// What is on its way between a view and the GPU, a slot for each frame in flight.
struct Rings {
    queries: QueryRing<Asked>,
    flags: FlagRing<Asked>,
    computed: FlagRing<Asked>,
    parts: PartDraws<(FrameId, Generation)>,
}

impl Rings {
    fn new(renderer: &Renderer) -> Result<Self, Error> {
        let Renderer { device, hierarchy, frames, .. } = renderer;
        let slots = frames.frames_in_flight();
        let leaves = hierarchy.leaf_objects().len() as u32;
        let counting = if renderer.is_exact() { Counting::Some } else { Counting::Samples };
        let queries = QueryRing::new(device, slots, "occlusion queries")?;
        Ok(Self {
            queries: queries.counting(counting),
            flags: FlagRing::new(device, slots, WordSource::Fragments, "proxy flags"),
            computed: FlagRing::new(device, slots, WordSource::Compute, "box words"),
            parts: PartDraws::new(device, slots, leaves),
        })
    }
}

/// Outcomes that are kept for who asks seldom, or never.
const OUTCOMES_KEPT: usize = 1024;

impl ViewState {
    pub(crate) fn new(renderer: &Renderer, culler: Culler) -> Result<Self, Error> {
        let Renderer { device, hierarchy, .. } = renderer;
        let frames_in_flight = renderer.frames.frames_in_flight();
        let Rings { queries, flags, computed, parts } = Rings::new(renderer)?;
        Ok(Self {
            renderer: renderer.id,
            culler,
            queries,
            flags,
            computed,
            parts,
            plan: FramePlan::default(),
            generation: hierarchy.generation(),
            questions: Questions::default(),
            counts: SampleCounts::default(),
            dialogue: None,
            pyramid: None,
            frames_in_flight,
            sent: SentFrames::new(frames_in_flight),
            device: device.clone(),
            seen_changes: renderer.passes.geometry.draw_changes.count(),
            threshold_samples: renderer.threshold_samples,
            neglected_by_dialogue: 0,
            answers: Vec::new(),
            behind: Vec::new(),
            newest: Vec::new(),
            pending: VecDeque::new(),
            outcomes: VecDeque::new(),
        })
    }

    /// Makes the rings anew where another number of frames is in flight. What was asked is never
    /// answered then, and the culler asks again.
    pub(crate) fn follow_ring(&mut self, renderer: &Renderer) -> Result<(), Error> {
        let frames_in_flight = renderer.frames.frames_in_flight();
        if self.frames_in_flight == frames_in_flight {
            return Ok(());
        }
        let Rings { queries, flags, computed, parts } = Rings::new(renderer)?;
        (self.queries, self.flags, self.computed, self.parts) = (queries, flags, computed, parts);
        self.counts.forget_ring();
        (self.dialogue, self.pyramid) = (None, None);
        self.seen_changes = renderer.passes.geometry.draw_changes.count();
        self.pending.clear();
        self.sent = SentFrames::new(frames_in_flight);
        self.frames_in_flight = frames_in_flight;
        Ok(())
    }

    /// The plan of the newest frame.
    pub fn plan(&self) -> &FramePlan {
        &self.plan
    }

    /// Forgets everything that was seen; the next frame starts like the first. After a change that
    /// makes the past worthless, such as a jump to another place.
    pub fn forget(&mut self) {
        self.culler.forget();
    }

    /// Takes the outcomes of the frames whose answers came home since the last call: the latest
    /// 1024, if there are more.
    pub fn take_outcomes(&mut self) -> std::collections::vec_deque::Drain<'_, FrameOutcome> {
        self.outcomes.drain(..)
    }

    /// Picks up every answer that is home and lets the history move on. Never waits.
    pub(crate) fn ingest(&mut self, completed: Tick, hierarchy: &Hierarchy, geometry: &Geometry) {
        self.collect(completed, hierarchy, geometry);
        self.counts.collect(completed, hierarchy, self.plan.frame);
        let threshold = self.threshold_samples;
        let Self { culler, pyramid, answers, newest: kept, pending, outcomes, sent, .. } = self;
        for Answered { answer, count } in answers.iter().filter(|home| home.answer.samples > 0) {
            let is_drawn = matches!(answer.tag.kind, QueryKind::Proxy | QueryKind::Part);
            let Some(outcome) = outcome_of(pending, answer.tag.frame) else { continue };
            if !shows(answer, threshold) {
                let decides = is_drawn || answer.tag.kind == QueryKind::Parts;
                outcome.neglected_samples += u64::from(answer.samples) * u64::from(decides);
            } else if is_drawn {
                outcome.draws += count.draws;
                outcome.revealed += count.draws;
                outcome.triangles += count.triangles;
            }
        }
        let answers = answers.iter().map(|home| home.answer);
        let mut newest = answers.clone().map(|answer| answer.tag.frame).max();
        if let Some(newest) = newest {
            kept.clear();
            kept.extend(answers.clone().filter(|answer| answer.tag.frame == newest));
        }
        while let Some(counts) = pyramid.as_mut().and_then(|kept| kept.take_counts(completed)) {
            newest = newest.max(Some(counts.frame));
            if let Some(outcome) = outcome_of(pending, counts.frame) {
                let [first, second] = counts.phases;
                outcome.draws = u64::from(first.draws) + u64::from(second.draws);
                outcome.triangles = first.triangles() + second.triangles();
                outcome.revealed = second.draws.into();
            }
        }
        let is_home = |it: &mut Pending| {
            it.is_known || newest.is_some_and(|newest| it.outcome.frame <= newest)
        };
        while let Some(Pending { outcome, .. }) = pending.pop_front_if(is_home) {
            sent.drew(&outcome);
            keep_latest(outcomes, outcome);
        }
        culler.ingest(hierarchy, answers);
    }

    /// Gathers the answers that are home, those of older frames first, and in a frame those for the
    /// parts of a node after the node's.
    fn collect(&mut self, completed: Tick, hierarchy: &Hierarchy, geometry: &Geometry) {
        let Self { queries, flags, computed, parts, answers, behind, .. } = self;
        answers.clear();
        behind.clear();
        let answered = |asked: &Asked, samples| Answered {
            answer: Answer { tag: asked.tag, samples },
            count: asked.count,
        };
        queries.collect(completed, |asked, samples| answers.push(answered(&asked, samples)));
        flags.collect(completed, |tags, words| {
            let answer = |(number, flag): (usize, &Asked)| {
                let word = |number: usize| words.get(number).copied();
                let samples = match flag.tester {
                    Tester::Flag => word(number),
                    // Behind a box that shows, the leaves answer for their node, below.
                    Tester::Behind(front) => word(front as usize).filter(|word| {
                        behind.extend((*word != 0).then_some(*flag));
                        *word == 0
                    }),
                    Tester::Query | Tester::Compute => None,
                };
                samples.map(|samples| answered(flag, samples))
            };
            answers.extend(tags.iter().enumerate().filter_map(answer));
        });
        computed.collect(completed, |tags, words| {
            let mine = tags.iter().zip(words).filter(|(asked, _)| asked.tester == Tester::Compute);
            answers.extend(mine.map(|(asked, word)| answered(asked, *word)));
        });
        parts.collect(completed, |(frame, generation), switched_on| match switched_on {
            SwitchedOn::These(leaves) => {
                answers.extend(leaves.iter().filter_map(|leaf| {
                    // If the leaf was dealt out anew since, its node is younger than the answer.
                    let object = hierarchy.leaf_objects().get(*leaf as usize)?;
                    let (node, kind) = (hierarchy.node_of(*object)?, QueryKind::Part);
                    let answer =
                        Answer { tag: QueryTag { node, generation, frame, kind }, samples: 1 };
                    let leaf = LeafRange { first: LeafIndex(*leaf), count: 1 };
                    Some(Answered { answer, count: geometry.count(leaf) })
                }));
                answers.extend(behind.iter().filter(|asked| asked.tag.frame == frame).map(
                    |asked| {
                        let range = hierarchy.leaves(asked.tag.node);
                        let shows = leaves.iter().any(|leaf| range.contains(LeafIndex(*leaf)));
                        answered(asked, u32::from(shows))
                    },
                ));
            }
            // Which of the leaves showed is not known: the nodes answer for all of them.
            SwitchedOn::TooMany(_) => {
                let asked = behind.iter().filter(|asked| asked.tag.frame == frame);
                answers.extend(asked.map(|asked| answered(asked, 1)));
                let tags = answers.iter_mut().map(|home| &mut home.answer.tag);
                let of_frame = tags.filter(|tag| tag.frame == frame);
                for tag in of_frame.filter(|tag| tag.kind == QueryKind::Parts) {
                    tag.kind = QueryKind::Proxy;
                }
            }
        });
        // Fragments list leaves as they come: sorted, so that equal frames have equal answers.
        answers.sort_unstable_by_key(|Answered { answer: Answer { tag, .. }, .. }| {
            (tag.frame, tag.kind == QueryKind::Part, tag.node)
        });
    }

    /// Brings the copies of draws up to date with a scene that changed.
    pub(crate) fn follow_draws(&mut self, geometry: &Geometry) {
        let changes = &geometry.draw_changes;
        match changes.since(self.seen_changes) {
            Some(leaves) => {
                leaves.for_each(|leaf| self.parts.changed(DrawRange { first: leaf.0, count: 1 }));
            }
            None => self.parts.all_changed(),
        }
        self.seen_changes = changes.count();
    }

    /// Whether what an answer is about shows by more than the threshold.
    pub(crate) fn shows(&self, answer: &Answer) -> bool {
        shows(answer, self.threshold_samples)
    }

    /// All answers to the newest frame that has any.
    pub(crate) fn newest_answers(&self) -> &[Answer] {
        &self.newest
    }

    /// The age in frames of each answer used for the newest plan.
    pub(crate) fn answer_ages(&self) -> impl Iterator<Item = u64> {
        let now = self.plan.frame.0;
        self.answers.iter().map(move |home| now.saturating_sub(home.answer.tag.frame.0))
    }

    /// Plans the next frame and lays out what it asks.
    pub(crate) fn decide(
        &mut self,
        hierarchy: &Hierarchy,
        geometry: &Geometry,
        strategy: Strategy,
        view: &View,
        query_budget: usize,
    ) {
        self.culler.plan(hierarchy, strategy, view, query_budget, &mut self.plan);
        self.generation = hierarchy.generation();
        self.questions.lay_out(&self.plan, geometry);
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

    /// What frames taught this view's governor about the prices; `None` without one.
    pub fn corrections(&self) -> Option<Corrections> {
        self.culler.governor().map(CostModel::corrections)
    }

    /// Whether there is a governor to be told what frames take.
    pub(crate) fn is_governed(&self) -> bool {
        self.culler.governor().is_some()
    }

    /// A frame that showed this view, with others if they were drawn together, took so long.
    pub(crate) fn took(&mut self, time: &FrameTime, contents: &FrameContents) {
        if let Some(governor) = self.culler.governor_mut() {
            governor.observe(time.gpu_ms * 1.0e6, contents);
        }
    }

    /// The newest frame is on its way: opens the books on it.
    pub(crate) fn submitted(&mut self, tick: Tick, geometry: &Geometry) {
        self.queries.submitted(tick);
        self.flags.submitted(tick);
        self.computed.submitted(tick);
        self.parts.submitted(tick);
        self.counts.submitted(tick, self.plan.frame);
        let taken = self.plan.draws.iter().copied();
        let taken = taken.chain(self.plan.queried_draws.iter().map(|(leaf, _)| *leaf));
        let mut outcome = FrameOutcome {
            frame: self.plan.frame,
            draws: 0,
            triangles: 0,
            revealed: 0,
            neglected_samples: std::mem::take(&mut self.neglected_by_dialogue),
        };
        for first in taken {
            let count = geometry.count(LeafRange { first, count: 1 });
            outcome.draws += count.draws;
            outcome.triangles += count.triangles;
        }
        let is_counted_on_gpu =
            self.pyramid.as_mut().is_some_and(|kept| kept.submitted(tick, outcome.frame));
        let is_known = self.questions.is_empty() && !is_counted_on_gpu;
        if is_known && self.pending.is_empty() {
            self.sent.drew(&outcome);
            keep_latest(&mut self.outcomes, outcome);
        } else {
            self.pending.push_back(Pending { outcome, is_known });
        }
    }
}

fn outcome_of(pending: &mut VecDeque<Pending>, frame: FrameId) -> Option<&mut FrameOutcome> {
    pending.iter_mut().map(|pending| &mut pending.outcome).find(|outcome| outcome.frame == frame)
}

/// Parts are told by fragments, which do not count.
fn shows(answer: &Answer, threshold_samples: u32) -> bool {
    match answer.tag.kind {
        QueryKind::Part => answer.samples > 0,
        _ => answer.samples > threshold_samples,
    }
}

fn keep_latest(outcomes: &mut VecDeque<FrameOutcome>, outcome: FrameOutcome) {
    if outcomes.len() == OUTCOMES_KEPT {
        outcomes.pop_front();
    }
    outcomes.push_back(outcome);
}
