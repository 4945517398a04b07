//! Tests that the image is the same as with everything drawn, whatever happens to the answers.

use antumbra_cull::{
    Camera, CostTable, CullConfig, CullTuning, CullView, Culler, DrawPhases, FramePlan, Hierarchy,
    NodeState, ObjectId, SceneCosts, Strategy, VisibilityTest, VisibilityTestSupport,
};

use crate::device::{Device, Mishaps, Solids, draw_caps, seen};
use crate::image::Image;
use crate::invariants;
use crate::random::{Random, seeds};
use crate::scene::{Lens, PATHS, Path, Place, Scene};
use crate::section::Cuts;

const SCENES: u64 = 600;
const FRAMES: u64 = 24;
const LATENCIES: std::ops::RangeInclusive<u64> = 1..=4;
const THREADS: u64 = 2;
const SIZE: [u32; 2] = [40, 28];

/// One strategy at one latency in one scene.
struct Run {
    strategy: Strategy,
    culler: Culler,
    draw_phases: DrawPhases,
    device: Device,
    plan: FramePlan,
}

/// The world of a seed.
struct World {
    random: Random,
    scene: Scene,
    hierarchy: Hierarchy,
    /// The camera relative to the origin of the scene; the scene's place is applied afterwards.
    camera: Camera,
    place: Place,
    lens: Lens,
    path: Path,
    sub_pixel_bits: u32,
    budget: usize,
    moving: bool,
    rebuilding: bool,
    /// True for an extreme configuration that is not used in practice.
    is_extreme: bool,
    /// The moving section planes.
    cuts: Cuts,
}

impl World {
    fn new(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let sub_pixel_bits = [4, 8][random.below(2)];
        let scene = Scene::random(&mut random, sub_pixel_bits);
        let mut camera = Path::start(&mut random);
        Self {
            hierarchy: Hierarchy::build(&scene.bounds).unwrap(),
            lens: Lens::random(&mut random, &mut camera),
            camera,
            place: Place::HERE,
            path: PATHS[random.below(PATHS.len())],
            sub_pixel_bits,
            budget: [0, 3, 12, 10_000, 10_000, 10_000][random.below(6)],
            moving: random.chance(0.4),
            rebuilding: random.chance(0.3),
            is_extreme: false,
            cuts: Cuts::default(),
            scene,
            random,
        }
    }

    /// Returns the world of a seed, scaled, at a random place with this largest coordinate
    /// (metres).
    fn far(seed: u64, coordinate: f32, scale: f32) -> Self {
        let mut world = Self::new(seed);
        let towards = world.random.point(-1.0, 1.0);
        let origin = towards / towards.abs().max_element() * coordinate;
        let place = Place { origin, scale };
        let scene = world.scene.placed(place);
        Self {
            hierarchy: Hierarchy::build(&scene.bounds).unwrap(),
            scene,
            place,
            lens: world.lens.scaled(scale),
            camera: Camera { near: world.camera.near.max(0.1), ..world.camera },
            moving: false,
            ..world
        }
    }

    fn runs(&mut self, seed: u64) -> Vec<Run> {
        // A small number of wished tests, because coarser plans must also be exact.
        let tests_wished = match seed % 8 {
            0 => 4,
            1 => 40,
            _ => CullConfig::default().tests_wished,
        };
        let mut config = CullConfig { seed, tests_wished, ..CullConfig::default() };
        if self.is_extreme {
            config = extreme_config(&mut self.random, config);
        }
        let is_rough = self.random.chance(0.7);
        let table = self.random.chance(0.3).then(|| random_costs(&mut self.random));
        let mut runs = Vec::new();
        let testers = VisibilityTestSupport {
            queries: self.random.chance(0.8),
            flags: self.random.chance(0.5),
            compute: self.random.chance(0.5),
            leaf_tests: self.random.chance(0.6),
            draw_phases: [DrawPhases::PerRound, DrawPhases::Two][self.random.below(2)],
        };
        let ours = [Strategy::ANTUMBRA, Strategy::ANTUMBRA_COMPUTE][self.random.below(2)];
        for strategy in [Strategy::FRUSTUM, ours] {
            for latency in LATENCIES {
                let calm = Mishaps::none(latency);
                let rough = Mishaps { late: 0.3, lost: 0.2, twice: 0.2, listed: 6, ..calm };
                let mishaps = if is_rough { rough } else { calm };
                let mut culler = Culler::with_testers(config, testers);
                if let Some(table) = table {
                    culler.set_costs(table, SceneCosts { triangles_per_leaf: 100.0 }).unwrap();
                }
                runs.push(Run {
                    strategy,
                    culler,
                    draw_phases: testers.draw_phases,
                    device: Device::new(SIZE, self.sub_pixel_bits, mishaps, seed ^ latency),
                    plan: FramePlan::default(),
                });
            }
        }
        runs
    }

    /// Advances everything by a frame.
    fn advance(&mut self, frame: u64) -> CullView {
        self.path.advance(&mut self.camera, frame, &mut self.random);
        if self.moving {
            for _ in 0..3 {
                let object = self.scene.move_one(&mut self.random);
                let moved = (ObjectId(object as u32), self.scene.bounds[object]);
                self.hierarchy.refit([moved]).unwrap();
            }
        }
        if self.rebuilding && frame % 6 == 5 {
            self.hierarchy.rebuild(&self.scene.bounds).unwrap();
        }
        let view =
            self.lens.view(&self.place.camera(&self.camera), frame, SIZE, self.sub_pixel_bits);
        CullView { section: self.cuts.drag(&mut self.random), ..view }
    }

    fn solids(&self) -> Solids<'_> {
        Solids { solids: &self.scene.solids, shifts: &self.scene.shifts }
    }
}

/// Returns a configuration in which each constant may have its least or greatest value.
fn extreme_config(random: &mut Random, usual: CullConfig) -> CullConfig {
    let mut config = usual;
    let CullConfig {
        unknown_leaves,
        retest_max,
        visible_box_frames,
        rounds_calm,
        tests_wished,
        seed: _,
        tuning,
    } = &mut config;
    let CullTuning {
        unknown_leaves_far,
        unknown_angle,
        growth_frames,
        growth_frames_per_leaf,
        edge_leaves,
        turning_frames,
        turning_sine,
        stale_frames,
        open_frames,
        open_jitter,
        open_levels,
        open_leaves,
        open_levels_max,
        retest_first,
        retest_spread,
        retest_gate,
        visible_box_angle,
        visible_box_tests,
        flicker_retest_max,
        pull_up_backoff,
        tests_per_pull_up,
        occluders,
        cut_share,
        cut_tests,
        rounds_cut,
        rounds_compute_calm,
        rounds_compute_cut,
        round_tests_min,
        per_leaf_min,
    } = tuning;
    for number in [
        unknown_leaves,
        unknown_leaves_far,
        growth_frames,
        growth_frames_per_leaf,
        edge_leaves,
        turning_frames,
        stale_frames,
        open_frames,
        open_jitter,
        open_levels,
        open_leaves,
        open_levels_max,
        retest_first,
        retest_max,
        retest_spread,
        retest_gate,
        visible_box_frames,
        visible_box_tests,
        flicker_retest_max,
        pull_up_backoff,
        tests_per_pull_up,
        occluders,
        cut_share,
        cut_tests,
        rounds_calm,
        rounds_cut,
        rounds_compute_calm,
        rounds_compute_cut,
        round_tests_min,
        per_leaf_min,
        tests_wished,
    ] {
        *number = [0, 1, u32::MAX, *number, *number, *number][random.below(6)];
    }
    for number in [unknown_angle, turning_sine, visible_box_angle] {
        *number = [0.0, f32::NAN, f32::INFINITY, *number, *number][random.below(5)];
    }
    config
}

/// Returns costs from 0 to more than a test can save, each chosen independently.
fn random_costs(random: &mut Random) -> CostTable {
    let mut cost = |usual: f32| match random.below(5) {
        0 => 0.0,
        1 => f32::MAX,
        _ => usual * 10.0_f32.powf(random.between(-2.0, 2.0)),
    };
    let usual = CostTable::default();
    CostTable {
        query_ns: cost(usual.query_ns),
        query_box_ns: cost(usual.query_box_ns),
        flag_box_ns: cost(usual.flag_box_ns),
        hidden_pixel_ns: cost(usual.hidden_pixel_ns),
        flagged_pixel_ns: cost(usual.flagged_pixel_ns),
        predicate_ns: cost(usual.predicate_ns),
        skipped_draw_ns: cost(usual.skipped_draw_ns),
        call_ns: cost(usual.call_ns),
        draw_ns: cost(usual.draw_ns),
        triangle_ns: cost(usual.triangle_ns),
        // Mostly low, because one break decides about all tests of a frame.
        break_ns: cost(1_000.0),
        break_wait_share: random.between(0.0, 1.0) * random.between(0.0, 1.0),
        compute_round_ns: 0.0,
        compute_box_ns: 0.0,
    }
}

/// The counts of the checked cases.
#[derive(Debug, Default)]
struct Checked {
    runs: u64,
    frames: u64,
    /// Tests that shared the result of another.
    behind: u64,
    /// Leaves that were not tested because of the cost.
    untested: u64,
    /// Boxes of visible leaves that were tested between two phases of draws.
    visible_boxes: u64,
    /// Objects drawn, with frustum culling and with the strategy.
    drawn: [u64; 2],
}

impl Checked {
    fn and(self, other: Self) -> Self {
        Self {
            runs: self.runs + other.runs,
            frames: self.frames + other.frames,
            behind: self.behind + other.behind,
            untested: self.untested + other.untested,
            visible_boxes: self.visible_boxes + other.visible_boxes,
            drawn: [0, 1].map(|strategy| self.drawn[strategy] + other.drawn[strategy]),
        }
    }
}

/// Runs one seed.
fn verify(seed: u64) -> Checked {
    verify_world(seed, World::new(seed))
}

fn verify_world(seed: u64, mut world: World) -> Checked {
    let mut runs = world.runs(seed);
    let mut truth = Image::new(SIZE);
    let mut checked = Checked { runs: runs.len() as u64, ..Checked::default() };
    for frame in 0..FRAMES {
        let view = world.advance(frame);
        truth.clear();
        draw_caps(&mut truth, &view, &world.hierarchy, &world.scene.solids);
        let objects = world.scene.solids.iter().zip(&world.scene.shifts);
        for (object, (solid, shift)) in (0..).zip(objects) {
            truth.draw(&seen(&world.hierarchy, object, &view), solid, *shift);
        }
        for run in &mut runs {
            let answers = run.device.collect(run.culler.frame().0 + 1, &world.hierarchy);
            run.culler.ingest(&world.hierarchy, answers);
            run.culler.plan(&world.hierarchy, run.strategy, &view, world.budget, &mut run.plan);
            let context = || format!("seed {seed}, frame {frame}, {}", run.strategy);
            invariants::check(&world.hierarchy, run.strategy, &view, world.budget, &run.plan)
                .unwrap_or_else(|broken| panic!("{}: {broken}", context()));
            for test in &run.plan.tests {
                let VisibilityTest::SharedProxy(front) = test.tester else { continue };
                let front = run.plan.tests[front as usize].tag.node;
                let state = run.culler.state(front);
                assert_eq!(state, NodeState::Hidden, "{}: what answers for others", context());
            }
            let is_two = run.draw_phases == DrawPhases::Two;
            assert!(!is_two || run.plan.has_two_phases(), "{}: draws between tests", context());
            run.device.execute(&view, &world.hierarchy, &world.solids(), &run.plan);
            // A missing object with a visible pixel leaves a wrong depth in that pixel.
            assert!(run.device.images[0].depths == truth.depths, "{}: wrong pixels", context());
            checked.frames += 1;
            checked.behind += u64::from(run.plan.stats.shared_proxies);
            checked.untested += u64::from(run.plan.stats.untested_by_cost);
            let visible_boxes = run.plan.stats.visible_box_queries;
            checked.visible_boxes += u64::from(visible_boxes) * u64::from(is_two);
            let which = usize::from(run.strategy != Strategy::FRUSTUM);
            checked.drawn[which] += run.device.drawn.len() as u64;
        }
    }
    checked
}

#[test]
fn nothing_visible_is_ever_missing() {
    let scenes = seeds(SCENES);
    let workers: Vec<_> = (0..THREADS)
        .map(|worker| {
            std::thread::spawn(move || {
                (worker..scenes)
                    .step_by(THREADS as usize)
                    .map(verify)
                    .fold(Checked::default(), Checked::and)
            })
        })
        .collect();
    let checked = workers
        .into_iter()
        .map(|worker| worker.join().expect("a scene failed, see above"))
        .fold(Checked::default(), Checked::and);
    println!("{checked:?}");
    let combinations = 2 * LATENCIES.count() as u64;
    assert_eq!(checked.runs, scenes * combinations);
    assert_eq!(checked.frames, checked.runs * FRAMES);
    assert!(checked.behind > 400, "hardly a test answered for another");
    assert!(checked.untested > checked.frames / 20, "costs hardly ever decided");
    assert!(checked.visible_boxes > checked.frames / 10, "hardly a visible box was tested");
    let [frustum, ours] = checked.drawn;
    assert!(ours * 20 < frustum * 19, "nothing was culled: {ours} of {frustum}");
}

/// Checks the part of the margin for world coordinates: objects and proxies are drawn with
/// different matrices.
#[test]
fn nothing_visible_is_missing_far_from_the_origin() {
    for (coordinate, scale) in [(1.0e5, 10.0), (1.0e7, 1.0e3)] {
        let mut checked = Checked::default();
        for seed in 0..80 {
            checked = checked.and(verify_world(seed, World::far(seed, coordinate, scale)));
        }
        let [frustum, ours] = checked.drawn;
        assert!(ours * 20 < frustum * 19, "{coordinate}: culled to {ours} of {frustum}");
    }
}

/// Checks that nothing is missing while section planes move: parts that are cut away hide nothing,
/// and cut faces do.
#[test]
fn nothing_visible_is_missing_while_planes_are_dragged() {
    let mut checked = Checked::default();
    for seed in 0..seeds(24) {
        let mut world = World::new(seed);
        world.cuts = Cuts::random(&mut world.random, &mut world.hierarchy);
        checked = checked.and(verify_world(seed, world));
    }
    assert_eq!(checked.frames, checked.runs * FRAMES);
    let [frustum, ours] = checked.drawn;
    // Objects that are cut away are drawn if a proxy of several leaves shows.
    assert!(frustum > 0 && ours > 0, "nothing was drawn");
}

#[test]
fn no_policy_loses_anything_or_panics() {
    let mut checked = Checked::default();
    for seed in 0..200 {
        let world = World { is_extreme: true, ..World::new(seed) };
        checked = checked.and(verify_world(seed, world));
    }
    let [frustum, ours] = checked.drawn;
    assert!(ours < frustum, "nothing was culled: {ours} of {frustum}");
}

/// Checks that the test of exactness can fail: it notices if only every second object is drawn.
#[test]
fn missing_objects_are_noticed() {
    let mut noticed = 0;
    for seed in 0..40 {
        let mut world = World::new(seed);
        let view = world.advance(0);
        let mut truth = Image::new(SIZE);
        let mut without_last = Image::new(SIZE);
        let objects = world.scene.solids.iter().zip(&world.scene.shifts);
        for (number, (solid, shift)) in objects.enumerate() {
            truth.draw(&view, solid, *shift);
            if number % 2 == 0 {
                without_last.draw(&view, solid, *shift);
            }
        }
        noticed += u32::from(truth.depths != without_last.depths);
    }
    assert!(noticed > 10, "only {noticed} of 40 scenes show a missing object");
}
