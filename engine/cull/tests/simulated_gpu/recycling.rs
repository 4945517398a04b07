//! Tests of the history when nodes get another meaning: the parts that survive, and the parts that
//! must not.

use antumbra_cull::{
    Aabb, Answer, Batch, BlockingCuller, BlockingKind, Camera, ChcOptions, CullConfig, CullView,
    Culler, FramePlan, Hierarchy, LeafRange, NextAction, NodeId, NodeState, ObjectId, QueryKind,
    QueryTag, Strategy, TestAnswer,
};
use glam::Vec3;

use crate::random::Random;
use crate::scene::city;
use crate::walk::{BUDGET, SIZE, STREET, Walk, settled_city};

fn leaf_state(culler: &Culler, hierarchy: &Hierarchy, object: ObjectId) -> NodeState {
    culler.state(hierarchy.node_of(object).unwrap())
}

/// Returns an object whose leaf is in a state.
fn an_object(walk: &Walk, state: NodeState) -> ObjectId {
    let objects = walk.hierarchy.leaf_objects().iter().copied();
    let mut found = objects.filter(|o| leaf_state(&walk.culler, &walk.hierarchy, *o) == state);
    found.next().expect("an object in this state")
}

/// Plans a frame for the hierarchy and ignores the plan.
fn plan_once(culler: &mut Culler, hierarchy: &Hierarchy) {
    let view = CullView::new(&STREET, SIZE, 8);
    culler.plan(hierarchy, Strategy::ANTUMBRA, &view, BUDGET, &mut FramePlan::default());
}

#[test]
fn a_recycled_id_inherits_neither_history_nor_answers() {
    for state in [NodeState::Visible, NodeState::Hidden] {
        let mut walk = settled_city();
        let old = an_object(&walk, state);
        let node = walk.hierarchy.node_of(old).unwrap();
        let before = QueryTag {
            node,
            generation: walk.hierarchy.generation(),
            frame: walk.culler.frame(),
            kind: QueryKind::VisibleDrawQuery,
            sample_threshold: 0,
        };
        let far_away = Aabb::new(Vec3::splat(300.0), Vec3::splat(301.0));
        walk.hierarchy.remove(old).unwrap();
        let new = walk.hierarchy.insert(far_away).unwrap();
        assert_eq!(new, old, "the only free id");
        for samples in [0, 9] {
            walk.culler.ingest(&walk.hierarchy, [Answer { tag: before, samples }]);
            assert_eq!(walk.culler.state(node), NodeState::Unknown);
        }
        // Tests count from now on.
        plan_once(&mut walk.culler, &walk.hierarchy);
        let after = QueryTag {
            generation: walk.hierarchy.generation(),
            frame: walk.culler.frame(),
            ..before
        };
        walk.culler.ingest(&walk.hierarchy, [Answer { tag: after, samples: 3 }]);
        assert_eq!(walk.culler.state(node), NodeState::Visible);
    }
}

#[test]
fn answers_about_other_nodes_count_across_a_recycling() {
    let mut walk = settled_city();
    let gone = an_object(&walk, NodeState::Hidden);
    let other = an_object(&walk, NodeState::Visible);
    let tag = QueryTag {
        node: walk.hierarchy.node_of(other).unwrap(),
        generation: walk.hierarchy.generation(),
        frame: walk.culler.frame(),
        kind: QueryKind::VisibleDrawQuery,
        sample_threshold: 0,
    };
    let bounds = walk.hierarchy.bounds(walk.hierarchy.node_of(gone).unwrap());
    walk.hierarchy.remove(gone).unwrap();
    walk.hierarchy.insert(bounds).unwrap();
    walk.culler.ingest(&walk.hierarchy, [Answer { tag, samples: 0 }]);
    assert_eq!(leaf_state(&walk.culler, &walk.hierarchy, other), NodeState::Hidden);
}

/// Moves the objects around the camera until a part of the tree with a visible object is rebuilt,
/// and returns this part.
fn mingle(walk: &mut Walk, states: &[NodeState]) -> LeafRange {
    let count = walk.scene.bounds.len();
    let mut reordered = Vec::new();
    let mut random = Random::new(9);
    let is_near = |o: &usize| walk.scene.bounds[*o].distance_squared(STREET.eye) < 400.0;
    let some: Vec<usize> = (0..count).filter(is_near).collect();
    let is_seen = |walk: &Walk, part: &LeafRange| {
        let mut objects = walk.hierarchy.leaf_objects()[part.indices()].iter();
        objects.any(|object| states[object.0 as usize] == NodeState::Visible)
    };
    for _ in 0..100 {
        for object in &some {
            let offset = random.point(-6.0, 6.0).with_y(0.0);
            let bounds = walk.scene.bounds[*object];
            let moved = Aabb::new(bounds.min + offset, bounds.max + offset);
            walk.scene.bounds[*object] = moved;
            walk.scene.solids[*object] = moved;
            walk.hierarchy.refit([(ObjectId(*object as u32), moved)]).unwrap();
        }
        walk.hierarchy.rebuild_subtrees(&mut reordered);
        let is_fit = |part: &&LeafRange| (part.count as usize) < count && is_seen(walk, part);
        if let Some(part) = reordered.iter().find(is_fit) {
            return *part;
        }
        reordered.clear();
    }
    panic!("no part was rebuilt");
}

fn is_under_hidden(walk: &Walk, object: ObjectId) -> bool {
    let mut above = walk.hierarchy.parent(walk.hierarchy.node_of(object).unwrap());
    while let Some(node) = above {
        if walk.culler.state(node) == NodeState::Hidden {
            return true;
        }
        above = walk.hierarchy.parent(node);
    }
    false
}

/// Returns the state of each object.
fn states(walk: &Walk) -> Vec<NodeState> {
    let objects = (0..walk.scene.bounds.len()).map(|object| ObjectId(object as u32));
    objects.map(|object| leaf_state(&walk.culler, &walk.hierarchy, object)).collect()
}

/// Checks a small hierarchy, which is rebuilt as a whole, and a larger one, whose last part is
/// rebuilt.
#[test]
fn a_hierarchy_that_grows_keeps_what_is_known_of_objects() {
    for (side, is_rebuilt) in [(10, true), (30, false)] {
        let mut walk = Walk::new(city(&mut Random::new(5), side), 2);
        walk.steps(&STREET, 80);
        let before = states(&walk);
        let count = before.len();
        let was_under_hidden: Vec<bool> =
            (0..count).map(|object| is_under_hidden(&walk, ObjectId(object as u32))).collect();
        let generation = walk.hierarchy.generation();
        let root = walk.hierarchy.root().unwrap();
        // Before the eye, where the object shows.
        let new = cube(STREET.eye + STREET.forward * 3.0, 0.1);
        let mut added = Vec::new();
        walk.hierarchy.insert_all(&[new], &mut added, &mut Vec::new()).unwrap();
        assert_eq!(added, [ObjectId(count as u32)]);
        assert_eq!(walk.hierarchy.is_same_since(root, generation), !is_rebuilt, "{count} objects");
        walk.culler.ingest(&walk.hierarchy, []);
        assert_eq!(leaf_state(&walk.culler, &walk.hierarchy, added[0]), NodeState::Unknown);
        for (object, (before, after)) in before.iter().zip(states(&walk)).enumerate() {
            let was_under_hidden = was_under_hidden[object] && after == NodeState::Hidden;
            assert!(*before == after || was_under_hidden, "object {object}: {before:?}, {after:?}");
        }
        assert!(before.contains(&NodeState::Visible));
        walk.scene.bounds.push(new);
        walk.scene.bounds.resize(walk.hierarchy.leaf_objects().len(), Aabb::EMPTY);
        walk.scene = crate::scene::Scene::solid(walk.scene.bounds.clone());
        for _ in 0..5 {
            walk.step(&STREET);
            assert!(walk.is_exact(&STREET));
        }
    }
}

#[test]
fn a_rebuilt_part_keeps_what_is_known_of_objects() {
    let mut walk = settled_city();
    let before = states(&walk);
    let was_under_hidden: Vec<bool> =
        (0..before.len()).map(|object| is_under_hidden(&walk, ObjectId(object as u32))).collect();
    let generation = walk.hierarchy.generation();
    let inside = mingle(&mut walk, &before);
    assert!(walk.hierarchy.generation() > generation);
    walk.culler.ingest(&walk.hierarchy, []);
    let after = states(&walk);
    let mut carried = 0;
    for (object, (before, after)) in before.iter().zip(&after).enumerate() {
        let leaf = walk.hierarchy.leaf_of(ObjectId(object as u32)).unwrap();
        // Leaves under a hidden node are not kept up to date, so they take the state of the node.
        let is_kept = before == after || (was_under_hidden[object] && *after == NodeState::Hidden);
        assert!(is_kept, "object {object}: {before:?} became {after:?}");
        carried += u32::from(inside.contains(leaf) && *after == NodeState::Visible);
    }
    assert!(carried > 0, "the part held something visible");
    // Earlier answers are ignored for nodes of the rebuilt part, and only for them.
    let nodes = (0..walk.hierarchy.node_count() as u32).map(NodeId);
    for node in nodes {
        let leaves = walk.hierarchy.leaves(node);
        let is_inside = inside.contains(leaves.first) && leaves.count <= inside.count;
        if is_inside {
            assert!(!walk.hierarchy.is_same_since(node, generation), "{node:?}");
        }
    }
    let root = walk.hierarchy.root().unwrap();
    assert!(walk.hierarchy.is_same_since(root, generation), "the rest is what it was");
    walk.steps(&STREET, 3);
    assert!(walk.is_exact(&STREET));
}

#[test]
fn a_culler_that_paused_for_long_starts_from_nothing() {
    let mut walk = settled_city();
    let object = ObjectId(0);
    let bounds = walk.scene.bounds[0];
    let mut present = walk.culler_clone_that_follows();
    for _ in 0..20_000 {
        walk.hierarchy.remove(object).unwrap();
        walk.hierarchy.insert(bounds).unwrap();
        present.ingest(&walk.hierarchy, []);
    }
    walk.culler.ingest(&walk.hierarchy, []);
    let known = |culler: &Culler| {
        let nodes = 0..walk.hierarchy.node_count() as u32;
        nodes.filter(|node| culler.state(NodeId(*node)) != NodeState::Unknown).count()
    };
    assert_eq!(known(&walk.culler), 0);
    assert!(known(&present) > 10, "who keeps up keeps what it knows");
    walk.step(&STREET);
    assert!(walk.is_exact(&STREET));
}

#[test]
fn another_hierarchy_is_not_taken_for_the_first() {
    let mut walk = settled_city();
    walk.hierarchy = Hierarchy::build(&walk.scene.bounds).unwrap();
    walk.culler.ingest(&walk.hierarchy, []);
    let nodes = 0..walk.hierarchy.node_count() as u32;
    assert!(nodes.map(NodeId).all(|node| walk.culler.state(node) == NodeState::Unknown));
}

impl Walk {
    /// Returns the culler of a second view with the same history.
    fn culler_clone_that_follows(&self) -> Culler {
        let mut twin = Self {
            scene: crate::scene::Scene::solid(self.scene.bounds.clone()),
            hierarchy: self.hierarchy.clone(),
            culler: Culler::new(CullConfig::default()),
            device: crate::device::Device::new(SIZE, 8, crate::device::Mishaps::none(2), 1),
            plan: FramePlan::default(),
        };
        twin.steps(&STREET, 80);
        twin.culler
    }
}

/// Returns a cube around a point, with `half` of its side.
fn cube(centre: Vec3, half: f32) -> Aabb {
    Aabb::new(centre - Vec3::splat(half), centre + Vec3::splat(half))
}

#[test]
fn next_frame_knows_nothing_of_who_comes_under_an_old_id() {
    let camera = Camera { eye: Vec3::ZERO, ..STREET };
    let view = CullView::new(&camera, SIZE, 8);
    let screen = cube(Vec3::new(0.0, 0.0, -5.0), 1.0);
    let mut hierarchy = Hierarchy::build(&[screen, cube(Vec3::NEG_Z * 50.0, 1.0)]).unwrap();
    let mut culler = Culler::new(CullConfig::default());
    let mut plan = FramePlan::default();
    let hidden = hierarchy.node_of(ObjectId(1)).unwrap();
    let is_drawn = |plan: &FramePlan, hierarchy: &Hierarchy| {
        let leaf = hierarchy.leaf_of(ObjectId(1)).unwrap();
        plan.draws.contains(&leaf) || plan.queried_draws.iter().any(|(drawn, _)| *drawn == leaf)
    };
    for _ in 0..20 {
        culler.plan_next_frame(&hierarchy, &view, &mut plan);
        let tags: Vec<QueryTag> = plan.tests.iter().map(|test| test.tag).collect();
        let tags = tags.into_iter().chain(plan.queried_draws.iter().map(|(_, tag)| *tag));
        let answer = |tag: QueryTag| Answer { tag, samples: u32::from(tag.node != hidden) };
        culler.ingest(&hierarchy, tags.map(answer));
    }
    assert!(!is_drawn(&plan, &hierarchy), "what is hidden is not drawn");
    hierarchy.remove(ObjectId(1)).unwrap();
    let new = hierarchy.insert(cube(Vec3::new(0.5, 0.5, -3.0), 0.2)).unwrap();
    assert_eq!(new, ObjectId(1), "the only free id");
    culler.plan_next_frame(&hierarchy, &view, &mut plan);
    assert!(is_drawn(&plan, &hierarchy), "nobody has seen the new one hidden");
}

#[test]
fn coherent_knows_nothing_of_who_comes_under_an_old_id() {
    let camera = Camera { eye: Vec3::ZERO, ..STREET };
    let view = CullView::new(&camera, SIZE, 8);
    let near = cube(Vec3::new(0.0, 0.0, -5.0), 1.0);
    let mut hierarchy = Hierarchy::build(&[near, cube(Vec3::new(3.0, 0.0, -50.0), 1.0)]).unwrap();
    let mut blocking = BlockingCuller::new(BlockingKind::Chc(ChcOptions::default()));
    // Returns the number of tests of a frame in which everything shows.
    let mut tests = |hierarchy: &Hierarchy| {
        let mut conversation = blocking.begin(hierarchy, &view);
        let mut batch = Batch::default();
        let mut answers = Vec::new();
        while conversation.next(&answers, &mut batch) != NextAction::Done {
            let drawn = batch.draws.iter().filter_map(|draw| draw.token);
            let tokens = batch.tests.iter().map(|test| test.token).chain(drawn);
            answers = tokens.map(|token| TestAnswer { token, samples: 9 }).collect();
        }
        conversation.stats().boxes + conversation.stats().visible_draw_queries
    };
    tests(&hierarchy);
    assert_eq!(tests(&hierarchy), 0, "what was seen is assumed to be visible");
    hierarchy.remove(ObjectId(1)).unwrap();
    let new = hierarchy.insert(cube(Vec3::new(0.0, 0.0, -60.0), 0.2)).unwrap();
    assert_eq!(new, ObjectId(1), "the only free id");
    assert!(tests(&hierarchy) > 0, "nobody has seen the new one");
}
