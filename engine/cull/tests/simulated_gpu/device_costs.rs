//! Tests on devices with invented costs: the choice at start, from a handful of timed batches, is
//! the choice with the least cost over frames that are planned, executed and charged event by
//! event.

use antumbra_cull::{
    Camera, CostTable, CullConfig, CullView, Culler, FrameContents, FramePlan, Hierarchy,
    LearnedCosts, MeasuredSkip, Projection, SceneCosts, SkipTimes, SkippedWork, Strategy,
    VisibilityTest, VisibilityTestSupport,
};
use glam::Vec3;

use crate::device::{Device, Mishaps, Solids};
use crate::random::Random;
use crate::scene::{Scene, city};

const SIZE: [u32; 2] = [96, 64];

/// The number of triangles per object.
const TRIANGLES: f32 = 100.0;

/// The costs of events on a device (ns).
#[derive(Clone, Copy, Debug)]
struct Events {
    /// A block of conditional rendering.
    predicate: f64,
    /// An indirect call, of any number of draws.
    call: f64,
    /// An indirect draw without instances.
    empty_draw: f64,
    /// A compute pass between barriers.
    pass: f64,
    /// A word that a compute pass reads for a decision or writes.
    word: f64,
    query: f64,
    box_draw: f64,
    flag_box: f64,
    pixel: f64,
    /// A break of rendering, which stores and loads the attachments.
    load_and_store: f64,
    compute_round: f64,
    compute_box: f64,
    triangle: f64,
}

/// A device without weaknesses: a medium desktop GPU.
const EVEN: Events = Events {
    predicate: 60.0,
    call: 60.0,
    empty_draw: 4.0,
    pass: 8_000.0,
    word: 0.4,
    query: 150.0,
    box_draw: 80.0,
    flag_box: 8.0,
    pixel: 0.05,
    load_and_store: 6_000.0,
    compute_round: 40_000.0,
    compute_box: 10.0,
    triangle: 1.0,
};

/// NVK, according to reports: a copy, a flush and many words per block, and a wait per query.
const SLOW_PREDICATE: Events = Events { predicate: 4_000.0, query: 3_000.0, ..EVEN };

/// ANV, according to reports: a generation shader per indirect call, even if its predicate is 0.
const SLOW_CALL: Events = Events { call: 3_000.0, ..EVEN };

/// MoltenVK and Adreno, according to reports: queries are expensive, and blocks flush caches.
const SLOW_QUERIES: Events =
    Events { query: 20_000.0, box_draw: 400.0, predicate: 3_000.0, ..EVEN };

/// A tiler: a break moves both attachments, and fragments that write memory are not rejected early.
const TILER: Events = Events {
    load_and_store: 30_000.0,
    pixel: 4.0,
    flag_box: 40.0,
    compute_round: 12_000.0,
    ..EVEN
};

const DEVICES: [(&str, Events); 5] = [
    ("even", EVEN),
    ("slow predicate", SLOW_PREDICATE),
    ("slow call", SLOW_CALL),
    ("slow queries", SLOW_QUERIES),
    ("tiler", TILER),
];

/// The ways to skip draws, in the order in which they are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Executor {
    Conditional,
    Counts,
    Instances,
    Compacted,
}

const EXECUTORS: [Executor; 4] =
    [Executor::Conditional, Executor::Counts, Executor::Instances, Executor::Compacted];

impl Executor {
    /// Returns the time of a round of these ranges if all of their draws are skipped.
    fn round_ns(self, events: &Events, ranges: u32, draws: u32) -> f64 {
        let ranges = f64::from(ranges);
        let draws = f64::from(draws);
        let Events { predicate, call, empty_draw, pass, word, .. } = *events;
        match self {
            Self::Conditional => ranges * (predicate + call),
            Self::Counts => pass + ranges * (word + call),
            Self::Instances => pass + ranges * call + draws * (word + empty_draw),
            Self::Compacted => 2.0 * pass + call + ranges * 2.0 * word,
        }
    }

    /// Times the batches of the calibration.
    fn times(self, events: &Events) -> SkipTimes {
        let few = SkipTimes::RANGES;
        let time = |ranges, draws| 50_000.0 + self.round_ns(events, ranges, draws);
        SkipTimes {
            nothing_ns: 50_000.0,
            few_ns: time(few, few),
            many_ns: time(2 * few, 2 * few),
            wide_ns: time(few, few * SkipTimes::WIDE_DRAWS),
        }
    }
}

impl Events {
    /// Returns the cost table that results from timed batches, without the way to skip draws.
    fn table(&self) -> CostTable {
        CostTable {
            query_ns: self.query as f32,
            query_box_ns: self.box_draw as f32,
            flag_box_ns: self.flag_box as f32,
            hidden_pixel_ns: self.pixel as f32,
            flagged_pixel_ns: 2.0 * self.pixel as f32,
            call_ns: self.call as f32,
            draw_ns: 10.0,
            triangle_ns: self.triangle as f32,
            break_ns: self.load_and_store as f32,
            break_wait_share: 0.0,
            compute_round_ns: self.compute_round as f32,
            compute_box_ns: self.compute_box as f32,
            ..CostTable::uniform(0.0)
        }
    }

    /// Charges a frame that drew `drawn` objects.
    fn frame_ns(&self, executor: Executor, plan: &FramePlan, drawn: usize) -> f64 {
        let contents = FrameContents::of(plan);
        let rounds = plan.rounds.iter().map(|round| {
            let ranges = plan.tests[round.clone()].iter().filter(|test| test.leaves.count > 0);
            let draws: u32 = ranges.clone().map(|test| test.leaves.count).sum();
            match ranges.count() as u32 {
                0 => 0.0,
                ranges => executor.round_ns(self, ranges, draws),
            }
        });
        let rastered: f64 = contents.proxy_pixels as f64 * self.pixel;
        rounds.sum::<f64>()
            + drawn as f64 * (10.0 + f64::from(TRIANGLES) * self.triangle)
            + f64::from(contents.queries) * self.query
            + plan.queried_draws.len() as f64 * 2.0 * self.call
            + f64::from(contents.queried_boxes) * self.box_draw
            + f64::from(contents.flagged_boxes) * self.flag_box
            + f64::from(contents.computed_boxes) * self.compute_box
            + f64::from(contents.computed_rounds) * self.compute_round
            + rastered
            + f64::from(contents.breaks) * self.load_and_store
    }
}

/// Returns the time of a walk through a city on a device (ns), by a strategy and an executor.
fn walk_ns(events: &Events, executor: Executor, strategy: Strategy) -> f64 {
    let scene = Scene::solid(city(&mut Random::new(3), 40));
    let hierarchy = Hierarchy::build(&scene.bounds).unwrap();
    let mut culler = Culler::with_testers(CullConfig::default(), TESTERS);
    let table = events.table().skipping_at(&executor.times(events).costs());
    culler.set_costs(table, SceneCosts { triangles_per_leaf: TRIANGLES }).unwrap();
    let mut device = Device::new(SIZE, 8, Mishaps::none(2), 1);
    let mut plan = FramePlan::default();
    let mut sum_ns = 0.0;
    for frame in 0..100 {
        let camera = Camera {
            eye: Vec3::new(-1.0, 1.7, 150.0 - 0.5 * frame as f32),
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(1.2),
            near: 0.1,
        };
        let view = CullView::new(&camera, SIZE, 8);
        let answers = device.collect(culler.frame().0 + 1, &hierarchy);
        culler.ingest(&hierarchy, answers);
        culler.plan(&hierarchy, strategy, &view, 4_096, &mut plan);
        let solids = Solids { solids: &scene.solids, shifts: &scene.shifts };
        device.execute(&view, &hierarchy, &solids, &plan);
        sum_ns += events.frame_ns(executor, &plan, device.drawn.len());
    }
    sum_ns
}

const TESTERS: VisibilityTestSupport = VisibilityTestSupport {
    queries: true,
    flags: true,
    compute: true,
    leaf_tests: false,
    draw_phases: antumbra_cull::DrawPhases::PerRound,
};

fn work() -> SkippedWork {
    SkippedWork::of_leaves(Scene::solid(city(&mut Random::new(3), 40)).bounds.len() as u32)
}

/// Returns the choice on a device before the first frame.
fn chosen(events: &Events) -> (Executor, VisibilityTest) {
    let ways = EXECUTORS.map(|executor| {
        let costs = executor.times(events).costs();
        MeasuredSkip { costs, rounds: vec![costs; 4] }
    });
    let executor = EXECUTORS[MeasuredSkip::cheapest(&ways, &work()).unwrap()];
    let table = events.table().skipping_at(&executor.times(events).costs());
    let costs = SceneCosts { triangles_per_leaf: TRIANGLES };
    let model = LearnedCosts::new(table, costs).unwrap();
    (executor, model.tester_for(&work(), SIZE, TESTERS))
}

#[test]
fn the_chosen_executor_costs_least_over_frames() {
    for (name, events) in DEVICES {
        let (executor, _) = chosen(&events);
        let all = EXECUTORS.map(|executor| walk_ns(&events, executor, Strategy::ANTUMBRA));
        let best = all.into_iter().fold(f64::INFINITY, f64::min);
        let own = walk_ns(&events, executor, Strategy::ANTUMBRA);
        println!("{name}: {executor:?} of {:?} us", all.map(|ns| (ns / 1e3).round()));
        // A smaller difference between executors is not worth a change.
        assert!(own <= 1.25 * best, "{name}: {executor:?} takes {own} ns, the best {best} ns");
    }
}

#[test]
fn a_weakness_is_avoided() {
    let executor = |events: &Events| chosen(events).0;
    assert_eq!(executor(&EVEN), Executor::Conditional);
    assert_ne!(executor(&SLOW_PREDICATE), Executor::Conditional);
    assert_eq!(executor(&SLOW_CALL), Executor::Compacted);
    assert_ne!(executor(&SLOW_QUERIES), Executor::Conditional);
    let tester = |events: &Events| chosen(events).1;
    for events in [EVEN, SLOW_PREDICATE, SLOW_CALL, SLOW_QUERIES] {
        assert_eq!(tester(&events), VisibilityTest::Flag, "{events:?}");
    }
    assert_eq!(tester(&TILER), VisibilityTest::Compute);
}

#[test]
fn the_tester_by_cost_costs_no_more_than_the_best_fixed_one() {
    for (name, events) in DEVICES {
        let (executor, tester) = chosen(&events);
        let fixed = [
            (VisibilityTest::Query, Strategy::ANTUMBRA_QUERIES),
            (VisibilityTest::Flag, Strategy::ANTUMBRA_FLAGS),
            (VisibilityTest::Compute, Strategy::ANTUMBRA_COMPUTE),
        ];
        let fixed = fixed.map(|(tester, strategy)| (walk_ns(&events, executor, strategy), tester));
        let (best_ns, _) = fixed.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        let open_ns = walk_ns(&events, executor, Strategy::ANTUMBRA);
        let frustum_ns = walk_ns(&events, executor, Strategy::FRUSTUM);
        println!("{name}: {tester:?}, {open_ns} ns, frustum {frustum_ns} ns, of {fixed:?}");
        assert!(open_ns <= 1.05 * best_ns, "{name}: {open_ns} ns, fixed {fixed:?}");
        assert!(open_ns < frustum_ns, "{name}: {open_ns} ns against {frustum_ns} ns untested");
        let (own_ns, _) = fixed.into_iter().find(|(_, known)| *known == tester).unwrap();
        assert!(own_ns <= 1.1 * best_ns, "{name}: {tester:?} of {fixed:?}");
    }
}
