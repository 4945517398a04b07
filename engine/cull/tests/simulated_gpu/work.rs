//! Tests that the work of a frame grows with the visible objects and the frontier, not with the
//! hidden objects.

use antumbra_cull::{Aabb, Camera, CullConfig, PlanStats, Projection};
use glam::Vec3;

use crate::random::Random;
use crate::scene::city;
use crate::walk::Walk;

const CAMERA: Camera = Camera {
    eye: Vec3::new(0.0, 0.0, 12.0),
    forward: Vec3::NEG_Z,
    up: Vec3::Y,
    projection: Projection::perspective(1.0),
    near: 0.1,
};

/// Returns twenty-five objects before a wall that fills the view, and `hidden` objects behind it.
fn behind_a_wall(hidden: usize) -> Vec<Aabb> {
    let cube = |centre: Vec3| Aabb::new(centre - 0.3, centre + 0.3);
    let wall = Aabb::new(Vec3::new(-40.0, -40.0, -1.0), Vec3::new(40.0, 40.0, 0.0));
    let shown = (0..25).map(|n| {
        let column = n % 5;
        let row = n / 5;
        cube(Vec3::new(column as f32 - 2.0, row as f32 - 2.0, 2.0) * 1.5)
    });
    let side = (hidden as f32).sqrt().ceil() as usize;
    let rest = (0..hidden).map(|n| {
        let column = n % side;
        let row = n / side;
        let across = (column as f32 + 0.5) / side as f32 * 60.0 - 30.0;
        cube(Vec3::new(across, 0.0, -4.0 - row as f32 / side as f32 * 60.0))
    });
    std::iter::once(wall).chain(shown).chain(rest).collect()
}

fn at_rest(hidden: usize) -> (PlanStats, usize, usize) {
    let mut walk = Walk::new(behind_a_wall(hidden), 2);
    walk.steps(&CAMERA, 260);
    let mut worst = (PlanStats::default(), 0, 0);
    for _ in 0..60 {
        walk.step(&CAMERA);
        let stats = walk.plan.stats;
        worst.0.nodes_visited = worst.0.nodes_visited.max(stats.nodes_visited);
        worst.0.frontier = worst.0.frontier.max(stats.frontier);
        worst.1 = worst.1.max(walk.plan.query_count());
        worst.2 = worst.2.max(walk.device.drawn.len());
    }
    worst
}

#[test]
fn a_hundred_times_more_hidden_objects_cost_no_more_than_a_logarithm() {
    let (few, few_queries, few_drawn) = at_rest(200);
    for factor in [10_u32, 100] {
        let (many, queries, drawn) = at_rest(200 * factor as usize);
        let levels = 2 * factor.ilog2() + 2;
        assert!(many.nodes_visited <= few.nodes_visited + 2 * levels, "{few:?} {many:?}");
        assert!(many.frontier <= few.frontier + levels, "{few:?} {many:?}");
        assert!(queries <= few_queries + levels as usize, "{few_queries} {queries}");
        assert_eq!(drawn, few_drawn, "what is drawn is what is visible");
    }
}

/// Checks that a huge scene becomes steady within tens of frames after a cut.
#[test]
fn a_huge_unknown_scene_settles_in_tens_of_frames() {
    let mut walk = Walk::new(behind_a_wall(60_000), 2);
    let mut frontier = Vec::new();
    for frame in 0..40 {
        walk.step(&CAMERA);
        assert!(walk.is_exact(&CAMERA), "frame {frame}");
        frontier.push(walk.plan.stats.frontier);
    }
    let wished = CullConfig::default().tests_wished;
    assert!(frontier.iter().skip(6).all(|tests| *tests <= wished), "{frontier:?}");
    assert!(frontier[39] * 3 < wished, "{frontier:?}");
}

/// Checks that on a walk along a street, with a turn now and then, the number of draws stays close
/// to the number of visible objects.
#[test]
fn a_walk_draws_a_small_part_of_the_frustum() {
    let mut walk = Walk::new(city(&mut Random::new(3), 40), 2);
    let mut camera =
        Camera { eye: Vec3::new(-1.0, 1.7, 150.0), forward: Vec3::new(0.03, 0.0, -1.0), ..CAMERA };
    let mut drawn = 0;
    let mut in_frustum = 0;
    let mut queries = 0;
    for frame in 0..200 {
        camera.eye.z -= 0.25;
        if frame % 60 >= 45 {
            camera.forward = glam::Quat::from_rotation_y(0.01) * camera.forward;
        }
        walk.step(&camera);
        assert!(walk.is_exact(&camera), "frame {frame}");
        if frame >= 20 {
            drawn += walk.device.drawn.len();
            queries += walk.plan.query_count();
            in_frustum += walk.count_in_frustum(&camera);
        }
    }
    println!("{drawn} drawn and {queries} queries for {in_frustum} in the frustum");
    assert!(drawn * 5 < in_frustum, "{drawn} of {in_frustum}");
    assert!(queries * 3 < in_frustum, "{queries} for {in_frustum}");
}
