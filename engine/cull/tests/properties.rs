//! Tests properties of the hierarchy over random input.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use antumbra_cull::{Aabb, Hierarchy, HierarchyError, LeafIndex, NodeId, ObjectId};
use glam::Vec3;
use proptest::prelude::*;

fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => -50.0_f32..50.0,
        1 => Just(0.0),
        1 => -1.0e15_f32..1.0e15,
        1 => -1.0e-30_f32..1.0e-30,
    ]
}

fn point() -> impl Strategy<Value = Vec3> {
    [coordinate(), coordinate(), coordinate()].prop_map(Vec3::from_array)
}

fn any_box() -> impl Strategy<Value = Aabb> {
    (point(), point(), any::<bool>()).prop_map(|(a, b, is_point)| {
        let b = if is_point { a } else { b };
        Aabb::new(a.min(b), a.max(b))
    })
}

/// Returns random boxes, some of them many times.
fn boxes() -> impl Strategy<Value = Vec<Aabb>> {
    (prop::collection::vec(any_box(), 0..40), 1_usize..4)
        .prop_map(|(some, times)| some.repeat(times))
}

fn check(hierarchy: &Hierarchy, boxes: &[Aabb]) -> Result<(), TestCaseError> {
    prop_assert_eq!(hierarchy.node_count(), (2 * boxes.len()).saturating_sub(1));
    prop_assert_eq!(hierarchy.leaf_objects().len(), boxes.len());
    for (leaf, object) in hierarchy.leaf_objects().iter().enumerate() {
        prop_assert_eq!(hierarchy.leaf_of(*object), Some(LeafIndex(leaf as u32)));
    }
    for node in (0..hierarchy.node_count() as u32).map(NodeId) {
        let range = hierarchy.leaves(node);
        let tight = range.indices().fold(Aabb::EMPTY, |sum, leaf| {
            sum.union(&boxes[hierarchy.leaf_objects()[leaf].0 as usize])
        });
        prop_assert_eq!(hierarchy.bounds(node), tight);
        let Some(children) = hierarchy.children(node) else {
            prop_assert_eq!(range.count, 1);
            continue;
        };
        let [left, right] = children.map(|child| hierarchy.leaves(child));
        prop_assert_eq!(left.first, range.first);
        prop_assert_eq!(right.first.0, range.first.0 + left.count);
        prop_assert_eq!(left.count + right.count, range.count);
        for child in children {
            prop_assert_eq!(hierarchy.parent(child), Some(node));
            prop_assert_eq!(hierarchy.level(child), hierarchy.level(node) + 1);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn every_subtree_is_contiguous_and_tight(boxes in boxes()) {
        check(&Hierarchy::build(&boxes).unwrap(), &boxes)?;
    }

    #[test]
    fn refitting_and_rebuilding_fit_the_moved_boxes(
        mut boxes in boxes(),
        moves in prop::collection::vec((any::<prop::sample::Index>(), any_box()), 1..20),
    ) {
        prop_assume!(!boxes.is_empty());
        let mut hierarchy = Hierarchy::build(&boxes).unwrap();
        let mut moved = Vec::new();
        for (index, target) in moves {
            let object = index.index(boxes.len());
            boxes[object] = target;
            moved.push((ObjectId(object as u32), target));
        }
        hierarchy.refit(moved).unwrap();
        check(&hierarchy, &boxes)?;
        let before = hierarchy.generation();
        let after = hierarchy.rebuild(&boxes).unwrap();
        prop_assert!(after > before && hierarchy.generation() == after);
        check(&hierarchy, &boxes)?;
    }

    #[test]
    fn bad_boxes_are_named_and_change_nothing(
        mut boxes in boxes(),
        index in any::<prop::sample::Index>(),
        coordinate in prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(f32::MIN)],
        axis in 0_usize..3,
    ) {
        prop_assume!(!boxes.is_empty());
        let mut hierarchy = Hierarchy::build(&boxes).unwrap();
        let object = index.index(boxes.len());
        let mut bad = boxes[object];
        bad.max[axis] = coordinate;
        let named = |error| match error {
            HierarchyError::BadBox { object, .. } => Some(object.0 as usize),
            _ => None,
        };
        let refused = hierarchy.refit([(ObjectId(object as u32), bad)]).unwrap_err();
        prop_assert_eq!(named(refused), Some(object));
        check(&hierarchy, &boxes)?;
        boxes[object] = bad;
        prop_assert_eq!(named(Hierarchy::build(&boxes).unwrap_err()), Some(object));
        prop_assert_eq!(named(hierarchy.rebuild(&boxes).unwrap_err()), Some(object));
    }

    #[test]
    fn foreign_ids_are_answered_as_nothing(boxes in boxes(), beyond in 0_u32..9) {
        let mut hierarchy = Hierarchy::build(&boxes).unwrap();
        let node = NodeId(hierarchy.node_count() as u32 + beyond);
        prop_assert!(hierarchy.leaves(node).is_empty());
        prop_assert!(hierarchy.children(node).is_none() && hierarchy.parent(node).is_none());
        prop_assert_eq!(hierarchy.bounds(node), Aabb::EMPTY);
        let object = ObjectId(boxes.len() as u32 + beyond);
        let target = Aabb::new(Vec3::ZERO, Vec3::ONE);
        prop_assert_eq!(
            hierarchy.refit([(object, target)]),
            Err(HierarchyError::UnknownObject { object })
        );
    }
}
