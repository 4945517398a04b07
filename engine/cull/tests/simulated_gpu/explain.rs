//! Tests that explanations agree with the draws.

use antumbra_cull::{
    Camera, CullConfig, CullView, Culler, Decision, FrameId, NodeState, ObjectId, Outcome,
    Projection, QueryKind, Strategy, VisibilityTestSupport,
};
use glam::Vec3;

use crate::random::Random;
use crate::scene::city;
use crate::walk::{SIZE, Walk};

fn camera(frame: usize) -> Camera {
    let angle = frame as f32 * 0.02;
    Camera {
        eye: Vec3::new(-1.0, 1.7, 30.0 - frame as f32 * 0.1),
        forward: Vec3::new(angle.sin(), 0.0, -angle.cos()),
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.1,
    }
}

/// Checks for every object in every frame of a walk that it is drawn if and only if the explanation
/// says so.
#[test]
fn every_object_was_drawn_as_explained() {
    let leaf_tests = VisibilityTestSupport { flags: true, leaf_tests: true, ..Default::default() };
    for testers in [VisibilityTestSupport::default(), leaf_tests] {
        let mut walk = Walk::new(city(&mut Random::new(5), 10), 2);
        walk.culler = Culler::with_testers(CullConfig::default(), testers);
        let seen = explain_walk(&mut walk);
        assert!(seen.iter().all(|count| *count > 20), "{testers:?}: every case was met: {seen:?}");
    }
}

/// Walks and counts the explanations: outside, drawn, drawn and tested, hidden individually and in
/// a group, revealed.
fn explain_walk(walk: &mut Walk) -> [usize; 6] {
    let mut seen = [0_usize; 6];
    for frame in 0..150 {
        walk.step(&camera(frame));
        let view = CullView::new(&camera(frame), SIZE, 8);
        let answers = walk.device.answers_of(walk.plan.frame, &walk.hierarchy);
        for object in 0..walk.scene.bounds.len() as u32 {
            let explained =
                walk.culler.explain(&walk.hierarchy, &view, &walk.plan, ObjectId(object)).unwrap();
            let outcome = explained.outcome(&walk.hierarchy, &answers);
            let (is_drawn, kind) = match (explained.decision, outcome) {
                (Decision::Outside, None) => (false, 0),
                (Decision::Drawn, None) => (true, 1),
                (Decision::DrawnAndTested | Decision::DrawnAndBoxTested { .. }, None) => (true, 2),
                (Decision::Tested { leaves, .. }, Some(Outcome::Hidden)) => {
                    (false, 3 + usize::from(leaves > 1))
                }
                (Decision::Tested { .. }, Some(Outcome::Revealed)) => (true, 5),
                other => panic!("object {object} in frame {frame}: {other:?}"),
            };
            seen[kind] += 1;
            let was_drawn = walk.device.drawn.contains(&object);
            assert_eq!(was_drawn, is_drawn, "object {object} in frame {frame}: {explained:?}");
        }
    }
    seen
}

#[test]
fn it_says_since_when_and_when_it_was_asked() {
    let mut walk = Walk::new(city(&mut Random::new(5), 10), 2);
    walk.steps(&camera(0), 100);
    let view = CullView::new(&camera(0), SIZE, 8);
    let explain = |walk: &Walk, object| {
        walk.culler.explain(&walk.hierarchy, &view, &walk.plan, ObjectId(object))
    };
    assert_eq!(explain(&walk, 1_000_000), None);
    let mut visible = 0;
    let mut grouped = 0;
    for object in 0..walk.scene.bounds.len() as u32 {
        let explained = explain(&walk, object).unwrap();
        assert_eq!((explained.frame, explained.object), (FrameId(100), ObjectId(object)));
        assert_eq!(explained.bounds, walk.scene.bounds[object as usize]);
        let history = explained.history;
        match explained.decision {
            Decision::Drawn if history.state == NodeState::Visible => {
                visible += 1;
                let since = history.since.unwrap();
                let answered = history.answered.unwrap();
                assert!(since <= answered && answered <= FrameId(98), "{explained:?}");
                assert!(history.next_test.is_some(), "{explained:?}");
            }
            Decision::Tested { leaves, kind, history, .. } if leaves > 1 => {
                grouped += 1;
                assert_eq!((kind, history.state), (QueryKind::Proxy, NodeState::Hidden));
                // The camera stood still: the object was tested in every frame, and the answer is
                // two frames old.
                assert_eq!(history.answered, Some(FrameId(98)), "{explained:?}");
                assert!(history.since < history.answered, "{explained:?}");
            }
            _ => {}
        }
    }
    assert!(visible > 2 && grouped > 10, "{visible} {grouped}");
}

#[test]
fn without_culling_all_is_drawn_or_outside() {
    let mut walk = Walk::new(city(&mut Random::new(5), 10), 2);
    let view = CullView::new(&camera(0), SIZE, 8);
    let budget = CullConfig::default().unknown_leaves as usize;
    let hierarchy = &walk.hierarchy;
    let strategy = Strategy::FRUSTUM;
    walk.culler.plan(hierarchy, strategy, &view, budget, &mut walk.plan);
    let decision = |object| {
        walk.culler.explain(hierarchy, &view, &walk.plan, ObjectId(object)).unwrap().decision
    };
    let count = walk.scene.bounds.len() as u32;
    let drawn = (0..count).filter(|object| decision(*object) == Decision::Drawn).count();
    let outside = (0..count).filter(|object| decision(*object) == Decision::Outside).count();
    assert_eq!((drawn, drawn + outside), (walk.plan.draws.len(), count as usize));
}
