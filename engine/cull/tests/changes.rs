//! Tests of a hierarchy whose objects move, are removed and are inserted: it is always well formed
//! and tight, at a cost in proportion to the changes.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use antumbra_cull::{
    Aabb, BoxChange, Hierarchy, HierarchyError, LeafIndex, LeafRange, NodeId, ObjectId,
};
use glam::Vec3;
use proptest::prelude::*;

/// Checks that every node is tight around the boxes of its leaves, and that subtrees are
/// contiguous.
fn check(hierarchy: &Hierarchy, boxes: &[Aabb]) {
    assert_eq!(hierarchy.node_count(), 2 * boxes.len() - 1);
    for (object, bounds) in boxes.iter().enumerate() {
        let object = ObjectId(object as u32);
        assert_eq!(hierarchy.bounds(hierarchy.node_of(object).unwrap()), *bounds);
        let leaf = hierarchy.leaf_of(object).unwrap();
        assert_eq!(hierarchy.leaf_objects()[leaf.0 as usize], object);
    }
    let free = boxes.iter().filter(|bounds| bounds.is_empty()).count();
    assert_eq!(hierarchy.free_leaves(), free);
    for node in (0..hierarchy.node_count() as u32).map(NodeId) {
        let range = hierarchy.leaves(node);
        let Some([left, right]) = hierarchy.children(node) else {
            assert_eq!(range.count, 1);
            continue;
        };
        let union = hierarchy.bounds(left).union(&hierarchy.bounds(right));
        assert_eq!(hierarchy.bounds(node), union);
        let [first, second] = [left, right].map(|child| hierarchy.leaves(child));
        assert_eq!(first.first, range.first);
        assert_eq!(second.first, LeafIndex(first.first.0 + first.count));
        assert_eq!(first.count + second.count, range.count);
        for child in [left, right] {
            assert_eq!(hierarchy.parent(child), Some(node));
            assert_eq!(hierarchy.level(child), hierarchy.level(node) + 1);
        }
    }
}

fn any_box() -> impl Strategy<Value = Aabb> {
    ([-60.0_f32..60.0, -60.0..60.0, -60.0..60.0], [0.0_f32..9.0, 0.0..9.0, 0.0..9.0]).prop_map(
        |(min, size)| {
            Aabb::new(Vec3::from_array(min), Vec3::from_array(min) + Vec3::from_array(size))
        },
    )
}

#[derive(Clone, Debug)]
enum NextAction {
    Move(prop::sample::Index, Aabb),
    Remove(prop::sample::Index),
    Insert(Aabb),
    InsertAll(Vec<Aabb>),
    Restructure,
    Rebuild,
}

fn step() -> impl Strategy<Value = NextAction> {
    let index = any::<prop::sample::Index>;
    prop_oneof![
        5 => (index(), any_box()).prop_map(|(index, target)| NextAction::Move(index, target)),
        3 => index().prop_map(NextAction::Remove),
        3 => any_box().prop_map(NextAction::Insert),
        2 => prop::collection::vec(any_box(), 0..20).prop_map(NextAction::InsertAll),
        3 => Just(NextAction::Restructure),
        1 => Just(NextAction::Rebuild),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 500,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn whatever_happens_the_tree_is_well_formed_and_tight(
        mut boxes in prop::collection::vec(
            prop_oneof![4 => any_box(), 1 => Just(Aabb::EMPTY)], 1..50,
        ),
        steps in prop::collection::vec(step(), 1..40),
    ) {
        let mut hierarchy = Hierarchy::build(&boxes).unwrap();
        check(&hierarchy, &boxes);
        for step in steps {
            match step {
                NextAction::Move(index, target) => {
                    let object = ObjectId(index.index(boxes.len()) as u32);
                    let there = &mut boxes[object.0 as usize];
                    let outcome = hierarchy.refit([(object, target)]);
                    if there.is_empty() {
                        prop_assert_eq!(outcome, Err(HierarchyError::UnknownObject { object }));
                    } else {
                        *there = target;
                    }
                }
                NextAction::Remove(index) => {
                    let object = ObjectId(index.index(boxes.len()) as u32);
                    let outcome = hierarchy.remove(object);
                    prop_assert_eq!(outcome.is_ok(), !boxes[object.0 as usize].is_empty());
                    boxes[object.0 as usize] = Aabb::EMPTY;
                }
                NextAction::Insert(bounds) => {
                    let before = hierarchy.generation();
                    match hierarchy.insert(bounds) {
                        Ok(object) => {
                            prop_assert!(boxes[object.0 as usize].is_empty());
                            boxes[object.0 as usize] = bounds;
                            let node = hierarchy.node_of(object).unwrap();
                            prop_assert!(!hierarchy.is_same_since(node, before));
                            let now = hierarchy.generation();
                            prop_assert!(hierarchy.is_same_since(node, now));
                        }
                        Err(error) => {
                            prop_assert_eq!(error, HierarchyError::NoFreeLeaf);
                            prop_assert!(boxes.iter().all(|bounds| !bounds.is_empty()));
                        }
                    }
                }
                NextAction::InsertAll(new) => {
                    let mut added = Vec::new();
let mut reordered = Vec::new();
                    let before = hierarchy.leaf_objects().to_vec();
                    let generation = hierarchy.generation();
                    hierarchy.insert_all(&new, &mut added, &mut reordered).unwrap();
                    prop_assert_eq!(added.len(), new.len());
                    boxes.resize(hierarchy.leaf_objects().len(), Aabb::EMPTY);
                    for (object, bounds) in added.iter().zip(new) {
                        prop_assert!(boxes[object.0 as usize].is_empty());
                        boxes[object.0 as usize] = bounds;
                        prop_assert!(!hierarchy.is_same_object_since(*object, generation));
                    }
                    for (leaf, object) in hierarchy.leaf_objects().iter().enumerate() {
                        let leaf = LeafIndex(leaf as u32);
                        let is_told = reordered.iter().any(|range| range.contains(leaf));
                        prop_assert!(is_told || before.get(leaf.0 as usize) == Some(object));
                    }
                }
                NextAction::Restructure => hierarchy.rebuild_subtrees(&mut Vec::new()),
                NextAction::Rebuild => {
                    hierarchy.rebuild(&boxes).unwrap();
                }
            }
            check(&hierarchy, &boxes);
        }
    }
}

/// Returns a grid of small boxes in rows of 64.
fn grid(count: usize) -> Vec<Aabb> {
    (0..count)
        .map(|number| {
            let corner = Vec3::new((number % 64) as f32, 0.0, (number / 64) as f32) * 4.0;
            Aabb::new(corner, corner + 1.0)
        })
        .collect()
}

fn lifted(bounds: &Aabb, height: f32) -> Aabb {
    Aabb::new(bounds.min + Vec3::Y * height, bounds.max + Vec3::Y * height)
}

#[test]
fn a_refit_touches_the_ancestors_of_what_moved_and_no_more() {
    for count in [1_000_usize, 10_000, 100_000] {
        let boxes = grid(count);
        let mut hierarchy = Hierarchy::build(&boxes).unwrap();
        let levels = count.ilog2() as u64;
        for moved in [1_usize, 10, 100] {
            let before = hierarchy.work();
            let step = count / moved;
            let moves =
                (0..moved).map(|n| (ObjectId((n * step) as u32), lifted(&boxes[n * step], 0.1)));
            hierarchy.refit(moves).unwrap();
            let work = hierarchy.work();
            assert_eq!(work.placed_leaves - before.placed_leaves, moved as u64);
            let refitted = work.refitted_nodes - before.refitted_nodes;
            assert!(refitted <= moved as u64 * 2 * levels, "{refitted} of {moved} in {count}");
        }
        let before = hierarchy.work();
        let object = ObjectId(7);
        hierarchy.remove(object).unwrap();
        hierarchy.insert(boxes[7]).unwrap();
        assert!(hierarchy.work().refitted_nodes - before.refitted_nodes <= 4 * levels);
    }
}

/// Returns the areas of all inner nodes over the area of the root: the cost of a ray or a frustum.
fn cost(hierarchy: &Hierarchy) -> f32 {
    let inner = (0..hierarchy.node_count() as u32)
        .map(NodeId)
        .filter(|node| hierarchy.children(*node).is_some());
    let areas: f32 = inner.map(|node| hierarchy.bounds(node).half_area()).sum();
    areas / hierarchy.bounds(NodeId(0)).half_area()
}

#[test]
fn worn_parts_are_rebuilt_a_bounded_number_of_leaves_at_a_time() {
    let mut boxes = grid(40_000);
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    let good = cost(&hierarchy);
    // Under each of twenty nodes the objects swap positions.
    let seats = boxes.clone();
    let nodes = (0..hierarchy.node_count() as u32).map(NodeId);
    let parts = nodes.map(|node| hierarchy.leaves(node)).filter(|l| (200..400).contains(&l.count));
    for part in parts.step_by(5).take(20) {
        let objects = &hierarchy.leaf_objects()[part.indices()];
        for (number, object) in objects.iter().enumerate() {
            let other = objects[(number * 77 + 5) % objects.len()];
            boxes[object.0 as usize] = seats[other.0 as usize];
        }
    }
    let moved = boxes.iter().enumerate().map(|(o, bounds)| (ObjectId(o as u32), *bounds));
    hierarchy.refit(moved).unwrap();
    let worn = cost(&hierarchy);
    assert!(worn > 1.1 * good, "{good} {worn}");
    let mut reordered: Vec<LeafRange> = Vec::new();
    let mut updates = 0;
    loop {
        let before = hierarchy.work().rebuilt_leaves;
        reordered.clear();
        hierarchy.rebuild_subtrees(&mut reordered);
        let rebuilt = hierarchy.work().rebuilt_leaves - before;
        assert!(rebuilt <= 1024, "{rebuilt} leaves at once");
        assert_eq!(rebuilt, reordered.iter().map(|range| u64::from(range.count)).sum::<u64>());
        updates += 1;
        if rebuilt == 0 || updates > 200 {
            break;
        }
    }
    let mended = cost(&hierarchy);
    println!("good {good}, worn {worn}, mended {mended} after {updates} updates");
    assert!(mended < good + 0.3 * (worn - good), "{good} {worn} {mended}");
    assert!((2..200).contains(&updates), "{updates}: it comes to rest");
    check(&hierarchy, &boxes);
}

#[test]
fn a_worn_whole_is_rebuilt_if_it_is_small() {
    let mut boxes = grid(3_000);
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    let good = cost(&hierarchy);
    let seats = boxes.clone();
    for number in 0..3_000 {
        boxes[number] = seats[number * 1_009 % 3_000];
    }
    let moved = boxes.iter().enumerate().map(|(o, bounds)| (ObjectId(o as u32), *bounds));
    hierarchy.refit(moved).unwrap();
    assert!(hierarchy.is_degraded());
    let mut reordered = Vec::new();
    hierarchy.rebuild_subtrees(&mut reordered);
    assert_eq!(reordered, [hierarchy.leaves(NodeId(0))]);
    assert!(!hierarchy.is_degraded() && cost(&hierarchy) < 1.1 * good);
    check(&hierarchy, &boxes);
}

#[test]
fn who_comes_gets_the_leaf_that_fits_so_that_coming_and_going_wears_nothing() {
    let mut boxes = grid(3_000);
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    let good = cost(&hierarchy);
    let mut away: Vec<Aabb> = Vec::new();
    for round in 0..2_000_usize {
        let object = round * 1_237 % 3_000;
        if !boxes[object].is_empty() {
            hierarchy.remove(ObjectId(object as u32)).unwrap();
            away.push(std::mem::replace(&mut boxes[object], Aabb::EMPTY));
        }
        if away.len() > 20 {
            let bounds = away.swap_remove(round * 7 % away.len());
            let object = hierarchy.insert(bounds).unwrap();
            boxes[object.0 as usize] = bounds;
        }
    }
    check(&hierarchy, &boxes);
    assert!(
        cost(&hierarchy) < 1.1 * good && !hierarchy.is_degraded(),
        "{good} {}",
        cost(&hierarchy)
    );
}

#[test]
fn a_free_leaf_is_found_however_many_there_are() {
    let mut boxes = grid(20_000);
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    for object in (0..20_000).step_by(2) {
        hierarchy.remove(ObjectId(object)).unwrap();
        boxes[object as usize] = Aabb::EMPTY;
    }
    // At such a distance no leaf fits better than another.
    for number in 0..500 {
        let bounds = lifted(&grid(500)[number], 1.0e6);
        let object = hierarchy.insert(bounds).unwrap();
        assert!(boxes[object.0 as usize].is_empty());
        boxes[object.0 as usize] = bounds;
    }
    check(&hierarchy, &boxes);
}

#[test]
fn an_id_is_told_from_the_same_id_of_another_object() {
    let boxes = grid(60);
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    let stays = ObjectId(5);
    let goes = ObjectId(30);
    let before = hierarchy.generation();
    assert!(hierarchy.is_same_object_since(goes, before));
    hierarchy.remove(goes).unwrap();
    assert!(!hierarchy.is_same_object_since(goes, before), "it is gone");
    let came = hierarchy.insert(boxes[30]).unwrap();
    assert_eq!(came, goes);
    let between = hierarchy.generation();
    // The object gets another leaf, but keeps its id.
    hierarchy.rebuild(&boxes).unwrap();
    for (object, since, is_same) in [
        (stays, before, true),
        (came, before, false),
        (came, between, true),
        (ObjectId(60), before, false),
    ] {
        assert_eq!(hierarchy.is_same_object_since(object, since), is_same, "{object:?}");
    }
    // An object that a rebuild adds is also new.
    let mut fewer = boxes.clone();
    fewer[7] = Aabb::EMPTY;
    hierarchy.rebuild(&fewer).unwrap();
    let without = hierarchy.generation();
    hierarchy.rebuild(&boxes).unwrap();
    assert!(!hierarchy.is_same_object_since(ObjectId(7), without));
    assert!(hierarchy.is_same_object_since(stays, before));
}

#[test]
fn growing_rebuilds_a_bounded_part_and_stays_shallow() {
    for count in [1_000, 10_000, 100_000] {
        let mut boxes = grid(count);
        let mut hierarchy = Hierarchy::build(&boxes).unwrap();
        let deepest = |hierarchy: &Hierarchy| {
            (0..hierarchy.node_count() as u32).map(|node| hierarchy.level(NodeId(node))).max()
        };
        let before = (hierarchy.generation(), deepest(&hierarchy).unwrap());
        let mut added = Vec::new();
        let mut reordered = Vec::new();
        hierarchy.insert_all(&[lifted(&boxes[0], 3.0)], &mut added, &mut reordered).unwrap();
        assert_eq!(added, [ObjectId(count as u32)]);
        assert_eq!(hierarchy.free_leaves(), count / 16);
        let rebuilt = hierarchy.work().rebuilt_leaves as usize;
        assert!(rebuilt <= 1024 + 1 + count / 16, "{rebuilt} of {count}");
        boxes.push(lifted(&boxes[0], 3.0));
        boxes.resize(hierarchy.leaf_objects().len(), Aabb::EMPTY);
        check(&hierarchy, &boxes);
        // Nodes outside of the last part keep their meaning.
        let first = reordered[0].first;
        let kept = (0..count as u32).map(ObjectId).filter(|o| hierarchy.leaf_of(*o) < Some(first));
        let mut same =
            kept.map(|o| hierarchy.is_same_since(hierarchy.node_of(o).unwrap(), before.0));
        assert!(count < 1024 || same.next() == Some(true));
        assert!(same.all(|is_same| is_same));
        // Three times the number of objects, inserted one after the other.
        for number in 0..2 * count.min(10_000) {
            let bounds = lifted(&boxes[number % count], 6.0);
            hierarchy.insert_all(&[bounds], &mut added, &mut reordered).unwrap();
        }
        let levels = before.1 + 2 * count.ilog2();
        assert!(deepest(&hierarchy).unwrap() <= levels, "{levels} levels");
    }
}

#[test]
fn free_leaves_are_used_before_the_hierarchy_grows() {
    let mut boxes = grid(4_000);
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    for object in 0..900 {
        hierarchy.remove(ObjectId(object * 4)).unwrap();
        boxes[object as usize * 4] = Aabb::EMPTY;
    }
    let new: Vec<Aabb> = grid(901).iter().map(|bounds| lifted(bounds, 3.0)).collect();
    let mut added = Vec::new();
    let mut reordered = Vec::new();
    hierarchy.insert_all(&new, &mut added, &mut reordered).unwrap();
    assert_eq!(hierarchy.leaf_objects().len(), 4_000 + 1 + 4_000 / 16);
    assert_eq!((added.len(), reordered.len()), (901, 1));
    boxes.resize(hierarchy.leaf_objects().len(), Aabb::EMPTY);
    for (object, bounds) in added.iter().zip(new) {
        assert!(boxes[object.0 as usize].is_empty());
        boxes[object.0 as usize] = bounds;
    }
    check(&hierarchy, &boxes);
}

#[test]
fn nothing_is_changed_by_an_insertion_that_is_refused() {
    let boxes = grid(20);
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    let bad = Aabb::new(Vec3::ONE, Vec3::ZERO);
    let mut added = Vec::new();
    let refused = hierarchy.insert_all(&[boxes[0], bad], &mut added, &mut Vec::new());
    assert_eq!(refused, Err(HierarchyError::BadBox { object: ObjectId(1), bounds: bad }));
    assert!(added.is_empty());
    check(&hierarchy, &boxes);
}

#[test]
fn nothing_and_everything_gone_are_no_special_cases() {
    let mut nothing = Hierarchy::build(&[]).unwrap();
    nothing.rebuild_subtrees(&mut Vec::new());
    assert_eq!(nothing.insert(grid(1)[0]), Err(HierarchyError::NoFreeLeaf));
    let object = ObjectId(0);
    assert_eq!(nothing.remove(object), Err(HierarchyError::UnknownObject { object }));

    let mut boxes = grid(50);
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    for object in 0..50 {
        hierarchy.remove(ObjectId(object)).unwrap();
        boxes[object as usize] = Aabb::EMPTY;
        hierarchy.rebuild_subtrees(&mut Vec::new());
    }
    check(&hierarchy, &boxes);
    assert!(hierarchy.bounds(NodeId(0)).is_empty());
    hierarchy.rebuild(&boxes).unwrap();
    for bounds in grid(50) {
        let object = hierarchy.insert(bounds).unwrap();
        boxes[object.0 as usize] = bounds;
        hierarchy.rebuild_subtrees(&mut Vec::new());
    }
    check(&hierarchy, &boxes);
    assert_eq!(hierarchy.free_leaves(), 0);
}

#[test]
fn changes_of_boxes_are_logged_with_both_boxes() {
    let boxes = [0.0, 2.0, 4.0].map(|x| Aabb::new(Vec3::splat(x), Vec3::splat(x + 1.0)));
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    let begun = hierarchy.box_changes();
    let moved = boxes[1].enlarged(0.5);
    hierarchy.refit([(ObjectId(1), moved), (ObjectId(1), boxes[1])]).unwrap();
    hierarchy.remove(ObjectId(2)).unwrap();
    let inserted = hierarchy.insert(boxes[0]).unwrap();
    let change = |object, before, after| BoxChange { object: ObjectId(object), before, after };
    let log: Vec<BoxChange> = hierarchy.box_changes_since(begun).unwrap().copied().collect();
    let wanted = [
        change(1, boxes[1], moved),
        change(1, moved, boxes[1]),
        change(2, boxes[2], Aabb::EMPTY),
        change(inserted.0, Aabb::EMPTY, boxes[0]),
    ];
    assert_eq!(log, wanted);
    assert!(hierarchy.refit([(ObjectId(9), moved)]).is_err());
    assert_eq!(hierarchy.box_changes_since(begun).unwrap().count(), 4, "nothing moved");
    hierarchy.rebuild(&boxes).unwrap();
    assert!(hierarchy.box_changes_since(begun).is_none());
    assert_eq!(hierarchy.box_changes_since(hierarchy.box_changes()).unwrap().count(), 0);
}
