//! One view's culler: takes answers, keeps the history, makes plans.

mod answers;
mod history;
mod record;
mod rounds;
mod selection;
mod traversal;

use glam::Vec3;

use crate::hierarchy::Hierarchy;
use crate::ids::{FrameId, NodeId};
use crate::plan::{Answer, FramePlan, ProxyTest, QueryKind, QueryTag};
use crate::policy::Policy;
use crate::rng::SplitMix64;
use crate::strategy::Strategy;
use crate::view::View;
use history::History;
pub use record::NodeState;
use record::Stamp;
use selection::Scratch;
use traversal::{Knowledge, Walk};

/// Decides for one view of one hierarchy what to draw and what to ask.
///
/// The history lives here: one culler for each eye, light or probe. It follows rebuilds of its
/// hierarchy by itself. What it believes never changes what is seen, only what that costs.
#[derive(Debug)]
pub struct Culler {
    policy: Policy,
    history: History,
    scratch: Scratch,
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
    /// A culler that knows nothing yet.
    #[must_use]
    pub fn new(policy: Policy) -> Self {
        Self {
            policy,
            history: History::default(),
            scratch: Scratch::default(),
            rng: SplitMix64::new(policy.seed),
            frame: FrameId(0),
            epoch: 0,
            forward: None,
            turned: Stamp::NEVER,
            coarseness: 0,
        }
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
        self.epoch = self.frame.0;
        self.turned = Stamp::NEVER;
        self.forward = None;
        self.coarseness = 0;
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
            answers::Ingest {
                history: &mut self.history,
                topology: &hierarchy.topology,
                policy: &self.policy,
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
        let mut walk = Walk {
            hierarchy,
            view,
            policy: &self.policy,
            knowledge: match strategy {
                Strategy::Frustum => Knowledge::Ignored,
                Strategy::Antumbra => Knowledge::Used(&self.history),
            },
            now,
            is_turning: self.turned != Stamp::NEVER
                && now.since(self.turned) < self.policy.turning_frames,
            // What was needed last time is where to begin: each attempt is a walk.
            coarseness: self.coarseness.saturating_sub(1),
        };
        let is_cut = self.scratch.choose(&mut walk, query_budget, &mut plan.stats);
        self.coarseness = walk.coarseness;
        let generation = hierarchy.generation();
        let frame = self.frame;
        let tag =
            |node: u32, kind: QueryKind| QueryTag { node: NodeId(node), generation, frame, kind };
        plan.draws.extend(self.scratch.draws.iter().map(|draw| draw.leaf));
        for retest in &self.scratch.retests {
            let asked = tag(retest.node, QueryKind::OwnDraw);
            plan.queried_draws.push((retest.leaf, asked));
            self.history.asked_own_draw(retest.node, now, &self.policy, &mut self.rng);
        }
        for test in &self.scratch.tests {
            let node = NodeId(test.node);
            let mut leaves = hierarchy.leaves(node);
            if test.kind == QueryKind::Probe {
                leaves.count = 0;
                self.history.asked_probe(test.node, now, &self.policy);
            } else {
                self.history.closed(&hierarchy.topology, test.node);
            }
            plan.tests.push(ProxyTest {
                tag: tag(test.node, test.kind),
                bounds: test.proxy,
                leaves,
                level: hierarchy.level(node),
            });
        }
        for node in &self.scratch.visited {
            self.history.visit(*node, now);
        }
        rounds::split(plan.tests.len(), is_cut, &self.policy, &mut plan.rounds);
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
