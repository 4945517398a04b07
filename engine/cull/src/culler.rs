//! One view's culler: takes answers, keeps the history, makes plans.

mod answers;
mod cover;
mod economy;
mod explain;
mod history;
mod record;
mod rounds;
mod selection;
mod traversal;

use glam::Vec3;

use crate::cost_model::CostModel;
use crate::costs::{BadCost, CostTable, SceneCosts};
use crate::frustum::PlaneMask;
use crate::hierarchy::Hierarchy;
use crate::ids::{FrameId, LeafIndex, NodeId};
use crate::next_frame::NextFrame;
use crate::plan::{
    Abilities, Answer, FramePlan, PlanStats, ProxyTest, QueryKind, QueryTag, Tester,
};
use crate::policy::Policy;
use crate::rng::SplitMix64;
use crate::strategy::Strategy;
use crate::view::View;
use cover::Front;
use economy::Economy;
pub use explain::{Decision, LeafExplanation, NodeHistory, Outcome};
use history::History;
pub(crate) use record::Doubt;
pub use record::NodeState;
use record::Stamp;
use rounds::Grouping;
use selection::Scratch;
use traversal::{Knowledge, Walk};

/// Decides for one view of one hierarchy what to draw and what to ask.
///
/// The history lives here: one culler for each eye, light or probe. It follows rebuilds of its
/// hierarchy by itself. What it believes never changes what is seen, only what that costs.
#[derive(Debug)]
pub struct Culler {
    policy: Policy,
    abilities: Abilities,
    history: History,
    next_frame: NextFrame,
    scratch: Scratch,
    grouping: Grouping,
    fronts: Vec<Front>,
    governor: Option<CostModel>,
    /// Samples of a query that count as none.
    neglected_samples: u32,
    /// The policy with what the governor made of it.
    tuned: Policy,
    /// Leaves that the last frame took as visible.
    visible: u32,
    rng: SplitMix64,
    frame: FrameId,
    /// The frame that the history's stamps count from.
    epoch: u64,
    /// Where the view looked in the last planned frame.
    forward: Option<Vec3>,
    turned: Stamp,
    /// How much coarser than wished the tests of the last frame were.
    coarseness: u32,
}

impl Culler {
    /// A culler that knows nothing yet and has nothing but queries.
    #[must_use]
    pub fn new(policy: Policy) -> Self {
        Self::with_abilities(policy, Abilities::default())
    }

    /// A culler that knows nothing yet, for a device that can do more than queries.
    #[must_use]
    pub fn with_abilities(policy: Policy, abilities: Abilities) -> Self {
        Self {
            policy,
            abilities,
            history: History::default(),
            next_frame: NextFrame::default(),
            scratch: Scratch::default(),
            grouping: Grouping::default(),
            fronts: Vec::new(),
            governor: None,
            neglected_samples: 0,
            tuned: policy,
            visible: 0,
            rng: SplitMix64::new(policy.seed),
            frame: FrameId(0),
            epoch: 0,
            forward: None,
            turned: Stamp::NEVER,
            coarseness: 0,
        }
    }

    /// Takes what shows no more than so many samples as hidden from now on (GPU Gems 2, 6.5.4): whoever
    /// executes the plans leaves the leaves of such tests out. Above 0 the image is not exact, and
    /// a query must count. For plans that are answered by queries: what is set by
    /// fragments counts nothing, and shows if it is not zero. [`Strategy::NextFrame`] goes by
    /// whether anything shows.
    pub fn neglect(&mut self, samples: u32) {
        self.neglected_samples = samples;
    }

    /// Leaves out tests that cost more than they save, from now on. Without prices everything is
    /// tested that may be hidden.
    ///
    /// # Errors
    /// [`BadCost`] for prices that cannot be; the culler is then as it was.
    pub fn govern(&mut self, table: CostTable, scene: SceneCosts) -> Result<(), BadCost> {
        self.governor = Some(CostModel::new(table, scene)?);
        Ok(())
    }

    /// What weighs costs against savings, if anything does.
    #[must_use]
    pub fn governor(&self) -> Option<&CostModel> {
        self.governor.as_ref()
    }

    /// The same, to tell it what frames took ([`CostModel::observe`]).
    pub fn governor_mut(&mut self) -> Option<&mut CostModel> {
        self.governor.as_mut()
    }

    /// The constants in use.
    #[must_use]
    pub fn policy(&self) -> &Policy {
        &self.policy
    }

    /// The frame planned last; 0 before the first.
    #[must_use]
    pub fn frame(&self) -> FrameId {
        self.frame
    }

    /// What is known of a node; unknown for a foreign id.
    #[must_use]
    pub fn state(&self, node: NodeId) -> NodeState {
        self.history.record(node.0).state
    }

    /// Forgets everything; the next frame starts like the first, and answers to earlier ones are
    /// ignored. After a change that makes the past worthless, such as a new scene.
    pub fn forget(&mut self) {
        self.history.forget();
        self.next_frame.forget();
        self.epoch = self.frame.0;
        self.turned = Stamp::NEVER;
        self.forward = None;
        self.coarseness = 0;
        if let Some(governor) = &mut self.governor {
            governor.forget();
        }
    }

    /// Takes answers to queries of earlier plans: in any order, late, twice, or never. Those that
    /// fit nothing (a node that stood for something else, a frame to come, older than what is known)
    /// are ignored.
    pub fn ingest(&mut self, hierarchy: &Hierarchy, answers: impl IntoIterator<Item = Answer>) {
        self.history.adopt(hierarchy);
        let now = self.stamp(self.frame).unwrap_or(Stamp::NEVER);
        for Answer { tag, samples } in answers {
            if !hierarchy.is_same_since(tag.node, tag.generation) || tag.frame > self.frame {
                continue;
            }
            let Some(asked) = self.stamp(tag.frame) else {
                continue;
            };
            self.next_frame.take(hierarchy, &tag, samples);
            let samples = match tag.kind {
                // Told by fragments.
                QueryKind::Part => samples,
                _ => samples.saturating_sub(self.neglected_samples),
            };
            let record = self.history.record(tag.node.0);
            if let Some(governor) = self.governor.as_mut().filter(|_| record.answered < asked) {
                governor.learn(tag.kind, record.state, record.doubt, samples > 0);
                self.history.answered_assumed(tag.node.0);
            }
            answers::Ingest {
                history: &mut self.history,
                topology: &hierarchy.topology,
                policy: &self.tuned,
                rng: &mut self.rng,
                now,
                asked,
            }
            .apply(tag.node.0, tag.kind, samples);
        }
    }

    /// Plans the next frame into `plan`, whose vectors are reused. Never asks for more than
    /// `query_budget` queries, and draws what it could not ask about.
    pub fn plan(
        &mut self,
        hierarchy: &Hierarchy,
        strategy: Strategy,
        view: &View,
        query_budget: usize,
        plan: &mut FramePlan,
    ) {
        let now = self.advance();
        self.history.adopt(hierarchy);
        self.watch(view, now);
        plan.clear(self.frame);
        if strategy == Strategy::NextFrame {
            return self.next_frame.plan(hierarchy, view, plan);
        }
        let tester = self.tester(strategy);
        let policy = self.tune(strategy, &mut plan.stats);
        let mut walk = Walk {
            hierarchy,
            view,
            policy: &policy,
            knowledge: match strategy.is_governed() {
                true => Knowledge::Used(&self.history),
                // Those that decide elsewhere get what they start from.
                false => Knowledge::Ignored,
            },
            now,
            can_flag: tester != Tester::Query,
            growth_frames: match self.abilities.parts {
                true => policy.growth_frames_parts,
                false => policy.growth_frames,
            },
            is_turning: self.turned != Stamp::NEVER
                && now.since(self.turned) < policy.turning_frames,
            // What was needed last time is where to begin: each attempt is a walk.
            coarseness: self.coarseness.saturating_sub(1),
        };
        let governor = self.governor.as_ref().filter(|_| strategy.is_governed());
        let economy = governor.map(|governor| Economy {
            governor,
            tester: (strategy != Strategy::Antumbra).then(|| self.tester(strategy)),
            has_flags: self.abilities.flags,
        });
        let economy = economy.as_ref();
        let is_cut = self.scratch.choose(&mut walk, query_budget, economy, &mut plan.stats);
        self.coarseness = walk.coarseness;
        let generation = hierarchy.generation();
        let frame = self.frame;
        let tag =
            |node: u32, kind: QueryKind| QueryTag { node: NodeId(node), generation, frame, kind };
        let contained =
            |node: u32| view.frustum.classify(&hierarchy.bounds(NodeId(node)), PlaneMask::ALL).0;
        plan.draws.extend(self.scratch.draws.iter().map(|draw| draw.leaf));
        self.scratch.place_retests();
        for retest in &self.scratch.retests {
            plan.queried_after.push(retest.after);
            let asked = tag(retest.node, QueryKind::OwnDraw);
            plan.queried_draws.push((retest.leaf, asked));
            self.history.doubt(retest.node, contained(retest.node));
            self.history.asked_own_draw(retest.node, now, &policy, &mut self.rng);
        }
        for [leaf, top] in &self.scratch.assumed {
            let due = now.plus(self.rng.between(1, policy.retest_max));
            self.history.assume_visible(&hierarchy.topology, *leaf, *top, now, due, &policy);
        }
        for test in &self.scratch.tests {
            let node = NodeId(test.node);
            let question = economy.map(|_| Economy::question(view, test));
            plan.stats.proxy_pixels += question.map_or(0, |question| question.pixels as u64);
            let mut leaves = hierarchy.leaves(node);
            let mut kind = test.kind;
            if kind == QueryKind::Probe {
                leaves.count = 0;
                self.history.asked_probe(test.node, now, &policy);
            } else if kind == QueryKind::OwnBox {
                leaves.count = 0;
                self.history.doubt(test.node, contained(test.node));
            } else {
                match test.inherited {
                    Some(since) => self.history.inherit(test.node, since),
                    None => self.history.closed(&hierarchy.topology, test.node),
                }
                if self.abilities.parts && leaves.count >= policy.parts_leaves {
                    kind = QueryKind::Parts;
                }
            }
            plan.tests.push(ProxyTest {
                tag: tag(test.node, kind),
                bounds: test.proxy,
                leaves,
                level: hierarchy.level(node),
                tester: match economy.zip(question) {
                    // Boxes of visible leaves are not counted as queries, nor asked by them.
                    Some((economy, question)) if kind != QueryKind::OwnBox => {
                        economy.tester(&question)
                    }
                    _ => tester,
                },
            });
        }
        for node in &self.scratch.visited {
            self.history.visit(*node, now);
        }
        if self.abilities.parts {
            let fronts = &mut self.fronts;
            let hidden_frames = self.scratch.tests.iter().map(|test| test.hidden_frames);
            plan.stats.behind =
                cover::share_answers(&mut plan.tests, hidden_frames, view, &policy, fronts);
        }
        let most = match (tester, is_cut) {
            (Tester::Compute, false) => policy.rounds_compute_calm,
            (Tester::Compute, true) => policy.rounds_compute_cut,
            (_, false) => policy.rounds_calm,
            (_, true) => policy.rounds_cut,
        };
        rounds::split(plan.tests.len(), most, is_cut, &policy, &mut plan.rounds);
        let chooses = strategy == Strategy::Antumbra && self.abilities.compute;
        plan.stats.rounds_by_compute =
            economy.filter(|_| chooses).map_or(0, |it| it.hand_to_compute(view, plan));
        self.visible = plan.stats.visible;
        if let Some(governor) = self.governor.as_mut().filter(|_| strategy.is_governed()) {
            let [saving_ns, break_ns] = self.scratch.prospect_ns;
            governor.note_prospect(saving_ns, break_ns, plan.stats.visible);
        }
        rounds::group_by_tester(&mut plan.tests, &plan.rounds, &mut self.grouping);
    }

    /// Plans the next frame from the outcome: draws `leaves` in their order and asks nothing
    /// ([`Strategy::Ideal`]; [`Culler::plan`] cannot know them and falls back to frustum culling).
    pub fn plan_known(
        &mut self,
        hierarchy: &Hierarchy,
        leaves: &[LeafIndex],
        plan: &mut FramePlan,
    ) {
        self.advance();
        self.history.adopt(hierarchy);
        plan.clear(self.frame);
        plan.draws.extend_from_slice(leaves);
        plan.stats.visible = leaves.len() as u32;
    }

    /// The constants for the next frame.
    fn tune(&mut self, strategy: Strategy, stats: &mut PlanStats) -> Policy {
        self.tuned = self.policy;
        if let Some(governor) = self.governor.as_mut().filter(|_| strategy.is_governed()) {
            governor.begin_frame(self.visible);
            self.tuned = governor.tuned(&self.policy);
            stats.retest_interval_frames = self.tuned.retest_max;
        }
        self.tuned
    }

    /// Who answers for a proxy.
    fn tester(&self, strategy: Strategy) -> Tester {
        match strategy {
            Strategy::AntumbraQueries => Tester::Query,
            Strategy::AntumbraCompute if self.abilities.compute => Tester::Compute,
            _ if self.abilities.flags => Tester::Flag,
            _ => Tester::Query,
        }
    }

    /// Begins the next frame.
    fn advance(&mut self) -> Stamp {
        self.frame.0 = self.frame.0.saturating_add(1);
        if let Some(now) = self.stamp(self.frame) {
            return now;
        }
        // Two years at 60 Hz are over: stamps are 32 bits, so the past begins anew.
        self.forget();
        self.epoch = self.frame.0.saturating_sub(1);
        Stamp::FIRST
    }

    /// The stamp of a frame after the epoch.
    fn stamp(&self, frame: FrameId) -> Option<Stamp> {
        frame.0.checked_sub(self.epoch).and_then(Stamp::new)
    }

    /// Notes whether the view turns.
    fn watch(&mut self, view: &View, now: Stamp) {
        if let Some(before) = self.forward.replace(view.forward) {
            let sine = before.cross(view.forward).length();
            if sine > self.policy.turning_sine || before.dot(view.forward) < 0.0 {
                self.turned = now;
            }
        }
    }
}
