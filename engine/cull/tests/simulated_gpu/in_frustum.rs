//! Tests of the count of objects in the frustum against the classification of each box.

use antumbra_cull::{
    Aabb, Containment, CullConfig, CullView, Culler, FramePlan, Frustum, Hierarchy, LeafRange,
    ObjectId, PlaneMask, Strategy,
};

use crate::random::Random;
use crate::scene::{PATHS, Path, Scene, cube};

/// Returns the number of draws of frustum culling, and of leaves whose box is not outside.
fn brute_force(hierarchy: &Hierarchy, boxes: &[Aabb], view: &CullView) -> [usize; 2] {
    let mut plan = FramePlan::default();
    let mut culler = Culler::new(CullConfig::default());
    culler.plan(hierarchy, Strategy::FRUSTUM, view, 0, &mut plan);
    let is_in =
        |bounds: &&Aabb| view.frustum.classify(bounds, PlaneMask::ALL).0 != Containment::Outside;
    [plan.draws.len(), boxes.iter().filter(is_in).count()]
}

#[test]
fn as_many_objects_are_in_the_frustum_as_frustum_culling_draws() {
    let mut partly = 0;
    let mut none = 0;
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let mut boxes = Scene::random(&mut random, 8).bounds;
        boxes.extend((0..random.below(9)).map(|_| Aabb::EMPTY));
        let mut hierarchy = Hierarchy::build(&boxes).unwrap();
        let path = PATHS[random.below(PATHS.len())];
        let mut camera = Path::start(&mut random);
        for frame in 0..12 {
            let object = random.below(boxes.len());
            if boxes[object].is_empty() {
                let arrived = cube(random.point(-15.0, 15.0), &mut random);
                let object = hierarchy.insert(arrived).unwrap();
                boxes[object.0 as usize] = arrived;
            } else {
                hierarchy.remove(ObjectId(object as u32)).unwrap();
                boxes[object] = Aabb::EMPTY;
            }
            let there = boxes.iter().filter(|bounds| !bounds.is_empty()).count();
            assert_eq!(hierarchy.object_count() as usize, there, "seed {seed}, frame {frame}");
            path.advance(&mut camera, frame, &mut random);
            let view = CullView::new(&camera, [48, 32], 8);
            let counted = hierarchy.objects_in_frustum(&view) as usize;
            let expected = brute_force(&hierarchy, &boxes, &view);
            assert_eq!([counted; 2], expected, "seed {seed}, frame {frame}");
            let wide = view.frustum_around(2.0);
            let mut leaves = Vec::new();
            let mut wider = Vec::new();
            hierarchy.leaves_in(&view.frustum, &view, &mut leaves);
            hierarchy.leaves_in(&wide, &view, &mut wider);
            let has = |ranges: &[LeafRange], leaf| {
                ranges.iter().any(|range| range.indices().contains(&leaf))
            };
            for (leaf, object) in hierarchy.leaf_objects().iter().enumerate() {
                let bounds = boxes.get(object.0 as usize).copied().unwrap_or(Aabb::EMPTY);
                let is_in = |frustum: &Frustum| {
                    frustum.classify(&bounds, PlaneMask::ALL).0 != Containment::Outside
                };
                let free = bounds.is_empty();
                assert!(free || is_in(&view.frustum) == has(&leaves, leaf), "seed {seed}");
                assert!(free || is_in(&wide) == has(&wider, leaf), "seed {seed}");
                assert!(free || !has(&leaves, leaf) || has(&wider, leaf), "seed {seed}");
            }
            partly += usize::from(counted > 0 && counted < there);
            none += usize::from(counted == 0);
        }
    }
    assert!(partly > 500 && none > 20, "{partly} {none}");
    let nothing = Hierarchy::build(&[]).unwrap();
    let view = CullView::new(&Path::start(&mut Random::new(1)), [48, 32], 8);
    assert_eq!((nothing.object_count(), nothing.objects_in_frustum(&view)), (0, 0));
}
