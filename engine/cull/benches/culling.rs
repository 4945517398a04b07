//! Measures the CPU's work for several numbers of objects: build and refit of the hierarchy, plans,
//! and ingested answers. `cargo bench -p antumbra-cull`; docs/book/src/measuring.md has
//! the results.
//!
//! The objects stand on a square, and a camera walks between them. In place of a rasteriser, the
//! distance of a box decides if it shows, so that the same number of boxes show at every size.
#![allow(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

use std::cell::RefCell;

use antumbra_cull::{
    Aabb, Answer, Camera, CullConfig, CullView, Culler, FramePlan, Hierarchy, ObjectId, Projection,
    Strategy,
};
use divan::Bencher;
use divan::counter::ItemsCount;
use glam::Vec3;

const OBJECTS: [usize; 3] = [10_000, 100_000, 1_000_000];
/// The distance between neighbours in metres.
const PITCH_M: f32 = 4.0;
const SHOWS_WITHIN_M: f32 = 60.0;
const QUERIES: usize = 4_096;
/// The number of frames after which the frontier has its final size.
const WARM_UP: u32 = 200;

fn main() {
    divan::main();
}

/// Returns the boxes of `count` houses on a square.
fn houses(count: usize) -> Vec<Aabb> {
    let side = side(count);
    (0..count)
        .map(|number| {
            let corner = Vec3::new((number % side) as f32, 0.0, (number / side) as f32) * PITCH_M;
            let height = 1.0 + (number * 7919 % 31) as f32;
            Aabb::new(corner, corner + Vec3::new(3.0, height, 3.0))
        })
        .collect()
}

fn side(count: usize) -> usize {
    (count as f32).sqrt().ceil() as usize
}

#[divan::bench(args = OBJECTS, sample_count = 10, sample_size = 1)]
fn build(bencher: Bencher<'_, '_>, count: usize) {
    let boxes = houses(count);
    bencher.counter(ItemsCount::new(count)).bench_local(|| Hierarchy::build(&boxes).unwrap());
}

/// Measures a refit: one object of a hundred moves by half a metre, and back with the next call.
/// The moved objects are far apart.
#[divan::bench(args = OBJECTS, sample_count = 100, sample_size = 1)]
fn refit(bencher: Bencher<'_, '_>, count: usize) {
    let boxes = houses(count);
    let mut hierarchy = Hierarchy::build(&boxes).unwrap();
    let numbers = (0..count / 100).map(|number| number * 7919 % count);
    let mut moved: Vec<(ObjectId, Aabb)> =
        numbers.map(|number| (ObjectId(number as u32), boxes[number])).collect();
    let mut shift = Vec3::splat(0.5);
    bencher.counter(ItemsCount::new(moved.len())).bench_local(|| {
        for (_, bounds) in &mut moved {
            *bounds = Aabb::new(bounds.min + shift, bounds.max + shift);
        }
        shift = -shift;
        hierarchy.refit(moved.iter().copied()).unwrap();
    });
}

/// A walk through the houses.
struct Walk {
    hierarchy: Hierarchy,
    culler: Culler,
    plan: FramePlan,
    camera: Camera,
    answers: Vec<Answer>,
}

impl Walk {
    fn new(count: usize) -> Self {
        let middle = (side(count) / 2) as f32 * PITCH_M;
        let mut walk = Self {
            hierarchy: Hierarchy::build(&houses(count)).unwrap(),
            culler: Culler::new(CullConfig::default()),
            plan: FramePlan::default(),
            camera: Camera {
                eye: Vec3::new(middle - 0.5, 1.7, -20.0),
                forward: Vec3::Z,
                up: Vec3::Y,
                projection: Projection::perspective(1.0),
                near: 0.1,
            },
            answers: Vec::new(),
        };
        for _ in 0..WARM_UP {
            walk.answer();
            walk.ingest();
            walk.plan();
        }
        walk
    }

    /// Answers the newest plan in place of the GPU, and takes a step.
    fn answer(&mut self) {
        let hierarchy = &self.hierarchy;
        let eye = self.camera.eye;
        let tests = self.plan.tests.iter().map(|test| test.tag);
        let draws = self.plan.queried_draws.iter().map(|(_, tag)| *tag);
        self.answers.extend(tests.chain(draws).map(|tag| {
            let bounds = hierarchy.bounds(tag.node);
            let nearest = eye.clamp(bounds.min, bounds.max);
            let samples = u32::from(nearest.distance(eye) < SHOWS_WITHIN_M);
            Answer { tag, samples }
        }));
        self.camera.eye.z += 0.05;
    }

    fn ingest(&mut self) {
        self.culler.ingest(&self.hierarchy, self.answers.drain(..));
    }

    fn plan(&mut self) {
        let view = CullView::new(&self.camera, [1280, 720], 8);
        self.culler.plan(&self.hierarchy, Strategy::ANTUMBRA, &view, QUERIES, &mut self.plan);
    }
}

/// Measures the first plan, without any history.
#[divan::bench(args = OBJECTS, sample_count = 50, sample_size = 1)]
fn first_plan(bencher: Bencher<'_, '_>, count: usize) {
    let walk = RefCell::new(Walk::new(count));
    bencher
        .counter(ItemsCount::new(count))
        .with_inputs(|| walk.borrow_mut().culler.reset())
        .bench_local_values(|()| walk.borrow_mut().plan());
}

/// Measures a plan of the next step of a walk.
#[divan::bench(args = OBJECTS, sample_count = 200, sample_size = 1)]
fn plan(bencher: Bencher<'_, '_>, count: usize) {
    let walk = RefCell::new(Walk::new(count));
    let prepare = || {
        let mut walk = walk.borrow_mut();
        walk.answer();
        walk.ingest();
    };
    bencher
        .counter(ItemsCount::new(count))
        .with_inputs(prepare)
        .bench_local_values(|()| walk.borrow_mut().plan());
}

/// Measures ingesting the answers of one frame.
#[divan::bench(args = OBJECTS, sample_count = 200, sample_size = 1)]
fn ingest(bencher: Bencher<'_, '_>, count: usize) {
    let walk = RefCell::new(Walk::new(count));
    let prepare = || {
        let mut walk = walk.borrow_mut();
        walk.plan();
        walk.answer();
        walk.answers.len()
    };
    bencher
        .with_inputs(prepare)
        .input_counter(|answers| ItemsCount::new(*answers))
        .bench_local_values(|_| walk.borrow_mut().ingest());
}
