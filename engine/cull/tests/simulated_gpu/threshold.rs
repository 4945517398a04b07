//! Tests that with a threshold an object is only missing if it showed no more samples than that,
//! and that no more pixels are wrong.

use antumbra_cull::{
    Aabb, Camera, CullConfig, CullView, Culler, DrawPhases, FramePlan, Hierarchy, NodeState,
    ObjectId, Projection, ProxyTest, Strategy, VisibilityTest, VisibilityTestSupport,
};
use glam::Vec3;

use crate::device::{Device, Mishaps, Solids};
use crate::image::Image;
use crate::random::Random;
use crate::scene::{PATHS, Path, Scene};
use crate::walk::Walk;

const SCENES: u64 = 150;
const FRAMES: u64 = 24;
const SIZE: [u32; 2] = [40, 28];
const SUB_PIXEL_BITS: u32 = 8;

const CAMERA: Camera = Camera {
    eye: Vec3::ZERO,
    forward: Vec3::NEG_Z,
    up: Vec3::Y,
    projection: Projection::perspective(1.0),
    near: 0.1,
};

/// The findings of a walk.
#[derive(Debug, Default)]
struct Found {
    drawn: usize,
    pixels_wrong: usize,
    below_threshold: u64,
}

/// Counts the pixels of the whole image in which one of these objects is the nearest.
fn owned(
    view: &CullView,
    scene: &Scene,
    truth: &Image,
    objects: impl Iterator<Item = usize>,
) -> u32 {
    let mut alone = Image::new(SIZE);
    let mut is_owned = vec![false; truth.depths.len()];
    for object in objects {
        alone.clear();
        alone.draw(view, &scene.solids[object], scene.shifts[object]);
        for ((is_owned, own), nearest) in is_owned.iter_mut().zip(&alone.depths).zip(&truth.depths)
        {
            *is_owned |= *own > 0.0 && own == nearest;
        }
    }
    is_owned.iter().filter(|is_owned| **is_owned).count() as u32
}

/// Walks with a random threshold of `thresholds` in each frame.
fn walk(seed: u64, thresholds: &[u32]) -> Found {
    let mut random = Random::new(seed);
    let scene = Scene::random(&mut random, SUB_PIXEL_BITS);
    let hierarchy = Hierarchy::build(&scene.bounds).unwrap();
    let mut camera = Path::start(&mut random);
    let path = PATHS[random.below(PATHS.len())];
    let calm = Mishaps::none(1 + seed % 4);
    let rough = Mishaps { late: 0.3, lost: 0.2, twice: 0.2, ..calm };
    let mishaps = if random.chance(0.5) { rough } else { calm };
    let other_testers = thresholds.len() > 1;
    let testers = VisibilityTestSupport {
        queries: true,
        flags: other_testers,
        compute: other_testers,
        leaf_tests: random.chance(0.5),
        draw_phases: [DrawPhases::PerRound, DrawPhases::Two][random.below(2)],
    };
    let mut culler = Culler::with_testers(CullConfig { seed, ..CullConfig::default() }, testers);
    let mut device = Device::new(SIZE, SUB_PIXEL_BITS, mishaps, seed);
    let mut plan = FramePlan::default();
    let mut truth = Image::new(SIZE);
    let solids = Solids { solids: &scene.solids, shifts: &scene.shifts };
    let mut found = Found::default();
    for frame in 0..FRAMES {
        path.advance(&mut camera, frame, &mut random);
        let view = CullView::new(&camera, SIZE, SUB_PIXEL_BITS);
        truth.clear();
        for (solid, shift) in scene.solids.iter().zip(&scene.shifts) {
            truth.draw(&view, solid, *shift);
        }
        let answers = device.collect(culler.frame().0 + 1, &hierarchy);
        culler.ingest(&hierarchy, answers);
        let threshold_samples = thresholds[(seed + frame / 2) as usize % thresholds.len()];
        culler.set_sample_threshold(threshold_samples);
        culler.plan(&hierarchy, Strategy::ANTUMBRA, &view, 10_000, &mut plan);
        device.execute(&view, &hierarchy, &solids, &plan);
        assert_eq!(plan.sample_threshold, threshold_samples);
        let counts = |test: &ProxyTest| test.tester == VisibilityTest::Query;
        assert!(threshold_samples == 0 || plan.tests.iter().all(counts), "others do not count");
        let context = format!("seed {seed}, frame {frame}, threshold {threshold_samples}");
        for (leaves, samples) in &device.below_threshold {
            let objects = &hierarchy.leaf_objects()[leaves.indices()];
            let objects = objects.iter().map(|object| object.0 as usize);
            let lost = owned(&view, &scene, &truth, objects);
            assert!(lost <= *samples && *samples <= threshold_samples, "{context}: {lost}");
        }
        let below_threshold: u64 =
            device.below_threshold.iter().map(|(_, samples)| u64::from(*samples)).sum();
        let pixels = device.images[0].depths.iter().zip(&truth.depths);
        let wrong = pixels.filter(|(ours, all)| ours != all).count();
        assert!(
            wrong as u64 <= below_threshold,
            "{context}: {wrong} wrong, {below_threshold} below the threshold"
        );
        found.drawn += device.drawn.len();
        found.pixels_wrong += wrong;
        found.below_threshold += below_threshold;
    }
    found
}

/// Returns a walk with an object that shows some pixels next to a wall. Answers take two frames.
fn peeping_over_a_wall() -> Walk {
    let wall = Aabb::new(Vec3::new(-4.0, -4.0, -6.0), Vec3::new(4.0, 0.0, -5.0));
    let peeping = Aabb::new(Vec3::new(-0.6, -1.0, -7.0), Vec3::new(0.6, 0.3, -6.5));
    Walk::new(vec![wall, peeping], 2)
}

fn state_of_peeping(walk: &Walk) -> NodeState {
    walk.culler.state(walk.hierarchy.node_of(ObjectId(1)).unwrap())
}

#[test]
fn what_is_missing_showed_no_more_than_the_threshold() {
    let [exact, few, many] = [0, 4, 40].map(|threshold| {
        (0..SCENES).map(|seed| walk(seed, &[threshold])).fold(Found::default(), |sum, found| {
            Found {
                drawn: sum.drawn + found.drawn,
                pixels_wrong: sum.pixels_wrong + found.pixels_wrong,
                below_threshold: sum.below_threshold + found.below_threshold,
            }
        })
    });
    println!("{exact:?} {few:?} {many:?}");
    assert_eq!((exact.pixels_wrong, exact.below_threshold), (0, 0));
    assert!(few.pixels_wrong > 0 && few.pixels_wrong < many.pixels_wrong, "{few:?} {many:?}");
    assert!(many.drawn < few.drawn && few.drawn < exact.drawn, "{exact:?} {few:?} {many:?}");
}

/// Checks that a frame is as exact as the threshold of its own plan requires, and that results of
/// earlier frames use the thresholds of their plans: the device compares them with its draws.
#[test]
fn a_threshold_that_changes_counts_for_the_plans_made_with_it() {
    let found: Vec<Found> = (0..SCENES).map(|seed| walk(seed, &[0, 40, 4])).collect();
    assert!(found.iter().any(|found| found.pixels_wrong > 0));
}

/// Checks an object that shows some pixels next to a wall: with a threshold it becomes hidden and
/// costs one test per frame; without one it stays visible.
#[test]
fn what_shows_little_comes_to_count_as_hidden() {
    let state = |threshold_samples| {
        let mut walk = peeping_over_a_wall();
        walk.culler.set_sample_threshold(threshold_samples);
        walk.steps(&CAMERA, 200);
        (state_of_peeping(&walk), walk.device.drawn.len())
    };
    assert_eq!(state(0), (NodeState::Visible, 2));
    assert_eq!(state(60), (NodeState::Hidden, 1));
}

/// Checks that results in flight use the threshold of their own frame, in which the object was not
/// drawn, and that the frame after a change is still exact.
#[test]
fn a_result_on_its_way_keeps_its_threshold() {
    let mut walk = peeping_over_a_wall();
    walk.culler.set_sample_threshold(60);
    walk.steps(&CAMERA, 200);
    assert!(!walk.is_exact(&CAMERA));
    walk.culler.set_sample_threshold(0);
    for state in [NodeState::Hidden, NodeState::Hidden, NodeState::Visible] {
        walk.step(&CAMERA);
        assert_eq!(state_of_peeping(&walk), state);
        assert!(walk.is_exact(&CAMERA));
    }
}
