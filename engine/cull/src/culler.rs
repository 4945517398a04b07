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
use crate::plan::candidates::Scratch;
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
/// It keeps the history: use one culler for each eye, light or probe. It follows rebuilds of its
/// hierarchy by itself. Its history never changes the image, only its cost.
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
    /// Samples of a query that count as none.
    sample_threshold: u32,
    /// The configuration as tuned by the cost model.
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
    /// The steps by which the tests of the last frame were coarser than wished.
    coarseness: u32,
}

impl Culler {
    /// Creates a culler that knows nothing yet and has nothing but queries.
    #[must_use]
    pub fn new(config: CullConfig) -> Self {
        Self::with_testers(config, VisibilityTestSupport::default())
    }

    /// Creates a culler without history, for a device that can do more than queries, or less. In
    /// place of a strategy whose tester is not there it plans
    /// [another](VisibilityTestSupport::strategy).
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

    /// Takes the memory for the history of a hierarchy's nodes, instead of in the first plan.
    ///
    /// # Errors
    /// [`HierarchyError::NoMemory`].
    pub fn reserve(&mut self, hierarchy: &Hierarchy) -> Result<(), HierarchyError> {
        let count = hierarchy.leaf_objects().len();
        let reserved = self.history.reserve(hierarchy.node_count());
        reserved.map_err(|size_bytes| HierarchyError::NoMemory { count, size_bytes })
    }

    /// Takes a test with no more than `samples` samples as hidden from now on (GPU Gems 2, 6.5.4):
    /// the executor of the plans leaves the leaves of such tests out. Above 0 the image is not
    /// exact, a query must count, and all tests are queries: other testers count nothing. Each
    /// [`Culler::plan`] passes it on ([`FramePlan::sample_threshold`]); tests on their way keep
    /// theirs. [`Culler::plan_next_frame`] goes by a single sample.
    pub fn set_sample_threshold(&mut self, samples: u32) {
        self.sample_threshold = samples;
    }

    /// Returns the most samples of a test that still counts as hidden.
    #[must_use]
    pub fn sample_threshold(&self) -> u32 {
        self.sample_threshold
    }

    /// Leaves out tests that cost more than they save, from now on. Without costs everything is
    /// tested that may be hidden.
    ///
    /// # Errors
    /// [`BadCost`] for impossible costs; the culler is then as it was.
    pub fn set_costs(&mut self, table: CostTable, scene: SceneCosts) -> Result<(), BadCost> {
        self.learned_costs = Some(LearnedCosts::new(table, scene)?);
        Ok(())
    }

    /// Returns the cost model that weighs costs against savings, if there is one.
    #[must_use]
    pub fn learned_costs(&self) -> Option<&LearnedCosts> {
        self.learned_costs.as_ref()
    }

    /// Returns the same, to pass it the times of frames ([`LearnedCosts::observe`]).
    pub fn cost_model_mut(&mut self) -> Option<&mut LearnedCosts> {
        self.learned_costs.as_mut()
    }

    /// Returns the constants in use.
    #[must_use]
    pub fn config(&self) -> &CullConfig {
        &self.config
    }

    /// Returns the frame planned last; 0 before the first.
    #[must_use]
    pub fn frame(&self) -> FrameId {
        self.frame
    }

    /// Returns the state of a node; unknown for a foreign id.
    #[must_use]
    pub fn state(&self, node: NodeId) -> NodeState {
        self.history.record(node.0).state
    }

    /// Forgets everything; the next frame starts like the first, and answers to earlier ones are
    /// ignored. To be called after a change that makes the past worthless, such as a new scene.
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

    /// Takes answers to queries of earlier plans: in any order, late, twice, or never. Answers that
    /// fit nothing (another generation of the node, a frame to come, an older answer than the last)
    /// are ignored.
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

    /// Plans the next frame of a view, or of several that are drawn in one pass, into `plan`, whose
    /// vectors are reused. Never asks for more than `query_budget` queries, and draws the leaves
    /// that are left without one.
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
            is_turning: self.turned.is_within(now, config.turning_frames),
            // Begins with the coarseness of last time: each attempt is a walk.
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
            let [saving_ns, break_ns] = self.scratch.prospect_ns;
            learned_costs.note_prospect(saving_ns, break_ns, visible);
        }
    }

    /// Plans a frame of next-frame queries (GPU Gems, 29.4) into `plan`: what was visible at its
    /// last test is drawn, every object is tested, and no draw depends on the tests of the frame.
    /// Not exact: an object that comes into view is missing until its result is read back.
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

    /// Plans the next frame from the outcome: draws `leaves` in their order and tests nothing
    /// ([`Strategy::needs_still_scene`]; [`Culler::plan`] cannot know them and falls back to
    /// frustum culling).
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

    /// Returns the history of a node; an empty one for a foreign id.
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

    /// Explains the decision of `plan`, made for `views` over the hierarchy as it is now, about an
    /// object. `None` if there is no such object.
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
        // Two years at 60 Hz are over: stamps are 32 bits, so the past starts again.
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
            if sine > self.config.turning_sine || before.dot(view.rays.forward) < 0.0 {
                self.turned = now;
            }
        }
    }
}

/// Returns the tester of proxies under a strategy whose tester is there.
fn tester(strategy: Strategy, testers: VisibilityTestSupport) -> VisibilityTest {
    let usual = if testers.flags { VisibilityTest::Flag } else { VisibilityTest::Query };
    strategy.tester().unwrap_or(usual)
}
