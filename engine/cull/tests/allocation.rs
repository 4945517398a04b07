//! Checks that a steady frame does not allocate: all memory is kept and reused.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use allocation_counter::measure;
use antumbra_cull::{
    Aabb, Answer, Camera, CullConfig, CullView, Culler, FramePlan, Hierarchy, ObjectId, Projection,
    Strategy,
};
use glam::Vec3;

#[test]
fn steady_frames_do_not_allocate() {
    let boxes: Vec<Aabb> = (0..2_000)
        .map(|n| {
            let corner = Vec3::new((n % 50) as f32, 0.0, -(n / 50) as f32) * 3.0;
            Aabb::new(corner, corner + 2.0)
        })
        .collect();
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    let mut culler = Culler::new(CullConfig::default());
    let mut plan = FramePlan::default();
    let mut answers = Vec::new();
    let mut reordered = Vec::new();
    let camera = Camera {
        eye: Vec3::new(75.0, 1.0, 10.0),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.1,
    };
    let mut frame = || {
        hierarchy.refit([(ObjectId(7), boxes[8]), (ObjectId(7), boxes[7])]).unwrap();
        hierarchy.remove(ObjectId(9)).unwrap();
        hierarchy.insert(boxes[9]).unwrap();
        hierarchy.rebuild_subtrees(&mut reordered);
        culler.ingest(&hierarchy, answers.drain(..));
        let view = CullView::new(&camera, [320, 180], 8);
        culler.plan(&hierarchy, Strategy::ANTUMBRA, &view, 1_000, &mut plan);
        // The first rows show, the others do not.
        let shows = |node| hierarchy.bounds(node).max.z > -20.0;
        let tests = plan.tests.iter().map(|test| test.tag);
        let draws = plan.queried_draws.iter().map(|(_, tag)| *tag);
        answers.extend(
            tests.chain(draws).map(|tag| Answer { tag, samples: u32::from(shows(tag.node)) }),
        );
        plan.tests.len()
    };
    // Until the journal of changes is full and drops its oldest.
    for _ in 0..6_000 {
        frame();
    }
    let mut tests = 0;
    let allocated = measure(|| tests = (0..100).map(|_| frame()).sum());
    assert!(tests > 100, "the frames must do something");
    assert_eq!(allocated.count_total, 0);
}
