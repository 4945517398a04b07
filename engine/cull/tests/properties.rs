//! Properties of the hierarchy, the frustum test, and the margin, over random input.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use antumbra_cull::{
    Aabb, Camera, Containment, Hierarchy, HierarchyError, LeafIndex, NodeId, ObjectId, PlaneMask,
    View,
};
use glam::{DVec2, DVec3, Vec3};
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

/// Returns a camera, an image, and a direction of sight that is none of the axes.
fn view() -> impl Strategy<Value = View> {
    (
        [-20.0_f32..20.0, -20.0..20.0, -20.0..20.0],
        [-1.0_f32..1.0, -0.8..0.8, -1.0..1.0],
        0.2_f32..2.2,
        0.01_f32..1.0,
        [16_u32..2000, 16..2000],
        prop_oneof![Just(4_u32), Just(8)],
    )
        .prop_map(|(eye, forward, fov_y, near, size, bits)| {
            let camera = Camera {
                eye: Vec3::from_array(eye),
                forward: Vec3::from_array(forward),
                up: Vec3::Y,
                fov_y,
                near,
            };
            View::new(&camera, size, bits)
        })
}

fn small_box() -> impl Strategy<Value = Aabb> {
    ([-60.0_f32..60.0, -60.0..60.0, -60.0..60.0], [0.0_f32..9.0, 0.0..9.0, 0.0..9.0]).prop_map(
        |(min, size)| {
            let min = Vec3::from_array(min);
            Aabb::new(min, min + Vec3::from_array(size))
        },
    )
}

/// Returns the position of a point on the screen (pixels) and its view depth, in 64 bits.
fn project(view: &View, point: DVec3) -> (DVec2, f64) {
    let offset = point - view.eye.as_dvec3();
    let depth = offset.dot(view.forward.as_dvec3());
    let across = offset.dot(view.right.as_dvec3()) / depth / f64::from(view.tan_half[0]);
    let up = offset.dot(view.up.as_dvec3()) / depth / f64::from(view.tan_half[1]);
    let half = DVec2::new(view.size[0].into(), view.size[1].into()) * 0.5;
    ((DVec2::new(across, -up) + 1.0) * half, depth)
}

/// Returns the view depth at which the ray of a screen position enters a box, if it does.
fn enters(view: &View, bounds: &Aabb, position: DVec2) -> Option<f64> {
    let half = DVec2::new(view.size[0].into(), view.size[1].into()) * 0.5;
    let ndc = position / half - 1.0;
    let ray = view.forward.as_dvec3()
        + view.right.as_dvec3() * (ndc.x * f64::from(view.tan_half[0]))
        - view.up.as_dvec3() * (ndc.y * f64::from(view.tan_half[1]));
    let a = (bounds.min.as_dvec3() - view.eye.as_dvec3()) / ray;
    let b = (bounds.max.as_dvec3() - view.eye.as_dvec3()) / ray;
    let (first, last) = (a.min(b).max_element(), a.max(b).min_element());
    (first <= last && first > 0.0).then_some(first)
}

/// Returns a point on the screen: its position (0 to 1 from the upper left) and its view depth
/// (metres).
fn on_screen() -> impl Strategy<Value = [f32; 3]> {
    [0.0_f32..1.0, 0.0..1.0, 1.01..90.0]
}

/// Returns the world position of a point on the screen.
fn unproject(view: &View, [x, y, depth]: [f32; 3]) -> Vec3 {
    let [tan_x, tan_y] = view.tan_half;
    let ray =
        view.forward + view.right * ((2.0 * x - 1.0) * tan_x) - view.up * ((2.0 * y - 1.0) * tan_y);
    view.eye + ray * depth
}

/// Returns two corners that lie this far from a point.
fn reach() -> impl Strategy<Value = [[f32; 3]; 2]> {
    let axis = || prop_oneof![Just(0.0_f32), 0.0_f32..9.0];
    [[axis(), axis(), axis()], [axis(), axis(), axis()]]
}

fn around(point: Vec3, [low, high]: [[f32; 3]; 2], scale: f32) -> Aabb {
    let [low, high] = [low, high].map(|reach| Vec3::from_array(reach) * scale);
    Aabb::new(point - low, point + high)
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

    /// Checks that a box with a point on the screen is never outside, also with the masks of a
    /// parent.
    #[test]
    fn nothing_on_the_screen_is_rejected(
        view in view(),
        at in on_screen(),
        reach in reach(),
        parent in small_box(),
    ) {
        let bounds = around(unproject(&view, at), reach, 1.0);
        let (above, mask) = view.frustum.classify(&parent.union(&bounds), PlaneMask::ALL);
        prop_assert_ne!(above, Containment::Outside);
        prop_assert_ne!(view.frustum.classify(&bounds, mask).0, Containment::Outside);
        prop_assert_ne!(view.frustum.classify(&bounds, PlaneMask::ALL).0, Containment::Outside);
    }

    /// Checks that a box inside of all planes is on the screen with every corner.
    #[test]
    fn what_is_inside_is_on_the_screen(view in view(), at in on_screen(), reach in reach()) {
        let bounds = around(unproject(&view, at), reach, 0.1);
        let (containment, _) = view.frustum.classify(&bounds, PlaneMask::ALL);
        if containment != Containment::Inside {
            return Ok(());
        }
        let size = DVec2::new(view.size[0].into(), view.size[1].into());
        for corner in bounds.corners() {
            let (pixel, depth) = project(&view, corner.as_dvec3());
            prop_assert!(depth > f64::from(view.near) * 0.999);
            prop_assert!(pixel.cmpge(DVec2::splat(-0.01)).all());
            prop_assert!(pixel.cmple(size + 0.01).all());
        }
    }

    /// Checks the claim of the margin: where a point of the object moves on the screen by a step of
    /// the grid, and the ray by another, the proxy still covers it and is nearer in 32-bit reversed
    /// depth.
    #[test]
    fn snapping_loses_no_sample(
        view in view(),
        (seen, reach) in (on_screen(), reach()),
        bits in prop_oneof![Just(4_i32), Just(8)],
        at in [0.0_f32..=1.0, 0.0..=1.0, 0.0..=1.0],
        onto in 0_usize..3,
        angles in [0.0_f64..6.3, 0.0..6.3],
    ) {
        let camera = Camera {
            eye: view.eye,
            forward: view.forward,
            up: view.up,
            fov_y: 2.0 * view.tan_half[1].atan(),
            near: view.near,
        };
        let view = View::new(&camera, view.size, bits as u32);
        let bounds = around(unproject(&view, seen), reach, 0.5);
        let Some(proxy) = view.margin.proxy(&bounds) else {
            return Ok(());
        };
        // On the surface, where it is tightest.
        let mut at = Vec3::from_array(at);
        at[onto] = at[onto].round();
        let point = bounds.min + (bounds.max - bounds.min) * at;
        let point = point.clamp(bounds.min, bounds.max);
        let (pixel, depth) = project(&view, point.as_dvec3());
        let step = std::f64::consts::SQRT_2 * 0.5_f64.powi(bits);
        let sample = angles
            .iter()
            .fold(pixel, |position, angle| position + DVec2::from_angle(*angle) * step);
        let entry = enters(&view, &proxy, sample);
        prop_assert!(entry.is_some(), "{:?} at {} missed by {:?}", point, sample, proxy);
        let entry = entry.unwrap();
        prop_assert!(entry > f64::from(view.near));
        let reversed = |depth: f64| (f64::from(view.near) / depth) as f32;
        prop_assert!(reversed(entry) >= reversed(depth));
    }

    /// Checks that boxes with a proxy are wholly ahead, and that those too near have none.
    #[test]
    fn proxies_are_beyond_the_near_plane(view in view(), bounds in small_box()) {
        let ahead = |bounds: &Aabb| {
            bounds.corners().iter().all(|corner| {
                project(&view, corner.as_dvec3()).1 > f64::from(view.near)
            })
        };
        match view.margin.proxy(&bounds) {
            Some(proxy) => prop_assert!(ahead(&proxy) && proxy.contains(&bounds)),
            None => {
                let behind = bounds.enlarged(0.5 + 1.0e-4 * bounds.largest_coordinate());
                let footprint = 2.0 * view.tan_half[1] / view.size[1] as f32;
                if footprint < 0.002 {
                    prop_assert!(!ahead(&behind));
                }
            }
        }
    }
}
