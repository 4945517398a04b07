//! Tests of the blocking methods of the literature: they are exact whatever happens to the results,
//! and each has the cost that is known from the literature.

use antumbra_cull::{
    BatchedOptions, BlockingCuller, BlockingKind, BlockingStats, Camera, ChcOptions, CullView,
    FirstPass, Hierarchy, LeafTest, ObjectId, Strategy,
};
use glam::Vec3;

use crate::device::Solids;
use crate::image::Image;
use crate::random::Random;
use crate::scene::{PATHS, Path, Scene, city};
use crate::talk::{Talk, Trouble};
use crate::walk::STREET;

const SIZE: [u32; 2] = [40, 28];

/// Returns the blocking methods with these options.
fn kinds(batched: BatchedOptions, chc: ChcOptions) -> [BlockingKind; 4] {
    let batched = BlockingKind::Batched(batched);
    let chc = BlockingKind::Chc(chc);
    [BlockingKind::Naive, batched, BlockingKind::StopAndWait, chc]
}

pub fn default_kinds() -> [BlockingKind; 4] {
    kinds(BatchedOptions::default(), ChcOptions::default())
}

fn truth(view: &CullView, scene: &Scene) -> Image {
    let mut image = Image::new(SIZE);
    for (solid, shift) in scene.solids.iter().zip(&scene.shifts) {
        image.draw(view, solid, *shift);
    }
    image
}

fn random_kinds(random: &mut Random) -> [BlockingKind; 4] {
    let few = [1, 2, 5, 32];
    let batched = BatchedOptions {
        occluder_angle: random.between(0.0, 2.0),
        tests_per_submit: few[random.below(4)],
    };
    let chc = ChcOptions {
        leaf_test: [LeafTest::OwnGeometry, LeafTest::Box][random.below(2)],
        first_pass: FirstPass::Shaded,
        visibility_threshold_samples: 0,
        assumed_visible_frames: [0, 1, 3, 8][random.below(4)],
        tests_per_submit: few[random.below(4)],
        draws_per_submit: few[random.below(4)],
    };
    kinds(batched, chc)
}

/// Runs one seed with all methods and returns the number of leaves drawn and in sight.
fn verify(seed: u64) -> [u64; 2] {
    let mut random = Random::new(seed);
    let sub_pixel_bits = [4, 8][random.below(2)];
    let mut scene = Scene::random(&mut random, sub_pixel_bits);
    let mut hierarchy = Hierarchy::build(&scene.bounds).unwrap();
    let mut camera = Path::start(&mut random);
    let path = PATHS[random.below(PATHS.len())];
    let is_moving = random.chance(0.4);
    let is_rebuilding = random.chance(0.3);
    let is_rough = random.chance(0.4);
    let trouble = Trouble {
        polls: random.below(4),
        lost: if is_rough { 0.1 } else { 0.0 },
        twice: if is_rough { 0.2 } else { 0.0 },
    };
    let mut runs = [0, 1, 2, 3].map(|method| {
        let kind = random_kinds(&mut random)[method];
        (kind, BlockingCuller::new(kind), Talk::new(SIZE, sub_pixel_bits, trouble, seed))
    });
    let mut counted = [0; 2];
    for frame in 0..12 {
        path.advance(&mut camera, frame, &mut random);
        if is_moving {
            let object = scene.move_one(&mut random);
            hierarchy.refit([(ObjectId(object as u32), scene.bounds[object])]).unwrap();
        }
        if is_rebuilding && frame % 4 == 3 {
            hierarchy.rebuild(&scene.bounds).unwrap();
        }
        let view = CullView::new(&camera, SIZE, sub_pixel_bits);
        let expected = truth(&view, &scene);
        let solids = Solids { solids: &scene.solids, shifts: &scene.shifts };
        for (kind, blocking, talk) in &mut runs {
            let context = format!("seed {seed}, frame {frame}, {kind:?}");
            let mut decisions = blocking.begin(&hierarchy, &view);
            let stats = talk.frame(&mut decisions, &view, &hierarchy, &solids);
            assert!(talk.image.depths == expected.depths, "{context}: wrong pixels");
            check_books(talk, &stats, &context);
            counted[0] += u64::from(stats.draws);
            counted[1] += scene.bounds.len() as u64;
        }
    }
    counted
}

/// Checks that the tests and draws agree with the counts of the frame, and that none happened
/// twice.
fn check_books(talk: &Talk, stats: &BlockingStats, context: &str) {
    let mut drawn = talk.drawn.clone();
    drawn.sort();
    drawn.dedup();
    assert_eq!(drawn.len(), talk.drawn.len(), "{context}: drawn twice");
    assert_eq!(drawn.len(), stats.draws as usize, "{context}");
    let tested: Vec<u32> = talk.tested.iter().map(|(token, _)| token.0).collect();
    let mut in_order = tested.clone();
    in_order.sort();
    assert_eq!(tested.len(), (stats.boxes + stats.visible_draw_queries) as usize, "{context}");
    assert!((0..).zip(&in_order).all(|(number, token)| number == *token), "{context}: {tested:?}");
    assert!(stats.waits <= stats.boxes + stats.visible_draw_queries, "{context}: {stats:?}");
}

#[test]
fn every_blocking_method_is_exact() {
    let mut sums = [0; 2];
    for seed in 0..600 {
        let [drawn, all] = verify(seed);
        sums = [sums[0] + drawn, sums[1] + all];
    }
    let [drawn, all] = sums;
    assert!(drawn * 3 < all * 2, "nothing was culled: {drawn} of {all}");
}

/// Returns a city of solid blocks.
fn streets() -> (Scene, Hierarchy) {
    let scene = Scene::solid(city(&mut Random::new(3), 12));
    let hierarchy = Hierarchy::build(&scene.bounds).unwrap();
    (scene, hierarchy)
}

/// Runs the frames of a slow walk ahead and returns their counts.
fn stroll(kind: BlockingKind, trouble: Trouble) -> Vec<BlockingStats> {
    let (scene, hierarchy) = streets();
    let mut blocking = BlockingCuller::new(kind);
    let mut talk = Talk::new(SIZE, 8, trouble, 1);
    let solids = Solids { solids: &scene.solids, shifts: &scene.shifts };
    let step = |frame: u64| {
        let eye = STREET.eye - Vec3::Z * frame as f32 * 0.05;
        let view = CullView::new(&Camera { eye, ..STREET }, SIZE, 8);
        let mut decisions = blocking.begin(&hierarchy, &view);
        talk.frame(&mut decisions, &view, &hierarchy, &solids)
    };
    (0..40).map(step).collect()
}

fn sum(frames: &[BlockingStats], of: impl Fn(&BlockingStats) -> u32) -> u32 {
    frames.iter().map(of).sum()
}

#[test]
fn each_method_costs_what_it_is_known_for() {
    let walk = |kind| stroll(kind, Trouble { polls: 3, ..Trouble::default() });
    let [naive, batched, stop, chc] = default_kinds().map(walk);
    // Skips the first frames, which have no history.
    let naive = &naive[5..];
    let batched = &batched[5..];
    let stop = &stop[5..];
    let chc = &chc[5..];
    assert_eq!(sum(naive, |stats| stats.waits), sum(naive, |stats| stats.boxes), "a wait a query");
    assert_eq!(sum(stop, |stats| stats.waits), sum(stop, |stats| stats.boxes), "a wait a node");
    assert!(sum(batched, |stats| stats.waits) <= 2 * batched.len() as u32, "a wait for all");
    assert!(sum(chc, |stats| stats.waits) * 8 < sum(stop, |stats| stats.waits), "{chc:?} {stop:?}");
    let tested =
        |blocking_stats: &BlockingStats| blocking_stats.boxes + blocking_stats.visible_draw_queries;
    assert!(sum(chc, tested) * 2 < sum(stop, tested), "visible inner nodes are not tested");
    assert!(sum(stop, tested) < sum(naive, tested), "hidden nodes are tested as one");
    assert!(
        sum(batched, |stats| stats.draws) > sum(naive, |stats| stats.draws),
        "tests cannot profit"
    );
}

#[test]
fn a_blocking_method_ends_if_no_answer_ever_comes() {
    let silence = Trouble { lost: 1.0, ..Trouble::default() };
    for kind in default_kinds() {
        let frames = stroll(kind, silence);
        // Every object in the frustum is drawn, as with frustum culling.
        let (_, hierarchy) = streets();
        let view = CullView::new(&STREET, SIZE, 8);
        let mut plan = antumbra_cull::FramePlan::default();
        let mut culler = antumbra_cull::Culler::new(antumbra_cull::CullConfig::default());
        culler.plan(&hierarchy, Strategy::FRUSTUM, &view, 0, &mut plan);
        assert_eq!(frames[0].draws as usize, plan.draws.len(), "{kind:?}");
    }
}

#[test]
fn what_is_assumed_visible_is_not_asked_about() {
    let walk = |assumed_visible_frames| {
        let chc = ChcOptions { assumed_visible_frames, ..ChcOptions::default() };
        stroll(BlockingKind::Chc(chc), Trouble::default())
    };
    let never = walk(0);
    let three = walk(3);
    let visible_draw_queries =
        |frames: &[BlockingStats]| sum(&frames[5..], |stats| stats.visible_draw_queries);
    assert!(visible_draw_queries(&three) * 3 < visible_draw_queries(&never), "{never:?} {three:?}");
    assert!(sum(&three, |stats| stats.draws) >= sum(&never, |stats| stats.draws));
}

#[test]
fn a_threshold_draws_less_and_is_not_exact() {
    let walk = |visibility_threshold_samples| {
        let chc = ChcOptions { visibility_threshold_samples, ..ChcOptions::default() };
        sum(&stroll(BlockingKind::Chc(chc), Trouble::default()), |stats| stats.draws)
    };
    assert!(walk(20) < walk(0));
}

#[test]
fn no_objects_and_none_in_sight_are_no_words() {
    let nothing = Hierarchy::build(&[]).unwrap();
    let (scene, city) = streets();
    let solids = Solids { solids: &scene.solids, shifts: &scene.shifts };
    for kind in default_kinds() {
        let mut blocking = BlockingCuller::new(kind);
        let mut talk = Talk::new(SIZE, 8, Trouble::default(), 1);
        let away = Camera { eye: Vec3::Y * 500.0, forward: Vec3::Y, up: Vec3::X, ..STREET };
        for (hierarchy, camera) in [(&nothing, STREET), (&city, away)] {
            let view = CullView::new(&camera, SIZE, 8);
            let mut decisions = blocking.begin(hierarchy, &view);
            let stats = talk.frame(&mut decisions, &view, hierarchy, &solids);
            assert_eq!((stats.draws, stats.boxes, stats.waits), (0, 0, 0), "{kind:?}");
        }
    }
}
