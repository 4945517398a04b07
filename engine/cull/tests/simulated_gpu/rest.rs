//! Tests that plans of a still camera become steady: no test is repeated forever.

use std::collections::BTreeSet;

use antumbra_cull::{Camera, Projection, QueryKind};
use glam::Vec3;

use crate::random::Random;
use crate::scene::city;
use crate::walk::Walk;

const STREET: Camera = Camera {
    eye: Vec3::new(-1.0, 1.7, 70.0),
    forward: Vec3::new(0.05, 0.0, -1.0),
    up: Vec3::Y,
    projection: Projection::perspective(1.0),
    near: 0.1,
};

/// Returns the leaves of a plan that are drawn without a test, and its tested nodes, without
/// scheduled tests.
fn essence(walk: &Walk) -> (BTreeSet<u32>, BTreeSet<u32>) {
    let queried = walk.plan.queried_draws.iter().map(|(leaf, _)| leaf.0);
    let draws = walk.plan.draws.iter().map(|leaf| leaf.0).chain(queried);
    let tests = walk.plan.tests.iter();
    let frontier = tests.filter(|test| test.tag.kind == QueryKind::Proxy);
    (draws.collect(), frontier.map(|test| test.tag.node.0).collect())
}

#[test]
fn a_still_camera_comes_to_rest() {
    for latency in [1, 3] {
        let objects = city(&mut Random::new(3), 24);
        let count = objects.len();
        let mut walk = Walk::new(objects, latency);
        walk.step(&STREET);
        let first = walk.plan.stats.frontier;
        walk.steps(&STREET, 300);
        let mut before = essence(&walk);
        let mut changed = 0;
        let mut queried = 0;
        let mut pull_ups = 0;
        let mut drawn = BTreeSet::new();
        let frames = 256;
        for _ in 0..frames {
            walk.step(&STREET);
            let now = essence(&walk);
            changed += before.0.symmetric_difference(&now.0).count()
                + before.1.symmetric_difference(&now.1).count();
            queried += walk.plan.queried_draws.len();
            pull_ups += walk.plan.stats.pull_up_queries;
            drawn.insert(walk.device.drawn.len());
            before = now;
        }
        let stats = walk.plan.stats;
        let report = format!(
            "latency {latency}, {count} objects, frontier {first} at first, then {stats:?}; \
             {changed} changes, {queried} own draws, {pull_ups} pull-ups in {frames} frames, \
             drawn {drawn:?}"
        );
        assert_eq!(drawn.len(), 1, "what is drawn does not change: {report}");
        assert!(drawn.iter().all(|drawn| *drawn < count / 10), "{report}");
        assert!(stats.frontier < first && stats.unknown == 0, "{report}");
        // The other changes: leaves whose boxes show now and then although the leaves do not.
        assert!(changed < frames, "{report}");
        // Own draws are tested after half to all of the longest interval, and pull-up queries now
        // and then.
        let scheduled = frames * stats.visible as usize / 8;
        assert!(queried + (pull_ups as usize) < scheduled, "{report}");
    }
}
