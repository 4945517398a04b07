//! Tests of costs, which determine the tests but never the image.

use std::collections::BTreeSet;

use antumbra_cull::{
    Aabb, Camera, CostTable, CullConfig, CullView, Culler, FramePlan, ObjectId, Projection,
    ProxyTest, SceneCosts, Strategy, VisibilityTest, VisibilityTestSupport,
};
use glam::Vec3;

use crate::random::Random;
use crate::scene::city;
use crate::walk::{BUDGET, SIZE, Walk};

const CAMERA: Camera = Camera {
    eye: Vec3::ZERO,
    forward: Vec3::NEG_Z,
    up: Vec3::Y,
    projection: Projection::perspective(1.2),
    near: 0.1,
};

/// Costs with free tests.
const FREE_TESTS: CostTable = CostTable { draw_ns: 1_000.0, ..CostTable::uniform(0.0) };

/// Costs with tests that cost more than they can save.
const DEAR_TESTS: CostTable =
    CostTable { draw_ns: 1_000.0, triangle_ns: 50.0, ..CostTable::uniform(f32::MAX) };

/// Returns costs of the scale of this scene, in which a test costs half a draw.
pub fn costs() -> CostTable {
    let queries = CostTable { query_ns: 1_500.0, query_box_ns: 1_000.0, ..CostTable::default() };
    CostTable { break_ns: 20_000.0, ..queries }
}

/// Returns a wall outside of the view, and objects side by side that do not hide each other.
fn field(columns: u32) -> Vec<Aabb> {
    let things = (0..columns * 11).map(|number| {
        let [column, row] = [number % columns, number / columns].map(|place| place as f32);
        let centre = Vec3::new(column - 7.5, row - 5.0, -8.0) * 2.5;
        Aabb::new(centre - 1.1, centre + 1.1)
    });
    std::iter::once(WALL_AWAY).chain(things).collect()
}

const WALL_AWAY: Aabb =
    Aabb { min: Vec3::new(-40.0, 900.0, -6.0), max: Vec3::new(40.0, 980.0, -5.0) };
const WALL_HERE: Aabb =
    Aabb { min: Vec3::new(-40.0, -40.0, -6.0), max: Vec3::new(40.0, 40.0, -5.0) };

fn drawn(plan: &FramePlan) -> BTreeSet<u32> {
    let queried = plan.queried_draws.iter().map(|(leaf, _)| leaf.0);
    plan.draws.iter().map(|leaf| leaf.0).chain(queried).collect()
}

/// Moves the wall.
fn move_wall(walk: &mut Walk, wall: Aabb) {
    walk.hierarchy.refit([(ObjectId(0), wall)]).unwrap();
    walk.scene.bounds[0] = wall;
    walk.scene.solids[0] = wall;
}

#[test]
fn tests_that_are_too_dear_leave_frustum_culling() {
    let mut walk = Walk::cost_driven(city(&mut Random::new(3), 12), 2, DEAR_TESTS);
    let mut plain = Culler::new(CullConfig::default());
    let mut plan = FramePlan::default();
    let mut camera = Camera { eye: Vec3::new(-1.0, 1.7, 40.0), ..CAMERA };
    for frame in 0..120 {
        camera.forward = glam::Quat::from_rotation_y(0.05) * camera.forward;
        walk.step(&camera);
        let view = CullView::new(&camera, SIZE, 8);
        plain.plan(&walk.hierarchy, Strategy::FRUSTUM, &view, BUDGET, &mut plan);
        assert_eq!(drawn(&walk.plan), drawn(&plan), "frame {frame}");
        let stats = walk.plan.stats;
        assert!(walk.plan.tests.is_empty() && walk.plan.queried_draws.is_empty(), "{stats:?}");
        assert!(walk.is_exact(&camera), "frame {frame}");
    }
}

#[test]
fn tests_that_cost_nothing_are_all_made() {
    for seed in 0..20 {
        let boxes = city(&mut Random::new(seed), 10);
        let mut walk = Walk::cost_driven(boxes.clone(), 2, FREE_TESTS);
        let mut ungoverned = Walk::new(boxes, 2);
        let camera = Camera { eye: Vec3::new(-1.0, 1.7, 40.0), ..CAMERA };
        for frame in 0..60 {
            walk.step(&camera);
            ungoverned.step(&camera);
            let stats = walk.plan.stats;
            assert_eq!(stats.untested_by_cost, 0, "frame {frame} of seed {seed}: {stats:?}");
            assert!(walk.is_exact(&camera), "frame {frame} of seed {seed}");
        }
        assert_eq!(walk.device.drawn.len(), ungoverned.device.drawn.len());
        assert!(walk.plan.stats.expected_saving_ns > 0);
    }
}

#[test]
fn a_city_is_culled_with_costs_as_without() {
    let boxes = city(&mut Random::new(3), 40);
    let mut walk = Walk::cost_driven(boxes.clone(), 2, costs());
    let mut ungoverned = Walk::new(boxes, 2);
    let mut camera = Camera { eye: Vec3::new(-1.0, 1.7, 150.0), ..CAMERA };
    let mut sums = [0, 0];
    for frame in 0..120 {
        camera.eye.z -= 0.25;
        for (sum, walk) in sums.iter_mut().zip([&mut walk, &mut ungoverned]) {
            walk.step(&camera);
            assert!(walk.is_exact(&camera), "frame {frame}");
            *sum += walk.device.drawn.len();
        }
    }
    let [cost_driven, without] = sums;
    assert!(cost_driven * 4 < without * 5, "{cost_driven} drawn with costs, {without} without");
}

#[test]
fn where_nothing_hides_next_to_nothing_is_tested_until_a_wall_comes() {
    let mut walk = Walk::cost_driven(field(16), 2, costs());
    walk.steps(&CAMERA, 100);
    let visible = walk.plan.stats.visible;
    assert!(visible > 150, "{:?}", walk.plan.stats);
    let mut queries = 0;
    let mut tests = 0;
    let frames = 200;
    for frame in 0..frames {
        walk.step(&CAMERA);
        assert!(walk.is_exact(&CAMERA), "frame {frame}");
        queries += walk.plan.queried_draws.len();
        tests += walk.plan.tests.len();
    }
    let interval = walk.plan.stats.retest_interval_frames;
    println!(
        "{visible} visible, {queries} queries and {tests} tests in {frames} frames, {interval}"
    );
    assert!(queries > 0, "something must notice when the world changes");
    assert!(queries * 100 < frames * visible as usize * 2, "{queries} own draws of {visible}");
    assert!(tests * 100 < frames * visible as usize, "{tests} tests of {visible}");
    assert!(interval > 100, "{interval}");

    move_wall(&mut walk, WALL_HERE);
    let mut drawn = Vec::new();
    let mut resumed = None;
    for frame in 0..120 {
        walk.step(&CAMERA);
        assert!(walk.is_exact(&CAMERA), "frame {frame} after the wall");
        drawn.push(walk.device.drawn.len());
        if resumed.is_none() && walk.plan.stats.frontier > 0 {
            resumed = Some(frame);
        }
    }
    println!("resumed after {resumed:?}, drawn {drawn:?}");
    assert!(resumed.is_some_and(|frame| frame < 40), "{resumed:?} {drawn:?}");
    assert!(drawn[60] * 4 < visible as usize, "{drawn:?}");
    assert!(drawn[119] * 20 < visible as usize, "{drawn:?}");

    // Away again: objects that show again are drawn at once, and the tests end.
    move_wall(&mut walk, WALL_AWAY);
    walk.steps(&CAMERA, 400);
    assert!(walk.is_exact(&CAMERA));
    let stats = walk.plan.stats;
    assert!(stats.frontier * 20 < visible, "{stats:?}");
}

/// Checks a flight over a field, in which new objects come into view all the time.
#[test]
fn what_comes_into_view_is_drawn_at_once_where_nothing_hides() {
    let mut walk = Walk::cost_driven(field(60), 2, costs());
    let mut camera = CAMERA;
    let mut tests = 0;
    let mut frames_with_tests = 0;
    let mut drawn = 0;
    let mut in_frustum = 0;
    for frame in 0..300 {
        camera.eye.x += 0.25;
        walk.step(&camera);
        assert!(walk.is_exact(&camera), "frame {frame}");
        if frame >= 60 {
            tests += walk.plan.tests.len() + walk.plan.queried_draws.len();
            frames_with_tests += usize::from(!walk.plan.rounds.is_empty());
            drawn += walk.device.drawn.len();
            in_frustum += walk.count_in_frustum(&camera);
        }
    }
    println!(
        "{tests} tests, {frames_with_tests} frames with rounds, {drawn} of {in_frustum} drawn"
    );
    assert!(tests * 50 < in_frustum, "{tests} tests for {in_frustum} objects");
    assert!(frames_with_tests < 24, "{frames_with_tests} frames of 240 were broken for tests");
}

/// Checks a scene with some hidden objects in view that cost less to draw than the breaks of their
/// tests.
#[test]
fn where_less_hides_than_breaks_cost_frames_ask_seldom() {
    // A quarter of the objects stands behind others that hide them now and then.
    let behind = (0..66).map(|number| {
        let [column, row] = [number % 11 + 2, number / 11 + 2].map(|place| place as f32);
        let centre = Vec3::new((column - 7.5) * 2.5, (row - 5.0) * 2.5, -20.0) * 1.2;
        Aabb::new(centre - 0.3, centre + 0.3)
    });
    let boxes: Vec<Aabb> = field(16).into_iter().chain(behind).collect();
    let breaks = CostTable { break_ns: 900_000.0, break_wait_share: 0.2, ..costs() };
    let mut walk = Walk::cost_driven(boxes, 2, breaks);
    let mut camera = CAMERA;
    let mut testing = 0;
    let mut frames = 0;
    for frame in 0..400 {
        camera.eye.x = (frame as f32 * 0.2).sin() * 2.0;
        walk.step(&camera);
        assert!(walk.is_exact(&camera), "frame {frame}");
        if frame >= 100 {
            let plan = &walk.plan;
            testing += usize::from(!plan.tests.is_empty() || !plan.queried_draws.is_empty());
            frames += 1;
        }
    }
    println!("{testing} of {frames} frames test");
    assert!(testing > 0, "or nobody would notice more that hides");
    assert!(testing * 12 < frames, "{testing} of {frames} frames test");

    move_wall(&mut walk, WALL_HERE);
    walk.steps(&CAMERA, 120);
    assert!(walk.is_exact(&CAMERA));
    assert!(walk.device.drawn.len() < 20, "{} drawn", walk.device.drawn.len());
}

/// Checks that leaves behind a wall are still tested together if a test costs more than a draw.
#[test]
fn groups_pay_where_single_leaves_do_not() {
    let dear = CostTable { query_ns: 8_000.0, ..costs() };
    let mut walk = Walk::cost_driven(field(16), 2, dear);
    move_wall(&mut walk, WALL_HERE);
    walk.steps(&CAMERA, 300);
    assert!(walk.is_exact(&CAMERA));
    let stats = walk.plan.stats;
    assert!(walk.device.drawn.len() < 20, "{} drawn, {stats:?}", walk.device.drawn.len());
    assert!(stats.frontier > 0 && stats.tested_leaves / stats.frontier > 1, "{stats:?}");
}

#[test]
fn the_cheaper_tester_is_chosen_where_the_strategy_is_free() {
    let boxes = city(&mut Random::new(3), 10);
    let camera = Camera { eye: Vec3::new(-1.0, 1.7, 40.0), ..CAMERA };
    let free = CostTable { triangle_ns: 50.0, ..FREE_TESTS };
    let dear_queries = CostTable { query_ns: 50_000.0, ..free };
    let dear_flags = CostTable { flag_box_ns: 50_000.0, ..free };
    let cases = [
        (dear_queries, Strategy::ANTUMBRA, VisibilityTest::Flag),
        (dear_flags, Strategy::ANTUMBRA, VisibilityTest::Query),
        (dear_queries, Strategy::ANTUMBRA_QUERIES, VisibilityTest::Query),
        (dear_flags, Strategy::ANTUMBRA_FLAGS, VisibilityTest::Flag),
    ];
    for (table, strategy, expected) in cases {
        let walk = Walk::new(boxes.clone(), 1);
        let testers = VisibilityTestSupport { flags: true, ..Default::default() };
        let mut culler = Culler::with_testers(CullConfig::default(), testers);
        culler.set_costs(table, SceneCosts { triangles_per_leaf: 5_000.0 }).unwrap();
        let mut plan = FramePlan::default();
        let view = CullView::new(&camera, SIZE, 8);
        culler.plan(&walk.hierarchy, strategy, &view, BUDGET, &mut plan);
        assert!(!plan.tests.is_empty());
        let is_right = plan.tests.iter().all(|test| test.tester == expected);
        assert!(is_right, "{strategy} with {table:?}");
    }
}

#[test]
fn costs_that_cannot_be_are_refused_and_change_nothing() {
    let mut culler = Culler::new(CullConfig::default());
    let bad = CostTable { draw_ns: f32::NAN, ..CostTable::default() };
    assert!(culler.set_costs(bad, SceneCosts::default()).is_err());
    assert!(culler.learned_costs().is_none());
    culler.set_costs(CostTable::default(), SceneCosts::default()).unwrap();
    assert!(culler.set_costs(bad, SceneCosts::default()).is_err());
    assert_eq!(culler.learned_costs().unwrap().table(), CostTable::default());
}

#[test]
fn rounds_go_to_the_compute_shader_where_that_costs_least() {
    let free = CostTable { compute_round_ns: 0.0, compute_box_ns: 0.0, ..costs() };
    let dear = CostTable { compute_round_ns: 1.0e9, ..free };
    let all = VisibilityTestSupport {
        flags: true,
        compute: true,
        leaf_tests: true,
        ..Default::default()
    };
    let cases = [
        (free, all, true),
        (dear, all, false),
        (free, VisibilityTestSupport { compute: false, ..all }, false),
    ];
    for (table, testers, is_cheap) in cases {
        let mut walk = Walk::new(city(&mut Random::new(3), 12), 2);
        walk.culler = Culler::with_testers(CullConfig::default(), testers);
        walk.culler.set_costs(table, SceneCosts { triangles_per_leaf: 100.0 }).unwrap();
        let mut by_compute = 0;
        let mut others = 0;
        for step in 0..40 {
            walk.step(&Camera { eye: Vec3::new(-1.0, 1.7, 30.0 - step as f32 * 0.2), ..CAMERA });
            let computed = |test: &&ProxyTest| test.tester == VisibilityTest::Compute;
            by_compute += walk.plan.tests.iter().filter(computed).count();
            others += walk.plan.tests.iter().filter(|test| !computed(test)).count();
            let rounds = walk.plan.stats.rounds_by_compute;
            assert!(rounds as usize <= walk.plan.rounds.len());
            assert_eq!(rounds > 0, walk.plan.tests.iter().any(|test| computed(&test)));
        }
        assert!(
            if is_cheap { by_compute > others } else { by_compute == 0 },
            "{by_compute} {others}"
        );
    }
}
