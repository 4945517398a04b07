//! A view of a scene with its own visibility history: its culler, its tests in flight, and the plan
//! of its newest frame.

mod api;

use std::any::Any;

use cull::{
    Answer, Corrections, CullView, Culler, FrameContents, FrameId, FramePlan, Generation,
    Hierarchy, LeafList, LeafRange, LearnedCosts, ResultReader,
};
use gpu::{
    BufferSlice, Counting, Device, DrawRange, EnabledLeaves, FlagRing, Frame, FrameTime,
    LeafDrawRing, QueryRing, RecordingId, ResultSource, Tick,
};

use crate::costs::sent_frames::SentFrames;
use crate::culled_scene::CulledScene;
use crate::draw_lists::{DrawList, DrawLists, ListedStep};
use crate::error::Error;
use crate::leaf_table::{LeafCount, LeafTable, LeafTableId};
use crate::method_state::MethodState;
use crate::outcomes::{FrameStats, Outcomes};
use crate::passes::ListDrawsIo;
use crate::quirks::DriverQuirks;
use crate::test_layout::{PendingTest, TestLayout};

/// A view of a scene: its culler, its tests in flight, and the plan of its newest frame. A scene
/// may have several views, each with its own history.
pub struct OcclusionState {
    /// The table of the view's scene.
    table: LeafTableId,
    device: Device,
    culler: Culler,
    rings: Rings,
    frames_in_flight: usize,
    plan: FramePlan,
    /// The generation of the hierarchy that the plan is for.
    generation: Generation,
    /// The scene's number of changes when the plan was made. `None` once the plan is executed.
    planned: Option<u64>,
    /// The views that the plan was made for.
    planned_views: Vec<CullView>,
    /// The frame that the newest tests were begun in: a view is drawn once per frame.
    begun_in: Option<RecordingId>,
    pub(crate) layout: TestLayout,
    /// The state of methods without plans.
    method_states: Vec<Box<dyn MethodState>>,
    /// The frames whose time is not known yet, with their contents.
    pub(crate) sent: SentFrames,
    /// The number of changes of draws that the rings have copied.
    seen_changes: u64,
    /// The samples below the threshold in the newest frame of a method without a plan.
    samples_below_threshold: u64,
    reader: ResultReader<LeafCount>,
    newest: Vec<Answer>,
    outcomes: Outcomes,
    lists: DrawLists,
}

/// The data in flight between a view and the GPU, in a slot per frame in flight.
pub(crate) struct Rings {
    pub(crate) queries: QueryRing<PendingTest>,
    pub(crate) flags: FlagRing<PendingTest>,
    pub(crate) computed: FlagRing<PendingTest>,
    pub(crate) leaf_draws: LeafDrawRing<(FrameId, Generation)>,
}

impl Rings {
    fn new(device: &Device, frames_in_flight: usize) -> Result<Self, Error> {
        let queries = QueryRing::new(device, frames_in_flight, "occlusion queries")?;
        let flags = |source, name| FlagRing::new(device, frames_in_flight, source, name);
        Ok(Self {
            queries,
            flags: flags(ResultSource::Fragments, "proxy flags"),
            computed: flags(ResultSource::Compute, "box results"),
            leaf_draws: LeafDrawRing::new(device, frames_in_flight),
        })
    }

    fn submitted(&mut self, tick: Tick) {
        self.queries.submitted(tick);
        self.flags.submitted(tick);
        self.computed.submitted(tick);
        self.leaf_draws.submitted(tick);
    }
}

impl OcclusionState {
    /// Creates a view of a scene, without history.
    pub(crate) fn new(scene: &CulledScene, mut culler: Culler) -> Result<Self, Error> {
        let CulledScene { device, hierarchy, leaves, .. } = scene;
        let frames_in_flight = scene.frames_in_flight();
        culler.reserve(hierarchy)?;
        Ok(Self {
            table: leaves.id,
            device: device.clone(),
            culler,
            rings: Rings::new(device, frames_in_flight)?,
            frames_in_flight,
            plan: FramePlan::default(),
            generation: hierarchy.generation(),
            planned: None,
            planned_views: Vec::new(),
            begun_in: None,
            layout: TestLayout::default(),
            method_states: Vec::new(),
            sent: SentFrames::new(frames_in_flight),
            seen_changes: leaves.changes.count(),
            samples_below_threshold: 0,
            reader: ResultReader::default(),
            newest: Vec::new(),
            outcomes: Outcomes::default(),
            lists: DrawLists::new(frames_in_flight),
        })
    }

    /// Creates the rings again if the number of frames in flight of the scene has changed. Tests in
    /// flight then never have a result, and the culler tests again.
    ///
    /// # Errors
    /// [`Error::ForeignView`], a failed call.
    pub fn follow_frames_in_flight(&mut self, scene: &CulledScene) -> Result<(), Error> {
        self.check(scene)?;
        let frames_in_flight = scene.frames_in_flight();
        if self.frames_in_flight == frames_in_flight {
            return Ok(());
        }
        self.rings = Rings::new(&self.device, frames_in_flight)?;
        self.method_states.clear();
        self.seen_changes = scene.leaves.changes.count();
        self.outcomes.forget_pending();
        self.sent = SentFrames::new(frames_in_flight);
        self.lists = DrawLists::new(frames_in_flight);
        self.frames_in_flight = frames_in_flight;
        Ok(())
    }

    /// Refuses a scene other than the view's own, whose leaves the rings have room for.
    ///
    /// # Errors
    /// [`Error::ForeignView`].
    pub fn check(&self, scene: &CulledScene) -> Result<(), Error> {
        if self.table == scene.leaves.id { Ok(()) } else { Err(Error::ForeignView) }
    }

    /// Returns the device of the view.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Returns the number of frames that may be in flight at once.
    pub fn frames_in_flight(&self) -> usize {
        self.frames_in_flight
    }

    /// Returns the culler of the view.
    pub fn culler(&self) -> &Culler {
        &self.culler
    }

    /// Returns the plan of the newest frame.
    pub fn plan(&self) -> &FramePlan {
        &self.plan
    }

    /// Returns the plan of the newest frame, into which a method without plans writes its draws.
    pub fn plan_mut(&mut self) -> &mut FramePlan {
        &mut self.plan
    }

    pub(crate) fn rings(&self) -> &Rings {
        &self.rings
    }

    /// Forgets the history; the next frame starts like the first.
    pub fn reset(&mut self) {
        self.culler.reset();
    }

    /// Takes the outcomes of the frames whose results were read since the last call, at most the
    /// latest 1024.
    pub fn drain_stats(&mut self) -> std::collections::vec_deque::Drain<'_, FrameStats> {
        self.outcomes.take()
    }

    /// Returns the outcome of the newest frame whose results were read, even if it was already
    /// taken.
    pub fn newest_stats(&self) -> Option<FrameStats> {
        self.outcomes.newest()
    }

    /// Begins the newest plan in the rings of `frame`, for a number of views that are drawn at
    /// once.
    pub(crate) fn begin(
        &mut self,
        frame: &mut Frame<'_>,
        leaves: &LeafTable,
        views: u32,
    ) -> Result<(), Error> {
        leaves.check_uploaded(frame)?;
        let recording = Some(frame.commands().recording());
        if self.begun_in == recording {
            return Err(Error::NoPlan);
        }
        self.begun_in = recording;
        self.planned = None;
        self.follow_draws(leaves);
        let Self { rings, layout, plan, generation, .. } = self;
        rings.queries.set_views(views)?;
        rings.queries.set_counting(match plan.sample_threshold {
            0 => Counting::Some,
            _ => Counting::Samples,
        });
        rings.queries.begin(frame, &layout.query_tags)?;
        rings.flags.begin(frame, layout.flag_tags.iter().copied())?;
        rings.computed.begin(frame, layout.compute_tags.iter().copied())?;
        let tested = layout.refined();
        let draws = leaves.copied_draws();
        rings.leaf_draws.begin(frame, (plan.frame, *generation), tested, &draws)?;
        Ok(())
    }

    /// Lists the draws of the newest plan. Its visible draws are in `visible`. Returns the buffers
    /// for the passes that write the revealed draws, if there are any. Counts are used where they
    /// can be trusted.
    pub(crate) fn list(
        &mut self,
        frame: &mut Frame<'_>,
        leaves: &LeafTable,
        visible: BufferSlice,
        quirks: &DriverQuirks,
    ) -> Result<Option<ListDrawsIo>, Error> {
        self.lists.write(frame, &self.device, &self.layout, leaves, visible, quirks)
    }

    /// Lists the draws that the tests of the newest plan may reveal, step by step. Returns the
    /// buffers for the passes that write the lists, if there are any.
    pub(crate) fn compact(
        &mut self,
        frame: &mut Frame<'_>,
        leaves: &LeafTable,
    ) -> Result<Option<ListDrawsIo>, Error> {
        self.lists.compact(frame, &self.device, &self.layout, leaves)
    }

    /// Returns a step of the newest frame whose draws are compacted, with its lists.
    pub(crate) fn listed_step(&self, step: usize) -> Option<(&ListedStep, &[DrawList])> {
        self.lists.step(step)
    }

    /// Returns the visible draws of the newest frame, a list per bucket, if they were
    /// [listed](crate::FrameScope::list).
    pub fn visible_lists(&self) -> &[DrawList] {
        self.lists.visible()
    }

    /// Returns the draws that the tests of the newest frame reveal, a list per bucket, if they were
    /// [listed](crate::FrameScope::list).
    pub fn revealed_lists(&self) -> &[DrawList] {
        self.lists.revealed()
    }

    /// Updates the rings' copies of draws after changes of the scene.
    fn follow_draws(&mut self, leaves: &LeafTable) {
        let changes = &leaves.changes;
        match changes.since(self.seen_changes) {
            Some(cells) => cells.for_each(|first| {
                self.rings.leaf_draws.changed(DrawRange { first, count: 1 });
            }),
            None => self.rings.leaf_draws.all_changed(),
        }
        self.seen_changes = changes.count();
    }

    /// Reads every available result and updates the history. Never waits.
    pub fn collect(&mut self, completed: Tick, scene: &CulledScene) {
        let CulledScene { hierarchy, leaves, .. } = scene;
        self.read(completed, hierarchy, leaves);
        let Self { culler, method_states, reader, newest: kept, outcomes, sent, .. } = self;
        for result in reader.results().iter().filter(|result| result.answer.samples > 0) {
            outcomes.add(result);
        }
        let answers = reader.results().iter().map(|result| result.answer);
        let mut newest = answers.clone().map(|answer| answer.tag.frame).max();
        if let Some(newest) = newest {
            kept.clear();
            kept.extend(answers.clone().filter(|answer| answer.tag.frame == newest));
        }
        for state in method_states {
            newest = newest.max(state.collect(completed, outcomes));
        }
        while let Some(outcome) = outcomes.settle(newest) {
            sent.drew(&outcome);
        }
        culler.ingest(hierarchy, answers);
    }

    /// Reads the results of frames that are over from mapped memory.
    fn read(&mut self, completed: Tick, hierarchy: &Hierarchy, leaves: &LeafTable) {
        let Self { rings: Rings { queries, flags, computed, leaf_draws }, reader, .. } = self;
        reader.clear();
        queries.collect(completed, |test, samples| reader.read_query(&test, samples));
        flags.collect(completed, |tests, results| reader.read_flags(tests, results));
        computed.collect(completed, |tests, results| reader.read_computed(tests, results));
        leaf_draws.collect(completed, |(frame, generation), listed| {
            let list = match listed {
                EnabledLeaves::These(leaves) => LeafList::These(leaves),
                EnabledLeaves::TooMany(_) => LeafList::TooMany,
            };
            reader.read_leaves(hierarchy, frame, generation, list, |range| leaves.count(range));
        });
        reader.finish();
    }

    /// Returns all answers about the newest frame that has answers.
    pub fn newest_answers(&self) -> &[Answer] {
        &self.newest
    }

    /// Returns the age in frames of each answer that the newest plan used.
    pub fn answer_ages(&self) -> impl Iterator<Item = u64> {
        let now = self.plan.frame.0;
        let frames = self.reader.results().iter().map(|result| result.answer.tag.frame.0);
        frames.map(move |frame| now.saturating_sub(frame))
    }

    /// Takes the state of a method for this view, if one was
    /// [stored](OcclusionState::put_method_state).
    pub fn take_method_state<S: MethodState>(&mut self) -> Option<Box<S>> {
        let place = self.method_states.iter().position(|state| {
            let state: &dyn Any = &**state;
            state.is::<S>()
        })?;
        let state: Box<dyn Any> = self.method_states.swap_remove(place);
        state.downcast().ok()
    }

    /// Stores the state of a method for this view, until the number of frames in flight changes.
    pub fn put_method_state(&mut self, state: Box<dyn MethodState>) {
        self.method_states.push(state);
    }

    /// Notes the number of samples below the threshold in the newest frame, for a method without
    /// plans.
    pub fn note_samples_below_threshold(&mut self, samples: u64) {
        self.samples_below_threshold = samples;
    }

    /// Returns the corrections that this view's cost model makes; `None` without a cost model.
    pub fn corrections(&self) -> Option<Corrections> {
        self.culler.learned_costs().map(LearnedCosts::corrections)
    }

    /// Returns true if the view has a cost model that learns from the times of frames.
    pub fn has_cost_model(&self) -> bool {
        self.culler.learned_costs().is_some()
    }

    /// Passes the time of a frame to the cost model, with the contents of all views in it.
    pub(crate) fn took(&mut self, time: &FrameTime, contents: &FrameContents) {
        if let Some(costs) = self.culler.cost_model_mut() {
            costs.observe(time.gpu_ms * 1.0e6, contents);
        }
    }

    /// Notes that the newest frame was submitted. `timed_views` is the number of views that the
    /// frame showed if it is timed.
    pub fn submitted(&mut self, tick: Tick, scene: &CulledScene, timed_views: Option<usize>) {
        if let Some(views) = timed_views {
            self.sent.submitted(tick, &self.plan, views);
        }
        self.rings.submitted(tick);
        let taken = self.plan.draws.iter().copied();
        let taken = taken.chain(self.plan.queried_draws.iter().map(|(leaf, _)| *leaf));
        let mut outcome = FrameStats {
            frame: self.plan.frame,
            draws: 0,
            triangles: 0,
            revealed: 0,
            samples_below_threshold: std::mem::take(&mut self.samples_below_threshold),
        };
        for first in taken {
            let count = scene.leaves.count(LeafRange { first, count: 1 });
            outcome.draws += count.draws;
            outcome.triangles += count.triangles;
        }
        let mut is_known = self.layout.is_empty();
        for state in &mut self.method_states {
            is_known &= !state.submitted(tick, outcome.frame);
        }
        if let Some(outcome) = self.outcomes.push(outcome, is_known) {
            self.sent.drew(&outcome);
        }
    }
}
