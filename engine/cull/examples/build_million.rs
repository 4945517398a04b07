//! How long a hierarchy over a million objects takes to build, refit and rebuild, and how long a
//! first plan takes: `cargo run --release -p antumbra-cull --example build_million [OBJECTS]`.

use std::time::Instant;

use antumbra_cull::{
    Aabb, Camera, Culler, FramePlan, Hierarchy, HierarchyError, ObjectId, Policy, Strategy, View,
};
use glam::Vec3;

fn main() -> Result<(), HierarchyError> {
    let asked = std::env::args().nth(1);
    let count: usize = asked.and_then(|count| count.parse().ok()).unwrap_or(1_000_000);
    let side = (count as f32).sqrt().ceil().max(1.0) as usize;
    let boxes: Vec<Aabb> = (0..count)
        .map(|number| {
            let corner = Vec3::new((number % side) as f32, 0.0, (number / side) as f32) * 4.0;
            let height = 1.0 + (number * 7919 % 31) as f32;
            Aabb::new(corner, corner + Vec3::new(3.0, height, 3.0))
        })
        .collect();

    let start = Instant::now();
    let mut hierarchy = Hierarchy::build(&boxes)?;
    println!("build of {count} objects: {:?}", start.elapsed());

    let start = Instant::now();
    let moved = (0..count).step_by(100).map(|number| (ObjectId(number as u32), boxes[number]));
    hierarchy.refit(moved)?;
    println!("refit of every hundredth: {:?}", start.elapsed());

    let camera = Camera {
        eye: Vec3::new(side as f32 * 2.0 - 0.5, 1.7, -20.0),
        forward: Vec3::Z,
        up: Vec3::Y,
        fov_y: 1.0,
        near: 0.1,
    };
    let view = View::new(&camera, [1280, 720], 8);
    let mut plan = FramePlan::default();
    for strategy in Strategy::ALL.into_iter().filter(|strategy| !strategy.is_dialogue()) {
        let mut culler = Culler::new(Policy::default());
        for frame in ["first", "second"] {
            let start = Instant::now();
            culler.plan(&hierarchy, strategy, &view, 4_096, &mut plan);
            println!("{frame} plan, {strategy}: {:?}, {:?}", start.elapsed(), plan.stats);
        }
    }

    let start = Instant::now();
    hierarchy.rebuild(&boxes)?;
    println!("rebuild: {:?}", start.elapsed());
    Ok(())
}
