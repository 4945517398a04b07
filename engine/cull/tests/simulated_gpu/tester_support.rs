//! Tests with missing or unreliable testers: plans do not use them, and images stay exact with the
//! others.

use antumbra_cull::{
    Camera, CullConfig, CullView, Culler, DrawPhases, Projection, SceneCosts, Strategy,
    VisibilityTest, VisibilityTestSupport,
};
use glam::Vec3;

use crate::device::Solids;
use crate::learned_costs::costs;
use crate::random::Random;
use crate::scene::city;
use crate::walk::{BUDGET, SIZE, Walk};

const CAMERA: Camera = Camera {
    eye: Vec3::new(-1.0, 1.7, 40.0),
    forward: Vec3::NEG_Z,
    up: Vec3::Y,
    projection: Projection::perspective(1.0),
    near: 0.1,
};

/// Returns true if `testers` includes a tester.
fn is_there(testers: VisibilityTestSupport, tester: VisibilityTest) -> bool {
    match tester {
        VisibilityTest::Query => testers.queries,
        VisibilityTest::Flag => testers.flags,
        VisibilityTest::Compute => testers.compute,
        VisibilityTest::SharedProxy(_) => true,
    }
}

/// Walks with these testers and checks each plan. Returns the number of tests.
fn walk(testers: VisibilityTestSupport, strategy: Strategy, measured: Option<SceneCosts>) -> usize {
    let mut walk = Walk::new(city(&mut Random::new(3), 10), 2);
    walk.culler = Culler::with_testers(CullConfig::default(), testers);
    if let Some(scene) = measured {
        walk.culler.set_costs(costs(), scene).unwrap();
    }
    let mut tests = 0;
    for step in 0..12 {
        let eye = Vec3::new(-1.0, 1.7, 30.0 - step as f32 * 0.3);
        let camera = Camera { eye, ..CAMERA };
        let view = CullView::new(&camera, SIZE, 8);
        let answers = walk.device.collect(walk.culler.frame().0 + 1, &walk.hierarchy);
        walk.culler.ingest(&walk.hierarchy, answers);
        walk.culler.plan(&walk.hierarchy, strategy, &view, BUDGET, &mut walk.plan);
        let plan = &walk.plan;
        assert!(plan.tests.iter().all(|test| is_there(testers, test.tester)), "{testers:?}");
        assert!(testers.queries || plan.query_count() == 0, "{testers:?} {strategy}");
        let solids = Solids { solids: &walk.scene.solids, shifts: &walk.scene.shifts };
        walk.device.execute(&view, &walk.hierarchy, &solids, &walk.plan);
        assert!(walk.is_exact(&camera), "{testers:?} {strategy}");
        tests += walk.plan.tests.len();
    }
    tests
}

#[test]
fn a_tester_that_is_not_there_tests_nothing_and_what_is_left_is_exact() {
    for bits in 0..16 {
        let has = |bit: u32| bits >> bit & 1 == 1;
        let phases = [DrawPhases::PerRound, DrawPhases::Two];
        let testers = VisibilityTestSupport {
            queries: has(0),
            flags: has(1),
            compute: has(2),
            leaf_tests: has(1) && has(3),
            draw_phases: phases[usize::from(has(3))],
        };
        for strategy in Strategy::PLANNED {
            let tests = walk(testers, strategy, None);
            let is_tested = strategy != Strategy::FRUSTUM && (has(0) || has(1) || has(2));
            assert_eq!(tests > 0, is_tested, "{testers:?} {strategy}");
            walk(testers, strategy, Some(SceneCosts { triangles_per_leaf: 100.0 }));
        }
    }
}
