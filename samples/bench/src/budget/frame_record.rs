//! One frame of a walk as it was planned and drawn, and the plans that leave parts of it out.

use antumbra::cull::{FramePlan, LeafIndex, ProxyTest, QueryKind, VisibilityTest};

use super::ablation::Ablation;

/// A frame that Antumbra's method planned, with its results.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameRecord {
    /// The plan of the method.
    pub(super) plan: FramePlan,
    /// The leaves that the tests of the plan revealed, in the order of the tests. Where too many
    /// showed to be listed, those that own a pixel.
    pub(super) revealed: Vec<LeafIndex>,
    /// The leaves that own a pixel, nearest first.
    pub(super) visible: Vec<LeafIndex>,
}

impl FrameRecord {
    /// Notes the leaves that own a pixel.
    pub(super) fn see(&mut self, visible: &[LeafIndex]) {
        let plan = &self.plan;
        let is_drawn = |leaf: &LeafIndex| {
            let queried = &plan.queried_draws;
            plan.draws.contains(leaf) || queried.iter().any(|(queried, _)| queried == leaf)
        };
        let missing: Vec<LeafIndex> = visible
            .iter()
            .filter(|leaf| !is_drawn(leaf) && !self.revealed.contains(leaf))
            .copied()
            .collect();
        self.revealed.extend(missing);
        self.visible = visible.to_vec();
    }

    /// Writes the plan of an ablation into `plan`, whose frame stays.
    pub(super) fn write_plan(&self, ablation: Ablation, plan: &mut FramePlan) {
        let recorded = &self.plan;
        match ablation {
            Ablation::Ideal => plan.draws.extend(&self.visible),
            Ablation::Draws | Ablation::ReadBack => {
                let mut drawn = 0;
                for ((leaf, _), after) in recorded.queried_draws.iter().zip(&recorded.queried_after)
                {
                    let after = *after as usize;
                    plan.draws.extend(&recorded.draws[drawn..after]);
                    plan.draws.push(*leaf);
                    drawn = after;
                }
                plan.draws.extend(&recorded.draws[drawn..]);
                plan.draws.extend(&self.revealed);
                if ablation == Ablation::ReadBack
                    && let Some(first) = recorded.queried_draws.first()
                {
                    plan.draws.retain(|leaf| *leaf != first.0);
                    plan.queried_draws.push(*first);
                    plan.queried_after.extend(recorded.queried_after.first());
                }
            }
            Ablation::Retests => self.write_draws(plan),
            Ablation::Breaks => {
                self.write_draws(plan);
                for round in &recorded.rounds {
                    let first = plan.tests.len();
                    let kept = self.hidden_test(&recorded.tests[round.clone()]);
                    plan.tests.extend(kept.map(|place| recorded.tests[round.start + place]));
                    if first < plan.tests.len() {
                        plan.rounds.push(first..plan.tests.len());
                    }
                }
            }
            Ablation::Proxies => {
                self.write_draws(plan);
                plan.tests.extend(recorded.tests.iter().map(without_consequence));
                plan.rounds.extend(recorded.rounds.iter().cloned());
                for round in &recorded.rounds {
                    if let Some(place) = self.hidden_test(&recorded.tests[round.clone()]) {
                        plan.tests[round.start + place] = recorded.tests[round.start + place];
                    }
                }
            }
            Ablation::Replay | Ablation::Whole => {
                plan.draws.extend(&recorded.draws);
                plan.queried_draws.extend(&recorded.queried_draws);
                plan.queried_after.extend(&recorded.queried_after);
                plan.tests.extend(&recorded.tests);
                plan.rounds.extend(recorded.rounds.iter().cloned());
            }
        }
    }

    /// Writes all draws of the frame as visible ones, with the queries of the plan.
    fn write_draws(&self, plan: &mut FramePlan) {
        plan.draws.extend(&self.plan.draws);
        plan.draws.extend(&self.revealed);
        plan.queried_draws.extend(&self.plan.queried_draws);
        plan.queried_after.extend(&self.plan.queried_after);
    }

    /// Returns the place of a test that reveals nothing, and so makes a break without a draw: the
    /// one with the fewest leaves that has a proxy of its own.
    fn hidden_test(&self, tests: &[ProxyTest]) -> Option<usize> {
        let is_hidden = |test: &ProxyTest| {
            let shares = matches!(test.tester, VisibilityTest::SharedProxy(_));
            let decides = test.tag.kind == QueryKind::Proxy && test.leaves.count > 0;
            decides && !shares && !self.revealed.iter().any(|leaf| test.leaves.contains(*leaf))
        };
        let hidden = tests.iter().enumerate().filter(|(_, test)| is_hidden(test));
        hidden.min_by_key(|(_, test)| test.leaves.count).map(|(place, _)| place)
    }
}

/// Returns a test on which no draw depends.
fn without_consequence(test: &ProxyTest) -> ProxyTest {
    let mut free = *test;
    if free.leaves.count > 0 {
        free.leaves.count = 0;
        free.tag.kind = QueryKind::PullUpQuery;
    }
    free
}

#[cfg(test)]
mod tests {
    use super::*;
    use antumbra::cull::{Aabb, FrameId, Generation, LeafRange, NodeId, QueryTag};
    use antumbra::glam::Vec3;

    fn tag(node: u32, kind: QueryKind) -> QueryTag {
        let generation = Generation(0);
        QueryTag { node: NodeId(node), generation, frame: FrameId(1), kind, sample_threshold: 0 }
    }

    fn test(node: u32, first: u32, tester: VisibilityTest) -> ProxyTest {
        let leaves = LeafRange { first: LeafIndex(first), count: 2 };
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
        ProxyTest { tag: tag(node, QueryKind::Proxy), bounds, leaves, level: 1, tester }
    }

    /// Returns a frame that draws leaves 0, 1 and 2, and tests 4 to 11 in two rounds; 6 showed.
    fn frame() -> FrameRecord {
        let flag = VisibilityTest::Flag;
        let shared = VisibilityTest::SharedProxy(0);
        let plan = FramePlan {
            draws: vec![LeafIndex(0), LeafIndex(2)],
            queried_draws: vec![(LeafIndex(1), tag(0, QueryKind::VisibleDrawQuery))],
            queried_after: vec![1],
            tests: vec![test(1, 4, flag), test(2, 6, flag), test(3, 8, shared), test(4, 10, flag)],
            rounds: vec![0..2, 2..4],
            ..FramePlan::default()
        };
        FrameRecord { plan, revealed: vec![LeafIndex(6)], visible: vec![LeafIndex(2)] }
    }

    fn plan_of(ablation: Ablation) -> FramePlan {
        let mut plan = FramePlan::default();
        frame().write_plan(ablation, &mut plan);
        plan
    }

    #[test]
    fn draws_without_tests_are_all_draws_in_the_order_of_the_frame() {
        assert_eq!(plan_of(Ablation::Draws).draws, [0, 1, 2, 6].map(LeafIndex));
        assert_eq!(plan_of(Ablation::Ideal).draws, [LeafIndex(2)]);
    }

    #[test]
    fn a_break_is_made_by_one_test_that_shows_nothing() {
        let plan = plan_of(Ablation::Breaks);
        let nodes: Vec<NodeId> = plan.tests.iter().map(|test| test.tag.node).collect();
        assert_eq!(nodes, [NodeId(1), NodeId(4)]);
        assert_eq!(plan.rounds, [0..1, 1..2]);
    }

    #[test]
    fn proxies_without_consequence_reveal_nothing_but_make_the_breaks() {
        let plan = plan_of(Ablation::Proxies);
        let counts: Vec<u32> = plan.tests.iter().map(|test| test.leaves.count).collect();
        assert_eq!(counts, [2, 0, 0, 2]);
        assert_eq!(plan.draws.len() + plan.queried_draws.len(), 4);
    }

    #[test]
    fn one_query_is_enough_to_read_results_back() {
        let plan = plan_of(Ablation::ReadBack);
        assert_eq!(plan.draws, [0, 2, 6].map(LeafIndex));
        assert_eq!(plan.queried_draws, frame().plan.queried_draws);
        assert_eq!(plan.queried_after, [1]);
        assert!(plan.tests.is_empty());
    }

    #[test]
    fn what_owns_a_pixel_is_drawn_even_if_too_much_showed_to_be_listed() {
        let mut frame = frame();
        frame.see(&[9, 6, 1, 2].map(LeafIndex));
        assert_eq!(frame.revealed, [6, 9].map(LeafIndex));
    }

    #[test]
    fn a_replay_is_the_recorded_plan() {
        let plan = plan_of(Ablation::Replay);
        let recorded = frame().plan;
        assert_eq!(plan.draws, recorded.draws);
        assert_eq!(plan.queried_draws, recorded.queried_draws);
        assert_eq!(plan.tests, recorded.tests);
        assert_eq!(plan.rounds, recorded.rounds);
    }
}
