//! Tests of corrections: the times of frames correct wrong costs, within a bounded time, not
//! because of noise, and without effect on the image.

use std::collections::VecDeque;

use antumbra_cull::{
    Camera, Corrections, CostTable, FrameContents, FramePlan, Projection, VisibilityTest,
};
use glam::Vec3;

use crate::random::Random;
use crate::scene::city;
use crate::walk::Walk;

/// The number of frames until a frame's time is read back.
const LATENCY: u64 = 2;

/// The time of a frame without draws and tests.
const REST_NS: f64 = 3.0e6;

/// The number of frames within which tests at five times the table's costs are detected ...
const FOUND_FRAMES: usize = 240;
/// ... and within which it is detected that tests no longer cost this, or never did.
const RESUMED_FRAMES: usize = 600;

fn table() -> CostTable {
    let queries = CostTable { query_ns: 1_500.0, query_box_ns: 1_000.0, ..CostTable::default() };
    CostTable { break_ns: 5_000.0, break_wait_share: 0.05, ..queries }
}

/// Returns the costs of the same device with tests and breaks that cost `times` times the table's.
fn dearer(times: f32) -> CostTable {
    let learned = table();
    CostTable {
        query_ns: times * learned.query_ns,
        query_box_ns: times * learned.query_box_ns,
        hidden_pixel_ns: times * learned.hidden_pixel_ns,
        predicate_ns: times * learned.predicate_ns,
        skipped_draw_ns: times * learned.skipped_draw_ns,
        call_ns: times * learned.call_ns,
        break_ns: times * learned.break_ns,
        break_wait_share: times * learned.break_wait_share,
        ..learned
    }
}

/// A walk through a city on a device whose true costs are not in the cost model.
struct Clocked {
    walk: Walk,
    camera: Camera,
    frame: u32,
    /// The factor by which tests are more expensive than the table says.
    tests: f32,
    learns: bool,
    /// The relative error of the times.
    noise: f32,
    /// The interval between frames that take ten times as long; 0 for none.
    odd_one_in: usize,
    random: Random,
    under_way: VecDeque<(f64, FrameContents)>,
}

impl Clocked {
    fn new(told: CostTable, seed: u64) -> Self {
        let boxes = city(&mut Random::new(3), 24);
        Self {
            walk: Walk::cost_driven(boxes, LATENCY, told),
            camera: Camera {
                eye: Vec3::new(-1.0, 1.7, 0.0),
                forward: Vec3::NEG_Z,
                up: Vec3::Y,
                projection: Projection::perspective(1.2),
                near: 0.1,
            },
            frame: 0,
            tests: 1.0,
            learns: true,
            noise: 0.05,
            odd_one_in: 0,
            random: Random::new(seed),
            under_way: VecDeque::new(),
        }
    }

    /// Steps back and forth in a street and looks around, so that the visible and the tested
    /// objects differ from frame to frame.
    fn step(&mut self) {
        let time = self.frame as f32;
        self.frame += 1;
        self.camera.eye.z = 60.0 * (time * 0.01).sin();
        let angle = 1.2 * (time * 0.07).sin();
        self.camera.forward = Vec3::new(angle.sin(), 0.0, -angle.cos());
        self.walk.step(&self.camera);
        if self.learns {
            self.observe();
        }
    }

    fn observe(&mut self) {
        let plan = &self.walk.plan;
        let draws = self.walk.device.drawn.len() as u64;
        let contents = FrameContents { draws, triangles: 100 * draws, ..FrameContents::of(plan) };
        let clean = REST_NS + cost_ns(plan, draws, &dearer(self.tests));
        let noisy = clean * f64::from(1.0 + self.random.between(-self.noise, self.noise));
        let is_odd = self.odd_one_in > 0 && self.random.below(self.odd_one_in) == 0;
        self.under_way.push_back((if is_odd { 10.0 * noisy } else { noisy }, contents));
        if self.under_way.len() > LATENCY as usize {
            let (gpu_ns, contents) = self.under_way.pop_front().unwrap();
            self.walk.culler.cost_model_mut().unwrap().observe(gpu_ns, &contents);
        }
    }

    /// Returns the number of tests of single leaves over `frames` frames, and checks that every
    /// eighth frame is exact.
    fn single_tests(&mut self, frames: usize) -> usize {
        let mut single = 0;
        for _ in 0..frames {
            self.step();
            let is_compared = self.frame.is_multiple_of(8);
            assert!(!is_compared || self.walk.is_exact(&self.camera), "frame {}", self.frame);
            let tests = self.walk.plan.tests.iter();
            single += tests.filter(|test| test.leaves.count == 1).count();
        }
        single
    }

    fn corrections(&self) -> Corrections {
        self.walk.culler.learned_costs().unwrap().corrections()
    }

    /// Steps until `is_found` accepts the proportion, and returns the number of frames.
    fn until(&mut self, most: usize, is_found: impl Fn(f32) -> bool) -> usize {
        for frames in 0..most {
            if is_found(self.corrections().proportion) {
                return frames;
            }
            self.step();
        }
        panic!("not within {most} frames: {:?}", self.corrections());
    }
}

/// Returns the time of a frame's draws and tests, computed from the plan.
fn cost_ns(plan: &FramePlan, draws: u64, costs: &CostTable) -> f64 {
    assert!(plan.tests.iter().all(|test| test.tester == VisibilityTest::Query));
    let drawing = draws as f64 * f64::from(costs.leaf_ns(100.0));
    let boxes = plan.tests.len() as f64 * f64::from(costs.query_ns + costs.query_box_ns);
    let own_ns = f64::from(costs.query_ns) + 2.0 * f64::from(costs.call_ns);
    let own = plan.queried_draws.len() as f64 * own_ns;
    let pixels = plan.stats.proxy_pixels as f64 * f64::from(costs.hidden_pixel_ns);
    let predicated = plan.tests.iter().filter(|test| test.leaves.count > 0).count();
    let leaves: u32 = plan.tests.iter().map(|test| test.leaves.count).sum();
    let skipped = f64::from(leaves) - predicated as f64;
    let predicates = predicated as f64 * f64::from(costs.predicate_ns)
        + skipped * f64::from(costs.skipped_draw_ns);
    let breaks = plan.rounds.len() as f64 * f64::from(costs.break_ns);
    let waits = if plan.rounds.is_empty() { 0.0 } else { costs.break_wait_share.into() };
    drawing * (1.0 + waits) + boxes + own + pixels + predicates + breaks
}

#[test]
fn tests_that_are_dearer_than_told_end_where_they_do_not_pay_and_come_back() {
    for seed in 0..3 {
        // The decisions with right costs, and with costs that are five times too low.
        let mut right = Clocked { learns: false, ..Clocked::new(dearer(5.0), seed) };
        let mut wrong = Clocked { learns: false, ..Clocked::new(table(), seed) };
        let mut learning = Clocked { tests: 5.0, ..Clocked::new(table(), seed) };
        let found = learning.until(FOUND_FRAMES, |proportion| proportion > 2.5);
        let before = FOUND_FRAMES - found;
        for walk in [&mut right, &mut wrong] {
            walk.single_tests(FOUND_FRAMES);
        }
        learning.single_tests(before);
        let [right, wrong_tests, learned] =
            [&mut right, &mut wrong, &mut learning].map(|walk| walk.single_tests(300));
        println!(
            "found after {found} frames: {learned} tests, {right} by right costs, {wrong_tests} by wrong ones, {:?}",
            learning.corrections()
        );
        assert!(right * 3 < wrong_tests, "these costs decide nothing");
        assert!(learned * 2 < wrong_tests, "{learned} tests, {wrong_tests} by wrong costs");

        learning.tests = 1.0;
        let resumed = learning.until(RESUMED_FRAMES, |proportion| proportion < 1.2);
        let resumed_tests = learning.single_tests(300);
        println!("resumed after {resumed} frames: {resumed_tests} tests");
        assert!(resumed_tests * 10 > wrong_tests * 6, "{resumed_tests} of {wrong_tests}");
    }
}

#[test]
fn tests_that_are_cheaper_than_told_are_made() {
    for seed in 0..3 {
        let mut told = Clocked { learns: false, ..Clocked::new(dearer(5.0), seed) };
        let mut learning = Clocked { noise: 0.02, ..Clocked::new(dearer(5.0), seed) };
        let found = learning.until(RESUMED_FRAMES, |proportion| proportion < 0.5);
        told.single_tests(RESUMED_FRAMES);
        learning.single_tests(RESUMED_FRAMES - found);
        let [told, learned] = [&mut told, &mut learning].map(|walk| walk.single_tests(300));
        println!(
            "found after {found} frames: {learned} tests, {told} by the table, {:?}",
            learning.corrections()
        );
        assert!(learned * 2 > told * 3, "{learned} tests, {told} by the table");
    }
}

#[test]
fn noise_and_odd_frames_flip_no_decision() {
    for seed in 0..4 {
        let mut calm = Clocked { learns: false, ..Clocked::new(table(), seed) };
        let mut noisy = Clocked { noise: 0.3, odd_one_in: 20, ..Clocked::new(table(), seed) };
        let mut changes = 0;
        let mut last = 1.0;
        for frame in 0..1_500 {
            calm.step();
            noisy.step();
            let proportion = noisy.corrections().proportion;
            changes += usize::from(proportion != last);
            last = proportion;
            assert!((0.75..1.34).contains(&proportion), "frame {frame}: {proportion}");
        }
        println!("{changes} changes, {:?}", noisy.corrections());
        assert!(changes < 30, "{changes} changes in 1500 frames");
        let [told, learned] = [&mut calm, &mut noisy].map(|walk| walk.single_tests(300));
        assert!(learned * 4 > told * 3 && learned * 3 < told * 4, "{learned} tests, {told}");
    }
}

#[test]
fn nonsense_teaches_nothing() {
    let mut walk = Clocked { learns: false, ..Clocked::new(table(), 1) };
    for frame in 0..200 {
        walk.step();
        assert!(walk.walk.is_exact(&walk.camera), "frame {frame}");
        let contents = FrameContents { draws: 100, triangles: 10_000, ..Default::default() };
        let learned_costs = walk.walk.culler.cost_model_mut().unwrap();
        for gpu_ns in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1.0e30, f64::MIN_POSITIVE] {
            learned_costs.observe(gpu_ns, &contents);
        }
        learned_costs.observe(1.0e7, &FrameContents::default());
        let endless = FrameContents {
            draws: u64::MAX,
            triangles: u64::MAX,
            queries: u32::MAX,
            proxy_pixels: u64::MAX,
            ..FrameContents::default()
        };
        learned_costs.observe(1.0e7, &endless);
    }
    assert_eq!(walk.corrections(), Corrections::default());
}
