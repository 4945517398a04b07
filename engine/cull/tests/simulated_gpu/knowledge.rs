//! Tests of the history: its states, their survival, and the answers that are ignored.

use antumbra_cull::{
    Aabb, Answer, Camera, CullConfig, CullTuning, CullView, Culler, FrameId, FramePlan, Generation,
    Hierarchy, NodeId, NodeState, ObjectId, QueryKind, QueryTag, Strategy,
};
use glam::Vec3;

use crate::random::Random;
use crate::scene::city;
use crate::walk::{BUDGET, SIZE, STREET, Walk, settled_city};

#[test]
fn a_rebuild_keeps_what_is_known_of_objects() {
    let mut walk = settled_city();
    let before = walk.plan.stats;
    assert_eq!(before.unknown, 0, "{before:?}");
    // One object more, and others moved, so the tree is another one.
    let mut boxes = walk.scene.bounds.clone();
    boxes.push(Aabb::new(Vec3::splat(500.0), Vec3::splat(501.0)));
    walk.hierarchy.rebuild(&boxes).unwrap();
    walk.scene = crate::scene::Scene::solid(boxes);
    walk.step(&STREET);
    let after = walk.plan.stats;
    // Little is known if an object outside of the frustum, never seen, is joined with a hidden one.
    assert!(after.unknown <= 2 && after.occluders == 0, "{after:?}");
    assert_eq!(after.visible, before.visible, "{before:?} {after:?}");
    assert!(after.frontier <= 4 * before.frontier + 8, "{before:?} {after:?}");
}

#[test]
fn forgetting_makes_everything_unknown() {
    let mut walk = settled_city();
    walk.culler.reset();
    assert!(
        (0..walk.hierarchy.node_count())
            .all(|node| { walk.culler.state(NodeId(node as u32)) == NodeState::Unknown })
    );
    walk.step(&STREET);
    let stats = walk.plan.stats;
    assert_eq!((stats.visible, stats.unknown), (0, stats.frontier));
    assert!(stats.occluders > 0);
}

#[test]
fn what_is_drawn_in_the_place_of_tests_is_known_when_its_answers_are_home() {
    let mut walk = Walk::new(city(&mut Random::new(5), 10), 2);
    walk.step(&STREET);
    let occluders = walk.plan.queried_draws.clone();
    let mut shown = Vec::new();
    for _ in 0..8 {
        walk.step(&STREET);
        let is_visible = |tag: &QueryTag| walk.culler.state(tag.node) == NodeState::Visible;
        shown.extend(occluders.iter().filter(|(_, tag)| is_visible(tag)).map(|(leaf, _)| *leaf));
        if !shown.is_empty() {
            break;
        }
    }
    assert!(shown.len() > 4, "{shown:?}");
    // If it were only tested, the largest object would hide nothing in the tests beside it.
    let stats = walk.plan.stats;
    assert!(stats.visible as usize >= shown.len() && stats.occluders == 0, "{stats:?}");
}

#[test]
fn an_answer_says_what_was_seen_when_it_was_asked_for() {
    let mut walk = Walk::new(city(&mut Random::new(5), 10), 12);
    walk.step(&STREET);
    walk.steps(&Camera { forward: Vec3::Z, ..STREET }, 11);
    // The answers are back by now, but they are stale.
    walk.step(&STREET);
    assert_eq!(walk.plan.stats.visible, 0, "{:?}", walk.plan.stats);
}

#[test]
fn late_answers_do_not_make_what_was_visited_since_look_older() {
    let mut walk = Walk::new(city(&mut Random::new(5), 10), 12);
    walk.steps(&STREET, 200);
    assert_eq!(walk.plan.stats.unknown, 0, "{:?}", walk.plan.stats);
    assert!(walk.plan.stats.visible > 2, "{:?}", walk.plan.stats);
}

/// Returns the state of every node.
fn states(culler: &Culler, hierarchy: &Hierarchy) -> Vec<NodeState> {
    let nodes = 0..hierarchy.node_count() as u32;
    nodes.map(|node| culler.state(NodeId(node))).collect()
}

#[test]
fn an_older_answer_does_not_hide_what_a_newer_one_showed() {
    let mut walk = settled_city();
    let generation = walk.hierarchy.generation();
    let nodes = (0..walk.hierarchy.node_count() as u32).map(NodeId);
    let mut leaves = nodes.filter(|node| walk.hierarchy.children(*node).is_none());
    let leaf = leaves.find(|leaf| walk.culler.state(*leaf) == NodeState::Visible).unwrap();
    let kind = QueryKind::VisibleDrawQuery;
    let answer = |frame, samples| {
        let tag = QueryTag { node: leaf, generation, frame, kind, sample_threshold: 0 };
        Answer { tag, samples }
    };
    let frame = walk.culler.frame();
    walk.culler.ingest(&walk.hierarchy, [answer(frame, 7)]);
    walk.culler.ingest(&walk.hierarchy, [answer(FrameId(frame.0 - 1), 0)]);
    assert_eq!(walk.culler.state(leaf), NodeState::Visible);
    walk.step(&STREET);
    walk.culler.ingest(&walk.hierarchy, [answer(walk.culler.frame(), 0)]);
    assert_eq!(walk.culler.state(leaf), NodeState::Hidden);
}

#[test]
fn answers_that_fit_nothing_are_ignored() {
    let mut walk = settled_city();
    let generation = walk.hierarchy.generation();
    let before = states(&walk.culler, &walk.hierarchy);
    let frame = walk.culler.frame();
    let tags = |node, generation, frame| {
        [QueryKind::Proxy, QueryKind::PullUpQuery, QueryKind::VisibleDrawQuery].map(|kind| {
            QueryTag { node: NodeId(node), generation, frame, kind, sample_threshold: 0 }
        })
    };
    let nodes = walk.hierarchy.node_count() as u32;
    for node in [0, 1, nodes / 2, nodes - 1, nodes, u32::MAX] {
        let foreign = tags(node, Generation(generation.0 + 1), frame);
        let future = tags(node, generation, FrameId(frame.0 + 1));
        let never = tags(node, generation, FrameId(0));
        let ancient = tags(nodes + 7, generation, FrameId(1));
        for tag in [foreign, future, never, ancient].concat() {
            for samples in [0, 7] {
                walk.culler.ingest(&walk.hierarchy, [Answer { tag, samples }]);
            }
        }
    }
    assert_eq!(states(&walk.culler, &walk.hierarchy), before);
}

/// Returns two boxes side by side, both tested in frame 1.
fn pair() -> (Culler, Hierarchy, Vec<QueryTag>) {
    let cube = |x| Aabb::new(Vec3::new(x, 0.0, -9.0), Vec3::new(x + 1.0, 1.0, -8.0));
    let hierarchy = Hierarchy::build(&[cube(-1.5), cube(0.5)]).unwrap();
    let mut culler = Culler::new(CullConfig {
        unknown_leaves: 1,
        tuning: CullTuning { unknown_leaves_far: 1, ..Default::default() },
        ..Default::default()
    });
    let tags = frame(&mut culler, &hierarchy);
    (culler, hierarchy, tags)
}

fn frame(culler: &mut Culler, hierarchy: &Hierarchy) -> Vec<QueryTag> {
    let camera = Camera { eye: Vec3::ZERO, ..STREET };
    let view = CullView::new(&camera, SIZE, 8);
    let mut plan = FramePlan::default();
    culler.plan(hierarchy, Strategy::ANTUMBRA, &view, BUDGET, &mut plan);
    plan.tests.iter().map(|test| test.tag).collect()
}

#[test]
fn an_older_answer_does_not_override_a_younger_one() {
    let (mut culler, hierarchy, first) = pair();
    let second = frame(&mut culler, &hierarchy);
    assert_eq!((first.len(), second.len()), (2, 2));
    let node = first[0].node;
    let later = second.iter().find(|tag| tag.node == node).unwrap();
    let answer = |tag: &QueryTag, samples| Answer { tag: *tag, samples };
    culler.ingest(&hierarchy, [answer(later, 0), answer(&first[0], 5)]);
    assert_eq!(culler.state(node), NodeState::Hidden);
    culler.ingest(&hierarchy, [answer(later, 5)]);
    assert_eq!(culler.state(node), NodeState::Hidden, "a frame answers once");
}

#[test]
fn visibility_is_pulled_up() {
    let (mut culler, hierarchy, tags) = pair();
    let root = hierarchy.root().unwrap();
    assert_eq!(culler.state(root), NodeState::Unknown);
    culler.ingest(&hierarchy, [Answer { tag: tags[0], samples: 1 }]);
    assert_eq!(culler.state(root), NodeState::Visible);
}

#[test]
fn hidden_siblings_are_tested_together_before_they_share_a_query() {
    let (mut culler, hierarchy, mut tags) = pair();
    let root = hierarchy.root().unwrap();
    let mut pulled_up = None;
    for _ in 0..60 {
        let answers = tags.iter().map(|tag| Answer { tag: *tag, samples: 0 });
        culler.ingest(&hierarchy, answers.collect::<Vec<_>>());
        tags = frame(&mut culler, &hierarchy);
        if tags.iter().any(|tag| tag.kind == QueryKind::PullUpQuery) {
            assert_eq!(tags.len(), 3, "the parts are tested beside the pull-up query");
            pulled_up = pulled_up.or(Some(culler.frame()));
        }
    }
    assert!(pulled_up.is_some());
    assert_eq!(culler.state(root), NodeState::Hidden);
    assert_eq!((tags.len(), tags[0].node), (1, root), "one query for both");
}

#[test]
fn a_lost_answer_is_asked_for_again() {
    let (mut culler, hierarchy, first) = pair();
    for _ in 0..10 {
        let again = frame(&mut culler, &hierarchy);
        let nodes = |tags: &[QueryTag]| tags.iter().map(|tag| tag.node).collect::<Vec<_>>();
        assert_eq!(nodes(&again), nodes(&first));
    }
}

#[test]
fn a_loose_proxy_backs_off() {
    let (mut culler, hierarchy, mut tags) = pair();
    let leaf = hierarchy.node_of(ObjectId(0)).unwrap();
    // The proxy always shows, but the object never does.
    let mut visible_draw_queries = 0;
    let camera = Camera { eye: Vec3::ZERO, ..STREET };
    let view = CullView::new(&camera, SIZE, 8);
    let mut plan = FramePlan::default();
    for _ in 0..1_000 {
        let answers = tags.iter().map(|tag| Answer {
            tag: *tag,
            samples: u32::from(tag.kind == QueryKind::Proxy || tag.node != leaf),
        });
        culler.ingest(&hierarchy, answers.collect::<Vec<_>>());
        culler.plan(&hierarchy, Strategy::ANTUMBRA, &view, BUDGET, &mut plan);
        let queried = plan.queried_draws.iter().map(|(_, tag)| *tag);
        tags = plan.tests.iter().map(|test| test.tag).chain(queried).collect();
        visible_draw_queries += tags
            .iter()
            .filter(|tag| tag.kind == QueryKind::VisibleDrawQuery && tag.node == leaf)
            .count();
    }
    assert!(
        (5..25).contains(&visible_draw_queries),
        "{visible_draw_queries} tests of visible draws in 1000 frames"
    );
}

#[test]
fn nothing_and_one_object_work() {
    for boxes in [vec![], vec![Aabb::new(Vec3::new(-1.0, 1.0, 9.0), Vec3::new(0.0, 2.0, 10.0))]] {
        let mut walk = Walk::new(boxes, 1);
        walk.steps(&STREET, 30);
        let plan = &walk.plan;
        let leaves = plan.draws.len() + plan.queried_draws.len() + plan.tests.len();
        assert_eq!(leaves, walk.scene.bounds.len());
    }
}
