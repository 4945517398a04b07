//! Tests of hierarchies over input that is difficult for clustering: ties, points, and extreme
//! scales.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::time::{Duration, Instant};

use antumbra_cull::{Aabb, Hierarchy, NodeId};
use glam::Vec3;

const COUNT: usize = 100_000;

/// Builds a hierarchy, checks its shape, and returns its depth.
fn depth(name: &str, boxes: &[Aabb]) -> u32 {
    let start = Instant::now();
    let hierarchy = Hierarchy::build(boxes).unwrap();
    let took = start.elapsed();
    assert!(took < Duration::from_secs(20), "{name} took {took:?}");
    assert_eq!(hierarchy.node_count(), 2 * boxes.len() - 1);
    let nodes = (0..hierarchy.node_count() as u32).map(NodeId);
    let depth = nodes.map(|node| hierarchy.level(node)).max().unwrap();
    println!("{name}: {took:?}, depth {depth}");
    depth
}

fn boxes(of: impl Fn(usize) -> Aabb) -> Vec<Aabb> {
    (0..COUNT).map(of).collect()
}

fn unit(corner: Vec3) -> Aabb {
    Aabb::new(corner, corner + 1.0)
}

#[test]
fn all_boxes_the_same() {
    assert!(depth("same", &boxes(|_| unit(Vec3::splat(3.0)))) < 100);
    assert!(depth("same point", &boxes(|_| Aabb::new(Vec3::ONE, Vec3::ONE))) < 100);
}

#[test]
fn rows_and_grids_of_equal_distances() {
    assert!(depth("row", &boxes(|n| unit(Vec3::X * n as f32))) < 100);
    let point = |n: usize| Vec3::new((n % 317) as f32, 0.0, (n / 317) as f32);
    assert!(depth("grid of points", &boxes(|n| Aabb::new(point(n), point(n)))) < 100);
    assert!(
        depth("nested", &boxes(|n| Aabb::new(Vec3::splat(-(n as f32)), Vec3::splat(n as f32))))
            < 400
    );
}

#[test]
fn distances_that_grow_exponentially() {
    let corner = |n: usize| Vec3::X * 1.7_f32.powi((n % 130) as i32 - 66);
    assert!(depth("exponential", &boxes(|n| Aabb::new(corner(n), corner(n)))) < 400);
}
