//! The cost model: decides which tests are worth their cost.
//!
//! It counts the results of tests and compares the costs of tests with their savings. It reads no
//! clock: the caller passes the times of frames, which correct the costs. An object that is not
//! tested is drawn, so no image depends on the model. Evidence fades, so that old decisions are
//! tried again. Leaves drawn without a test are still tested on their own draw now and then. So the
//! model notices within a bounded number of frames when tests pay off again.

use crate::cost::contents::FrameContents;
use crate::cost::corrections::{Corrections, Learner};
use crate::cost::decaying_rate::{DecayingRate, HideRate};
use crate::cost::predication_costs::SkippedWork;
use crate::cost::table::{BadCost, CostTable, SceneCosts};
use crate::history::record::{NodeState, RetestReason};
use crate::plan::config::{CullConfig, CullTuning};
use crate::plan::frame_plan::{QueryKind, VisibilityTest, VisibilityTestSupport};
use crate::plan::strategy::Strategy;

/// The least interval between own-draw tests that stands for no such tests.
const NEVER_FRAMES: u32 = 1 << 20;

/// The interval in which a leaf is tested even if leaves hardly ever become hidden ...
const CALM_RETEST_FRAMES: f32 = 256.0;
/// ... unless all these tests together would cost more than this share of the draws.
const CALM_SHARE: f32 = 0.01;

/// The most frames by which [`CALM_SHARE`] may delay noticing a change in the scene.
const MOST_GATE_FRAMES: u32 = 32;

/// The number of frames without a worthwhile test after which it is of little use to learn what
/// tests could hide.
const IDLE_AFTER_FRAMES: u32 = 8;

/// The number of frames for which the knowledge that something is hidden is useful, before a test
/// of its own draw would have found it.
const HORIZON_FRAMES: f32 = 8.0;

/// The share of the box's pixels that an object covers: the pixels of a hidden object fail the
/// depth test like the pixels of its box.
const LEAF_FILL: f32 = 0.5;

/// The prior of unknown nodes: hidden with a probability of one half, until some were tested.
const UNKNOWN_PRIOR: DecayingRate = DecayingRate { yes: 2.0, no: 2.0 };
/// The prior of drawn leaves: visible, unless enough tests of own draws found otherwise.
const DRAWN_PRIOR: DecayingRate = DecayingRate { yes: 0.0, no: 8.0 };
/// The prior of hidden nodes: nine of ten stay hidden.
const KNOWN_PRIOR: DecayingRate = DecayingRate { yes: 7.2, no: 0.8 };

/// The pixels that the tests of a frame cover, relative to the pixels of the image: the boxes of a
/// city at street level.
const COVERED: f32 = 2.0;

/// A possible test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TestEstimate {
    /// The number of leaves that are drawn without the test.
    pub(crate) leaves: u32,
    /// The number of pixels that the proxy covers.
    pub(crate) pixels: f32,
    /// True if nothing is known of the node.
    pub(crate) is_unknown: bool,
}

/// The saving and the cost of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CostBenefit {
    /// The expected saving.
    pub(crate) saving_ns: f32,
    /// The part of the saving that occurs in this frame.
    pub(crate) saving_now_ns: f32,
    /// The cost of the test itself, in nanoseconds.
    pub(crate) cost_ns: f32,
    /// The expected time of the draws that the test reveals, over the frames for which the leaves
    /// then count as visible.
    pub(crate) revealed_ns: f32,
}

impl CostBenefit {
    /// Returns true if the test pays.
    #[must_use]
    pub(crate) fn pays(self) -> bool {
        self.saving_ns >= self.cost_ns
    }
}

/// The costs for one view, and the statistics of the results of its tests.
#[derive(Clone, Debug)]
pub struct LearnedCosts {
    table: CostTable,
    /// The table with corrected costs of tests.
    costs: CostTable,
    leaf_ns: f32,
    unknown: DecayingRate,
    known: DecayingRate,
    /// The rate at which drawn leaves turn out hidden.
    drawn: DecayingRate,
    hides: HideRate,
    learner: Learner,
    /// The number of frames since tests could last pay for the breaks of rendering that they need.
    idle_frames: u32,
}

impl LearnedCosts {
    /// Creates a cost model without results.
    ///
    /// # Errors
    /// [`BadCost`] if a value of `table` or `scene` is impossible.
    pub fn new(table: CostTable, scene: SceneCosts) -> Result<Self, BadCost> {
        let table = table.checked()?;
        let triangles = scene.triangles_per_leaf;
        if !triangles.is_finite() || triangles < 0.0 {
            return Err(BadCost { name: "triangles_per_leaf", value: triangles });
        }
        Ok(Self {
            table,
            costs: table,
            // The product of finite costs may be infinite.
            leaf_ns: table.leaf_ns(triangles).min(f32::MAX),
            unknown: DecayingRate::default(),
            known: DecayingRate::default(),
            drawn: DecayingRate::default(),
            hides: HideRate::default(),
            learner: Learner::default(),
            idle_frames: 0,
        })
    }

    /// Returns the costs as they were passed in.
    #[must_use]
    pub fn table(&self) -> CostTable {
        self.table
    }

    /// Returns the corrections learned from the times of frames.
    #[must_use]
    pub fn corrections(&self) -> Corrections {
        self.learner.corrections()
    }

    /// Returns the probability that an unknown node turns out hidden.
    #[must_use]
    pub(crate) fn unknown_hidden(&self) -> f32 {
        self.unknown.probability(UNKNOWN_PRIOR)
    }

    /// Returns the probability that a hidden node is still hidden.
    #[must_use]
    pub(crate) fn still_hidden(&self) -> f32 {
        self.known.probability(KNOWN_PRIOR)
    }

    /// Resets the results of tests, but not the costs.
    pub fn reset(&mut self) {
        self.unknown = DecayingRate::default();
        self.known = DecayingRate::default();
        self.drawn = DecayingRate::default();
        self.hides = HideRate::default();
        self.idle_frames = 0;
    }

    /// Begins a frame. The frame before took `visible` leaves as visible.
    pub(crate) fn begin_frame(&mut self, visible: u32) {
        self.unknown.fade();
        self.known.fade();
        self.drawn.fade();
        self.hides.fade(visible);
        self.idle_frames = self.idle_frames.saturating_add(1);
    }

    /// Notes the saving of the tests of this frame and the cost of their breaks. The frame takes
    /// `visible` leaves as visible, some of which have become hidden without a test that found it.
    pub(crate) fn note_prospect(&mut self, saving_ns: f32, break_ns: f32, visible: u32) {
        let hidden = self.drawn.probability(DRAWN_PRIOR) * visible as f32;
        let prospect_ns = saving_ns + hidden * self.leaf_ns;
        if prospect_ns > 0.0 && prospect_ns >= break_ns {
            self.idle_frames = 0;
        }
    }

    /// Returns true if tests have not paid off for a while. Hidden leaves are then drawn anyway, so
    /// finding a hidden leaf saves nothing until there are many.
    fn is_idle(&self) -> bool {
        self.idle_frames > IDLE_AFTER_FRAMES
    }

    /// Learns from the result of a test of a node in the given state.
    pub(crate) fn learn(
        &mut self,
        kind: QueryKind,
        state: NodeState,
        retest_reason: RetestReason,
        showed: bool,
    ) {
        match (kind, state) {
            (QueryKind::Proxy | QueryKind::PerLeaf, NodeState::Hidden) => self.known.note(!showed),
            (QueryKind::Proxy | QueryKind::PerLeaf, _) => self.unknown.note(!showed),
            (QueryKind::VisibleDrawQuery | QueryKind::VisibleBoxQuery, _)
                if retest_reason == RetestReason::Edge => {}
            (QueryKind::VisibleDrawQuery, NodeState::Hidden) => self.known.note(!showed),
            (QueryKind::VisibleDrawQuery | QueryKind::VisibleBoxQuery, NodeState::Visible) => {
                if retest_reason == RetestReason::Assumed {
                    self.unknown.note(!showed);
                }
                if kind == QueryKind::VisibleDrawQuery {
                    self.drawn.note(!showed);
                }
                if !showed {
                    self.hides.note();
                }
            }
            _ => {}
        }
    }

    /// Returns the number of frames after which a calm leaf's own draw is tested again. With an
    /// interval of T frames, a leaf pays the cost of a test every T frames, and a leaf that became
    /// hidden is drawn in vain for T / 2 frames on average. The sum is least at T = sqrt(2 * test
    /// cost / (rate * draw cost)).
    pub(crate) fn retest_frames(&self, config: &CullConfig) -> u32 {
        let least = config.retest_max.max(1) as f32;
        // The tested draw becomes an indirect call of its own, and so do the draws after it.
        let CostTable { query_ns, call_ns, .. } = self.costs;
        let item_cost = (f64::from(query_ns) + 2.0 * f64::from(call_ns)) / f64::from(self.leaf_ns);
        if item_cost.is_nan() {
            return config.retest_max;
        }
        // Without results, the rate is chosen so that the interval of the configuration is best.
        let expected = 2.0 * item_cost / f64::from(least * least);
        let best = (2.0 * item_cost / self.hides.per_leaf_and_frame(expected)).sqrt();
        let calm = f64::from(CALM_RETEST_FRAMES).max(item_cost / f64::from(CALM_SHARE));
        let wished = if best.is_nan() { f64::from(least) } else { best };
        // While the results are not used, tests are rare enough to cost next to nothing.
        let frames =
            if self.is_idle() { wished.max(item_cost / f64::from(CALM_SHARE)) } else { wished };
        // If even the calm tests are too rare to matter, all tests are too expensive.
        let frames = if calm >= f64::from(NEVER_FRAMES) { calm } else { frames.min(calm) };
        frames.max(f64::from(least)).min(f64::from(u32::MAX / 4)) as u32
    }

    /// Returns `config` with the constants that are best at present.
    pub(crate) fn tuned(&self, config: &CullConfig) -> CullConfig {
        let frames = self.retest_frames(config);
        // If next to nothing becomes hidden, tests of boxes alone are not worth a break of
        // rendering.
        let is_calm = self.is_idle() || frames > config.retest_max.saturating_mul(2);
        let usual = config.tuning;
        let visible_box_angle = if is_calm { 0.0 } else { usual.visible_box_angle };
        let retest_first = if is_calm { frames / 4 } else { usual.retest_first };
        let retest_gate = if is_calm { self.gate_frames() } else { usual.retest_gate };
        let retest_spread = frames;
        let tuning =
            CullTuning { retest_first, retest_spread, retest_gate, visible_box_angle, ..usual };
        CullConfig { retest_max: frames, tuning, ..*config }
    }

    /// Returns the interval between frames with tests in a calm view. It is chosen so that waiting
    /// for results costs at most [`CALM_SHARE`] of a frame.
    fn gate_frames(&self) -> u32 {
        ((self.costs.break_wait_share / CALM_SHARE) as u32).clamp(1, MOST_GATE_FRAMES)
    }

    #[must_use]
    pub(crate) fn weigh(&self, estimate: &TestEstimate, tester: VisibilityTest) -> CostBenefit {
        let (hidden, frames) = if estimate.is_unknown {
            (self.unknown_hidden(), HORIZON_FRAMES)
        } else {
            (self.still_hidden(), 1.0)
        };
        let fill = LEAF_FILL * estimate.pixels * self.table.hidden_pixel_ns;
        let leaf_ns = (self.leaf_ns - self.costs.skipped_draw_ns).max(0.0);
        let drawing = estimate.leaves as f32 * leaf_ns + fill;
        let cost_ns = self.box_ns(estimate.pixels, hidden, tester) + self.costs.predicate_ns;
        let saving_now_ns = (hidden * drawing).min(f32::MAX);
        let saving_ns = (frames * saving_now_ns).min(f32::MAX);
        let revealed_ns = (HORIZON_FRAMES * (1.0 - hidden) * drawing).min(f32::MAX);
        CostBenefit { saving_ns, saving_now_ns, revealed_ns, cost_ns: cost_ns.min(f32::MAX) }
    }

    /// Weighs a pull-up query. It saves nothing in this frame, but from then on one test may cover
    /// all parts of its node. So it may pay off even if a test of a single leaf does not.
    #[must_use]
    pub(crate) fn weigh_pull_up(
        &self,
        estimate: &TestEstimate,
        tester: VisibilityTest,
    ) -> CostBenefit {
        let benefit = self.weigh(estimate, tester);
        let saving_ns = HORIZON_FRAMES * (benefit.saving_ns - benefit.cost_ns).max(0.0);
        CostBenefit { saving_ns: saving_ns.min(f32::MAX), ..benefit }
    }

    /// Returns the cheaper available tester of a box: flag or query.
    #[must_use]
    pub(crate) fn cheaper(&self, estimate: &TestEstimate, has_flags: bool) -> VisibilityTest {
        let cost = |tester| self.weigh(estimate, tester).cost_ns;
        if has_flags && cost(VisibilityTest::Flag) <= cost(VisibilityTest::Query) {
            VisibilityTest::Flag
        } else {
            VisibilityTest::Query
        }
    }

    /// Returns true if a compute shader is the cheapest tester of a round. The round has `boxes`
    /// boxes that cover `pixels` in total, and `shared` tests that share a result. A shared result
    /// costs the other testers nothing. The compute shader has a fixed cost per round, the others a
    /// cost per pixel.
    #[must_use]
    pub(crate) fn is_for_compute(
        &self,
        boxes: u32,
        shared: u32,
        pixels: f32,
        has_flags: bool,
    ) -> bool {
        let count = boxes as f32;
        let hidden = self.still_hidden();
        let per_box = |tester| self.box_ns(pixels / count.max(1.0), hidden, tester);
        let flag = count * per_box(VisibilityTest::Flag);
        let query = count * per_box(VisibilityTest::Query);
        let raster = if has_flags { flag.min(query) } else { query };
        let computed = count + shared as f32;
        self.costs.compute_round_ns + computed * self.costs.compute_box_ns < raster
    }

    /// Returns the cheapest tester for frames with this work and this size in pixels, as far as it
    /// can be estimated before the first frame. Assumes that the boxes cover the image twice, in
    /// the rounds of `work`, or in one round by the compute shader. Without queries, returns the
    /// tester of [`VisibilityTestSupport::strategy`].
    #[must_use]
    pub fn tester_for(
        &self,
        work: &SkippedWork,
        size: [u32; 2],
        testers: VisibilityTestSupport,
    ) -> VisibilityTest {
        if let Some(only) = testers.strategy(Strategy::ANTUMBRA).tester() {
            return only;
        }
        let ranges = work.ranges.max(1);
        let estimate = TestEstimate {
            leaves: work.draws / ranges,
            pixels: COVERED * size.map(|side| side as f32).iter().product::<f32>() / ranges as f32,
            is_unknown: false,
        };
        let frame_ns = |tester, rounds: u32| {
            let boxes_ns = ranges as f32 * self.weigh(&estimate, tester).cost_ns;
            boxes_ns + rounds as f32 * self.break_ns(0, tester)
        };
        let rastered = self.cheaper(&estimate, testers.flags);
        let is_computed = testers.compute
            && frame_ns(VisibilityTest::Compute, 1) < frame_ns(rastered, work.rounds.max(1));
        if is_computed { VisibilityTest::Compute } else { rastered }
    }

    /// Returns the cost of the breaks of a frame that takes `leaves` leaves as visible, with one
    /// round that `tester` tests. Tests whose total saving is less are left out.
    pub(crate) fn break_ns(&self, leaves: usize, tester: VisibilityTest) -> f32 {
        let drawn = leaves as f32 * self.leaf_ns;
        (self.round_ns(tester) + self.costs.break_wait_share * drawn).min(f32::MAX)
    }

    /// Returns the cost of a further round: its break, and the fixed cost of `tester`. The wait for
    /// the draws before the tests is not included, because it occurs only once.
    pub(crate) fn round_ns(&self, tester: VisibilityTest) -> f32 {
        let CostTable { break_ns, compute_round_ns, .. } = self.costs;
        break_ns + if tester == VisibilityTest::Compute { compute_round_ns } else { 0.0 }
    }

    /// Takes the GPU time of a frame with these contents. The costs of tests are corrected if
    /// different frames agree that tests are more or less expensive, relative to draws, than the
    /// table says ([`LearnedCosts::corrections`]). Impossible times are ignored.
    pub fn observe(&mut self, gpu_ns: f64, contents: &FrameContents) {
        if self.learner.note(gpu_ns, contents.predicted(&self.table)) {
            self.costs = self.table.with_tests_at(self.corrections().proportion);
        }
    }

    fn box_ns(&self, pixels: f32, hidden: f32, tester: VisibilityTest) -> f32 {
        let table = &self.costs;
        match tester {
            VisibilityTest::Query => {
                table.query_ns + table.query_box_ns + pixels * table.hidden_pixel_ns
            }
            VisibilityTest::Flag => {
                let shown = (1.0 - hidden) * table.flagged_pixel_ns;
                table.flag_box_ns + pixels * (hidden * table.hidden_pixel_ns + shown)
            }
            // The fixed cost of the round is counted once per round.
            VisibilityTest::Compute => table.compute_box_ns,
            // The test whose result is shared includes the cost.
            VisibilityTest::SharedProxy(_) => 0.0,
        }
    }
}

/// Returns true if an interval stands for no own-draw tests.
pub(crate) const fn is_never(retest_frames: u32) -> bool {
    retest_frames >= NEVER_FRAMES
}

#[cfg(test)]
mod tests;
