//! One view's culler: takes answers, keeps the history, makes plans.

use glam::Vec3;

use crate::cost::learned_costs::LearnedCosts;
use crate::cost::table::{BadCost, CostTable, SceneCosts};
use crate::geom::multi_view::MultiView;
use crate::geom::view::CullView;
use crate::hierarchy::{Hierarchy, HierarchyError};
use crate::history::answers;
use crate::history::record::{FrameStamp, NodeState};
use crate::history::records::History;
use crate::ids::{FrameId, LeafIndex, NodeId, ObjectId};
use crate::plan::candidates::{Prospect, Scratch};
use crate::plan::config::CullConfig;
use crate::plan::cost_filter::CostFilter;
use crate::plan::explain::{self, LeafExplanation, NodeHistory};
use crate::plan::frame_plan::{
    Answer, DrawPhases, FramePlan, PlanStats, VisibilityTest, VisibilityTestSupport,
};
use crate::plan::fronts::Fronts;
use crate::plan::next_frame::NextFrame;
use crate::plan::phases;
use crate::plan::plan_writer::PlanWriter;
use crate::plan::rounds::{self, Grouping, Slabs};
use crate::plan::strategy::Strategy;
use crate::plan::traverse::{Knowledge, Walk};
use crate::plan::{budget, occluders, shared_proxies};
use crate::rng::SplitMix64;

/// The decisions for one view of one hierarchy: what to draw and what to test.
///
/// A culler keeps the history of its view: use one culler for each eye, light or probe. It adapts
/// to rebuilds of its hierarchy automatically. Its history affects only the cost, never the image.
#[derive(Debug)]
pub struct Culler {
    config: CullConfig,
    testers: VisibilityTestSupport,
    history: History,
    next_frame: NextFrame,
    scratch: Scratch,
    grouping: Grouping,
    fronts: Fronts,
    learned_costs: Option<LearnedCosts>,
    /// The most samples of a query that still count as hidden.
    sample_threshold: u32,
    /// The configuration after tuning by the cost model.
    tuned: CullConfig,
    /// Leaves that the last frame took as visible.
    visible: u32,
    rng: SplitMix64,
    frame: FrameId,
    /// The frame that the history's stamps count from.
    epoch: u64,
    /// The direction of sight in the last planned frame.
    forward: Option<Vec3>,
    turned: FrameStamp,
    /// The number of times that the last frame raised the allowed size of tested nodes.
    coarseness: u32,
}

impl Culler {
    /// Creates a culler without history, for a device that tests with occlusion queries only.
    #[must_use]
    pub fn new(config: CullConfig) -> Self {
        Self::with_testers(config, VisibilityTestSupport::default())
    }

    /// Creates a culler without history, for a device with the given testers. Where a strategy
    /// needs a tester that the device does not have, the culler plans [another
    /// strategy](VisibilityTestSupport::strategy).
    #[must_use]
    pub fn with_testers(config: CullConfig, testers: VisibilityTestSupport) -> Self {
        Self {
            config,
            testers,
            history: History::default(),
            next_frame: NextFrame::default(),
            scratch: Scratch::default(),
            grouping: Grouping::default(),
            fronts: Fronts::default(),
            learned_costs: None,
            sample_threshold: 0,
            tuned: config,
            visible: 0,
            rng: SplitMix64::new(config.seed),
            frame: FrameId(0),
            epoch: 0,
            forward: None,
            turned: FrameStamp::NEVER,
            coarseness: 0,
        }
    }

    /// Reserves the memory for the history of a hierarchy's nodes, so that the first plan need not.
    ///
    /// # Errors
    /// [`HierarchyError::NoMemory`].
    pub fn reserve(&mut self, hierarchy: &Hierarchy) -> Result<(), HierarchyError> {
        let count = hierarchy.leaf_objects().len();
        let reserved = self.history.reserve(hierarchy.node_count());
        reserved.map_err(|size_bytes| HierarchyError::NoMemory { count, size_bytes })
    }

    /// Sets the most samples of a test that still count as hidden (GPU Gems 2, 6.5.4): the executor
    /// of a plan does not draw the leaves of such tests. Above 0 the image is not exact, queries
    /// must count samples, and all tests are queries, because other testers do not count. Each
    /// [`Culler::plan`] copies the threshold to its plan ([`FramePlan::sample_threshold`]); tests
    /// of earlier plans keep theirs. [`Culler::plan_next_frame`] ignores the threshold: a single
    /// sample makes an object visible.
    pub fn set_sample_threshold(&mut self, samples: u32) {
        self.sample_threshold = samples;
    }

    /// Returns the most samples of a test that still counts as hidden.
    #[must_use]
    pub fn sample_threshold(&self) -> u32 {
        self.sample_threshold
    }

    /// Enables the cost model: from now on, tests that cost more than they save are left out.
    /// Without it, every node that may be hidden is tested.
    ///
    /// # Errors
    /// [`BadCost`] for impossible costs; the culler then stays unchanged.
    pub fn set_costs(&mut self, table: CostTable, scene: SceneCosts) -> Result<(), BadCost> {
        self.learned_costs = Some(LearnedCosts::new(table, scene)?);
        Ok(())
    }

    /// Returns the cost model that weighs costs against savings, if there is one.
    #[must_use]
    pub fn learned_costs(&self) -> Option<&LearnedCosts> {
        self.learned_costs.as_ref()
    }

    /// Returns the cost model mutably, to pass it the times of frames ([`LearnedCosts::observe`]).
    pub fn cost_model_mut(&mut self) -> Option<&mut LearnedCosts> {
        self.learned_costs.as_mut()
    }

    /// Returns the constants in use.
    #[must_use]
    pub fn config(&self) -> &CullConfig {
        &self.config
    }

    /// Returns the number of the frame planned last; 0 before the first.
    #[must_use]
    pub fn frame(&self) -> FrameId {
        self.frame
    }

    /// Returns the state of a node; [`NodeState::Unknown`] for a foreign id.
    #[must_use]
    pub fn state(&self, node: NodeId) -> NodeState {
        self.history.record(node.0).state
    }

    /// Clears the history: the next frame starts like the first, and answers to earlier frames are
    /// ignored. Call this after a change that makes the history worthless, such as a new scene.
    pub fn reset(&mut self) {
        self.history.reset();
        self.next_frame.reset();
        self.epoch = self.frame.0;
        self.turned = FrameStamp::NEVER;
        self.forward = None;
        self.coarseness = 0;
        if let Some(learned_costs) = &mut self.learned_costs {
            learned_costs.reset();
        }
    }

    /// Takes answers to queries of earlier plans: in any order, late, twice, or never. Ignores an
    /// answer about another generation of the node, an answer to a future frame, and an answer
    /// older than the node's last one.
    pub fn ingest(&mut self, hierarchy: &Hierarchy, answers: impl IntoIterator<Item = Answer>) {
        self.history.adopt(hierarchy);
        let now = self.stamp(self.frame).unwrap_or(FrameStamp::NEVER);
        for Answer { tag, samples } in answers {
            if !hierarchy.is_same_since(tag.node, tag.generation) || tag.frame > self.frame {
                continue;
            }
            let Some(tested) = self.stamp(tag.frame) else {
                continue;
            };
            self.next_frame.take(hierarchy, &tag, samples);
            let samples = samples.saturating_sub(tag.sample_threshold);
            let record = self.history.record(tag.node.0);
            if let Some(learned_costs) =
                self.learned_costs.as_mut().filter(|_| record.answered < tested)
            {
                learned_costs.learn(tag.kind, record.state, record.retest_reason, samples > 0);
                self.history.answered_assumed(tag.node.0);
            }
            answers::Ingest {
                history: &mut self.history,
                topology: &hierarchy.topology,
                config: &self.tuned,
                rng: &mut self.rng,
                now,
                tested,
            }
            .apply(tag.node.0, tag.kind, samples);
        }
    }

    /// Plans the next frame of a view, or of several views that are drawn in one pass, into `plan`.
    /// Reuses the vectors of `plan`. The plan has at most `query_budget` queries; leaves that
    /// cannot be tested within this budget are drawn.
    pub fn plan<'v>(
        &mut self,
        hierarchy: &Hierarchy,
        strategy: Strategy,
        views: impl Into<MultiView<'v>>,
        query_budget: usize,
        plan: &mut FramePlan,
    ) {
        self.plan_views(hierarchy, strategy, views.into(), query_budget, plan);
    }

    fn plan_views(
        &mut self,
        hierarchy: &Hierarchy,
        strategy: Strategy,
        views: MultiView<'_>,
        query_budget: usize,
        plan: &mut FramePlan,
    ) {
        let now = self.begin(hierarchy, plan);
        self.watch(views.first(), now);
        plan.sample_threshold = self.sample_threshold;
        let testers = self.testers.counting(self.sample_threshold);
        let strategy = testers.strategy(strategy);
        let mut tester = tester(strategy, testers);
        let config = self.tune(strategy, &mut plan.stats);
        let mut costs = CostFilter::new(self.learned_costs.as_ref(), strategy, tester, testers);
        let scratch = &mut self.scratch;
        let has_leaf_tests = testers.leaf_tests;
        let mut walk = Walk {
            hierarchy,
            views,
            config: &config,
            knowledge: Knowledge::of(&self.history, strategy),
            now,
            can_flag: tester != VisibilityTest::Query,
            has_leaf_tests,
            is_turning: self.turned.is_within(now, config.tuning.turning_frames),
            // Begins one step finer than the last frame: each further attempt is another walk.
            coarseness: self.coarseness.saturating_sub(1),
        };

        // The stages, each in the file of its name.
        walk.traverse(scratch, query_budget, &mut plan.stats);
        self.coarseness = walk.coarseness;
        if let Some(costs) = &mut costs {
            tester = costs.drop_unpaid(scratch, &walk, &mut plan.stats).unwrap_or(tester);
        }
        let mut slabs = Slabs::Equal;
        if !views.is_of_shadows() && occluders::is_cut(scratch, &config) {
            occluders::draw_occluders(scratch, &walk, &mut plan.stats);
            slabs = Slabs::Doubling;
        }
        budget::fit(scratch, &walk, query_budget, &mut plan.stats);
        if testers.draw_phases == DrawPhases::Two || !testers.queries {
            phases::test_boxes_of_retests(scratch, &walk, &mut plan.stats);
        }
        let history = &mut self.history;
        let rng = &mut self.rng;
        let costs = costs.as_ref();
        PlanWriter {
            hierarchy,
            views,
            config: &config,
            history,
            rng,
            now,
            has_leaf_tests,
            tester,
            costs,
        }
        .write(scratch, plan);
        if has_leaf_tests {
            shared_proxies::share_proxies(plan, &scratch.tests, views, &mut self.fronts);
        }
        let device_costs = costs.map(|cost| cost.round_costs(tester, scratch.revealed_ns));
        rounds::schedule(plan, tester, testers.draw_phases, slabs, device_costs, &config);
        if let Some(costs) = costs {
            plan.stats.rounds_by_compute = costs.hand_to_compute(views, plan);
        }
        rounds::group_by_tester(plan, &mut self.grouping);
        self.note_prospect(strategy, plan.stats.visible);
    }

    /// Begins the next frame and its plan.
    fn begin(&mut self, hierarchy: &Hierarchy, plan: &mut FramePlan) -> FrameStamp {
        let now = self.advance();
        self.history.adopt(hierarchy);
        plan.clear(self.frame);
        now
    }

    /// Notes the expected saving of this frame for the next.
    fn note_prospect(&mut self, strategy: Strategy, visible: u32) {
        self.visible = visible;
        if let Some(learned_costs) =
            self.learned_costs.as_mut().filter(|_| strategy.uses_cost_model())
        {
            let Prospect { saving_ns, break_ns } = self.scratch.prospect;
            learned_costs.note_prospect(saving_ns, break_ns, visible);
        }
    }

    /// Plans a frame of next-frame queries (GPU Gems, 29.4) into `plan`: every object is tested, an
    /// object is drawn if it was visible at its last test, and no draw depends on the tests of this
    /// frame. The image is not exact: an object that comes into view is missing until its result is
    /// read back.
    pub fn plan_next_frame(
        &mut self,
        hierarchy: &Hierarchy,
        view: &CullView,
        plan: &mut FramePlan,
    ) {
        let now = self.begin(hierarchy, plan);
        self.watch(view, now);
        self.next_frame.plan(hierarchy, view, plan);
    }

    /// Plans the next frame of a strategy that [needs a still scene](Strategy::needs_still_scene):
    /// draws `leaves`, which were found visible beforehand, in their order, and tests nothing.
    /// [`Culler::plan`] does not have these leaves and falls back to frustum culling for such a
    /// strategy.
    pub fn plan_known(
        &mut self,
        hierarchy: &Hierarchy,
        leaves: &[LeafIndex],
        plan: &mut FramePlan,
    ) {
        self.begin(hierarchy, plan);
        plan.draws.extend_from_slice(leaves);
        plan.stats.visible = leaves.len() as u32;
    }

    /// Returns the history of a node; an empty history for a foreign id.
    #[must_use]
    pub(crate) fn node_history(&self, node: NodeId) -> NodeHistory {
        let record = self.history.record(node.0);
        let frame = |stamp: FrameStamp| {
            Some(FrameId(self.epoch + stamp.frames()?)).filter(|frame| frame.0 > 0)
        };
        NodeHistory {
            state: record.state,
            since: frame(record.since),
            answered: frame(record.answered),
            next_test: frame(record.due).filter(|_| record.state == NodeState::Visible),
        }
    }

    /// Explains the decision of `plan` about an object. The plan must be made for `views` over the
    /// hierarchy in its present state. Returns `None` if there is no such object.
    #[must_use]
    pub fn explain<'v>(
        &self,
        hierarchy: &Hierarchy,
        views: impl Into<MultiView<'v>>,
        plan: &FramePlan,
        object: ObjectId,
    ) -> Option<LeafExplanation> {
        explain::explain(hierarchy, views.into(), plan, object, |node| self.node_history(node))
    }

    /// Returns the constants for the next frame.
    fn tune(&mut self, strategy: Strategy, stats: &mut PlanStats) -> CullConfig {
        self.tuned = self.config;
        if let Some(learned_costs) =
            self.learned_costs.as_mut().filter(|_| strategy.uses_cost_model())
        {
            learned_costs.begin_frame(self.visible);
            self.tuned = learned_costs.tuned(&self.config);
            stats.retest_interval_frames = self.tuned.retest_max;
        }
        self.tuned
    }

    /// Begins the next frame.
    fn advance(&mut self) -> FrameStamp {
        self.frame.0 = self.frame.0.saturating_add(1);
        if let Some(now) = self.stamp(self.frame) {
            return now;
        }
        // Stamps have 32 bits, enough for two years at 60 Hz. After that the history starts again.
        self.reset();
        self.epoch = self.frame.0.saturating_sub(1);
        FrameStamp::FIRST
    }

    /// Returns the stamp of a frame after the epoch.
    fn stamp(&self, frame: FrameId) -> Option<FrameStamp> {
        frame.0.checked_sub(self.epoch).and_then(FrameStamp::new)
    }

    /// Notes if the view turns.
    fn watch(&mut self, view: &CullView, now: FrameStamp) {
        if let Some(before) = self.forward.replace(view.rays.forward) {
            let sine = before.cross(view.rays.forward).length();
            if sine > self.config.tuning.turning_sine || before.dot(view.rays.forward) < 0.0 {
                self.turned = now;
            }
        }
    }
}

/// Returns the tester of proxies under a strategy that the device supports.
fn tester(strategy: Strategy, testers: VisibilityTestSupport) -> VisibilityTest {
    let usual = if testers.flags { VisibilityTest::Flag } else { VisibilityTest::Query };
    strategy.tester().unwrap_or(usual)
}
