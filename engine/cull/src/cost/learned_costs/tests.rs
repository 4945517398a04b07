//! Tests of the cost model.

use super::*;

fn learned_costs() -> LearnedCosts {
    LearnedCosts::new(CostTable::default(), SceneCosts::default()).unwrap()
}

#[test]
fn visible_draws_are_tested_by_the_square_root_of_the_rate() {
    let config = CullConfig::default();
    let interval = |hides_per_frame: f32| {
        let mut learned_costs = learned_costs();
        let mut owed = 0.0;
        for _ in 0..2_000 {
            learned_costs.begin_frame(10_000);
            learned_costs.note_prospect(1.0, 1.0, 0);
            owed += hides_per_frame;
            while owed >= 1.0 {
                owed -= 1.0;
                learned_costs.learn(
                    QueryKind::VisibleDrawQuery,
                    NodeState::Visible,
                    RetestReason::None,
                    false,
                );
            }
        }
        learned_costs.retest_frames(&config) as f32
    };
    assert_eq!(learned_costs().retest_frames(&config), config.retest_max);
    assert_eq!(interval(0.0), CALM_RETEST_FRAMES);
    let rare = interval(0.5);
    let often = interval(2.0);
    assert!((rare / often - 2.0).abs() < 0.1, "{rare} {often}");
    assert_eq!(interval(10_000.0), config.retest_max as f32);
}

#[test]
fn what_nothing_is_made_of_is_asked_seldom_and_in_few_frames() {
    let config = CullConfig::default();
    let costs = CostTable { break_wait_share: 0.2, ..CostTable::default() };
    let mut learned_costs = LearnedCosts::new(costs, SceneCosts::default()).unwrap();
    let mut busy_frame = |is_paid| {
        learned_costs.begin_frame(100);
        for number in 0..100 {
            let showed = number >= 10;
            learned_costs.learn(
                QueryKind::VisibleDrawQuery,
                NodeState::Visible,
                RetestReason::None,
                showed,
            );
        }
        let drawn_ns = 100.0 * learned_costs.leaf_ns;
        learned_costs.note_prospect(if is_paid { drawn_ns } else { 0.0 }, drawn_ns, 100);
        learned_costs.tuned(&config)
    };
    for _ in 0..50 {
        assert_eq!(busy_frame(true).tuning.retest_gate, 1);
    }
    let idle = (0..50).map(|_| busy_frame(false)).last().unwrap();
    assert_eq!(idle.tuning.retest_gate, 20, "its share of a frame's draws is a fifth");
    assert!(
        idle.retest_max > config.retest_max && idle.tuning.visible_box_angle == 0.0,
        "{idle:?}"
    );
    let busy = busy_frame(true);
    assert_eq!((busy.tuning.retest_gate, busy.retest_max), (1, config.retest_max));
}

#[test]
fn a_test_pays_as_often_as_it_saves() {
    let mut learned_costs = learned_costs();
    let estimate = TestEstimate { leaves: 2, pixels: 1_000.0, is_unknown: true };
    assert!(learned_costs.weigh(&estimate, VisibilityTest::Flag).pays());
    for _ in 0..400 {
        learned_costs.learn(QueryKind::Proxy, NodeState::Unknown, RetestReason::None, true);
    }
    assert!(!learned_costs.weigh(&estimate, VisibilityTest::Flag).pays());
    let known = TestEstimate { is_unknown: false, ..estimate };
    assert!(learned_costs.weigh(&known, VisibilityTest::Flag).pays(), "that is another matter");
    let mut frames = 0;
    while !learned_costs.weigh(&estimate, VisibilityTest::Flag).pays() {
        learned_costs.begin_frame(0);
        frames += 1;
        assert!(frames < 1_000, "evidence fades");
    }
    assert!(frames > 30, "but not at once: {frames}");
}

#[test]
fn many_pixels_go_to_the_compute_tester() {
    let learned_costs = learned_costs();
    assert!(!learned_costs.is_for_compute(50, 0, 10_000.0, true));
    assert!(learned_costs.is_for_compute(50, 0, 4.0e6, true));
    assert!(!learned_costs.is_for_compute(50, 5_000, 4.0e6, true), "the others share");
    let estimate = TestEstimate { leaves: 1, pixels: 100.0, is_unknown: false };
    assert_eq!(learned_costs.cheaper(&estimate, true), VisibilityTest::Flag);
    assert_eq!(learned_costs.cheaper(&estimate, false), VisibilityTest::Query);
}

#[test]
fn extreme_costs_give_decisions_all_the_same() {
    let estimate = TestEstimate { leaves: u32::MAX, pixels: f32::MAX, is_unknown: true };
    for ns in [0.0, f32::MIN_POSITIVE, f32::MAX] {
        for triangles_per_leaf in [0.0, f32::MAX] {
            let scene = SceneCosts { triangles_per_leaf };
            let learned_costs = LearnedCosts::new(CostTable::uniform(ns), scene).unwrap();
            let benefit = learned_costs.weigh(&estimate, VisibilityTest::Query);
            assert!(benefit.cost_ns.is_finite() && benefit.saving_ns.is_finite());
            assert!(learned_costs.break_ns(usize::MAX, VisibilityTest::Compute).is_finite());
            assert!(learned_costs.retest_frames(&CullConfig::default()) > 0);
        }
    }
    assert!(LearnedCosts::new(CostTable::uniform(f32::NAN), SceneCosts::default()).is_err());
    let nothing = SceneCosts { triangles_per_leaf: f32::NAN };
    assert!(LearnedCosts::new(CostTable::default(), nothing).is_err());
}
