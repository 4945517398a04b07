//! Tests of scenes whose objects move, are removed and are inserted: every frame and view is exact.

use antumbra_cull::{
    Aabb, Camera, CullConfig, CullView, Culler, FramePlan, Hierarchy, ObjectId, Projection,
    Strategy,
};
use glam::Vec3;

use crate::device::{Device, Mishaps, Solids};
use crate::image::Image;
use crate::invariants;
use crate::random::{Random, seeds};
use crate::scene::{PATHS, Path, Scene, cube};

const SCENES: u64 = 200;
const FRAMES: u64 = 40;
const SIZE: [u32; 2] = [40, 28];
const THREADS: u64 = 2;

/// A view with its own answers and latency that skips some frames.
struct Eye {
    camera: Camera,
    path: Path,
    culler: Culler,
    device: Device,
    plan: FramePlan,
    pauses: f32,
}

/// The world of a seed.
struct World {
    random: Random,
    scene: Scene,
    /// The boxes and solids of removed objects.
    away: Vec<(Aabb, Aabb)>,
    hierarchy: Hierarchy,
    /// The numbers of moves, removals and insertions per frame.
    changes: [usize; 3],
    reach: f32,
    sub_pixel_bits: u32,
}

/// The counts of the checked cases.
#[derive(Clone, Copy, Debug, Default)]
struct Checked {
    frames: u64,
    drawn: u64,
    there: u64,
    recycled: u64,
    grown: u64,
    rebuilt_leaves: u64,
}

impl World {
    fn new(seed: u64) -> Self {
        let mut random = Random::new(seed ^ 0x6d6f_7665);
        let sub_pixel_bits = [4, 8][random.below(2)];
        let mut scene = Scene::random(&mut random, sub_pixel_bits);
        // Room for more objects than at the start.
        for _ in 0..random.below(20) {
            scene.bounds.push(Aabb::EMPTY);
            scene.solids.push(Aabb::EMPTY);
            scene.shifts.push([0.0; 2]);
        }
        let many = 1 + scene.bounds.len() / 2;
        Self {
            hierarchy: Hierarchy::build(&scene.bounds).unwrap(),
            away: (0..30)
                .map(|_| [cube(random.point(-15.0, 15.0), &mut random); 2].into())
                .collect(),
            changes: [random.below(many), random.below(4), random.below(4)],
            reach: [0.5, 4.0, 20.0][random.below(3)],
            sub_pixel_bits,
            scene,
            random,
        }
    }

    fn eyes(&mut self, seed: u64) -> Vec<Eye> {
        let rough = self.random.chance(0.6);
        (1..=4)
            .map(|latency| {
                let calm = Mishaps::none(latency);
                let mishaps = Mishaps { late: 0.3, lost: 0.2, twice: 0.2, listed: 6, ..calm };
                Eye {
                    camera: Path::start(&mut self.random),
                    path: PATHS[self.random.below(PATHS.len())],
                    culler: Culler::new(CullConfig { seed, ..CullConfig::default() }),
                    device: Device::new(
                        SIZE,
                        self.sub_pixel_bits,
                        if rough { mishaps } else { calm },
                        seed ^ latency,
                    ),
                    plan: FramePlan::default(),
                    pauses: [0.0, 0.0, 0.3, 0.8][self.random.below(4)],
                }
            })
            .collect()
    }

    /// Returns the objects in the hierarchy.
    fn present(&self) -> Vec<usize> {
        (0..self.scene.bounds.len()).filter(|o| !self.scene.bounds[*o].is_empty()).collect()
    }

    fn advance(&mut self, frame: u64, checked: &mut Checked) {
        let [moves, removals, insertions] = self.changes;
        for _ in 0..self.random.below(removals + 1) {
            let present = self.present();
            if present.len() > 1 {
                let object = present[self.random.below(present.len())];
                self.hierarchy.remove(ObjectId(object as u32)).unwrap();
                let bounds = self.scene.bounds[object];
                let solid = self.scene.solids[object];
                self.away.push((bounds, solid));
                self.scene.bounds[object] = Aabb::EMPTY;
                self.scene.solids[object] = Aabb::EMPTY;
            }
        }
        let count = self.random.below(insertions + 1).min(self.away.len());
        self.insert(count, checked);
        let present = self.present();
        let moved: Vec<usize> =
            (0..moves).map(|_| present[self.random.below(present.len())]).collect();
        for object in &moved {
            let offset = self.random.point(-self.reach, self.reach);
            for bounds in [&mut self.scene.bounds[*object], &mut self.scene.solids[*object]] {
                *bounds = Aabb::new(bounds.min + offset, bounds.max + offset);
            }
        }
        let boxes = moved.iter().map(|o| (ObjectId(*o as u32), self.scene.bounds[*o]));
        self.hierarchy.refit(boxes).unwrap();
        if !frame.is_multiple_of(3) {
            self.hierarchy.rebuild_subtrees(&mut Vec::new());
        }
        if frame % 17 == 16 {
            self.hierarchy.rebuild(&self.scene.bounds).unwrap();
        }
    }

    /// Inserts objects into free leaves, or into new leaves if there are too few.
    fn insert(&mut self, count: usize, checked: &mut Checked) {
        let mut coming = Vec::new();
        for _ in 0..count {
            coming.push(self.away.swap_remove(self.random.below(self.away.len())));
        }
        let boxes: Vec<Aabb> = coming.iter().map(|(bounds, _)| *bounds).collect();
        let before = self.hierarchy.leaf_objects().len();
        let mut added = Vec::new();
        self.hierarchy.insert_all(&boxes, &mut added, &mut Vec::new()).unwrap();
        let leaves = self.hierarchy.leaf_objects().len();
        self.scene.bounds.resize(leaves, Aabb::EMPTY);
        self.scene.solids.resize(leaves, Aabb::EMPTY);
        self.scene.shifts.resize(leaves, [0.0; 2]);
        for (object, (bounds, solid)) in added.iter().zip(coming) {
            let object = object.0 as usize;
            assert!(self.scene.bounds[object].is_empty(), "only free ids are given");
            self.scene.bounds[object] = bounds;
            self.scene.solids[object] = solid;
            checked.recycled += 1;
        }
        checked.grown += u64::from(leaves > before);
    }

    fn draw_all(&self, view: &CullView, truth: &mut Image) -> u64 {
        truth.clear();
        let mut drawn = 0;
        for (solid, shift) in self.scene.solids.iter().zip(&self.scene.shifts) {
            if !solid.is_empty() {
                truth.draw(view, solid, *shift);
                drawn += 1;
            }
        }
        drawn
    }
}

fn verify(seed: u64) -> Checked {
    let mut world = World::new(seed);
    let mut eyes = world.eyes(seed);
    let mut truth = Image::new(SIZE);
    let mut checked = Checked::default();
    for frame in 0..FRAMES {
        world.advance(frame, &mut checked);
        for (number, eye) in eyes.iter_mut().enumerate() {
            eye.path.advance(&mut eye.camera, frame, &mut world.random);
            if world.random.chance(eye.pauses) {
                continue;
            }
            let view = CullView::new(&eye.camera, SIZE, world.sub_pixel_bits);
            let hierarchy = &world.hierarchy;
            let culler = &mut eye.culler;
            culler.ingest(hierarchy, eye.device.collect(culler.frame().0 + 1, hierarchy));
            culler.plan(hierarchy, Strategy::ANTUMBRA, &view, 1_000, &mut eye.plan);
            let context = || format!("seed {seed}, frame {frame}, eye {number}");
            invariants::check(hierarchy, Strategy::ANTUMBRA, &view, 1_000, &eye.plan)
                .unwrap_or_else(|broken| panic!("{}: {broken}", context()));
            let solids = Solids { solids: &world.scene.solids, shifts: &world.scene.shifts };
            eye.device.execute(&view, hierarchy, &solids, &eye.plan);
            checked.there += world.draw_all(&view, &mut truth);
            assert!(eye.device.images[0].depths == truth.depths, "{}: wrong pixels", context());
            checked.frames += 1;
            checked.drawn += eye.device.drawn.len() as u64;
        }
    }
    checked.rebuilt_leaves = world.hierarchy.work().rebuilt_leaves;
    checked
}

#[test]
fn nothing_visible_is_missing_while_everything_moves() {
    let scenes = seeds(SCENES);
    let workers: Vec<_> = (0..THREADS)
        .map(|worker| {
            std::thread::spawn(move || {
                (worker..scenes).step_by(THREADS as usize).map(verify).collect::<Vec<_>>()
            })
        })
        .collect();
    let mut sum = Checked::default();
    for checked in workers.into_iter().flat_map(|worker| worker.join().expect("see above")) {
        sum.frames += checked.frames;
        sum.drawn += checked.drawn;
        sum.there += checked.there;
        sum.recycled += checked.recycled;
        sum.grown += checked.grown;
        sum.rebuilt_leaves += checked.rebuilt_leaves;
    }
    println!("{sum:?}");
    assert!(sum.frames > scenes * FRAMES, "{sum:?}");
    assert!(sum.recycled > scenes && sum.rebuilt_leaves > 100 * scenes, "{sum:?}");
    assert!(sum.grown > scenes / 2, "{sum:?}");
    assert!(sum.drawn * 3 < sum.there * 2, "nothing was culled: {sum:?}");
}

/// Checks that objects that move among many still ones cause no cost beyond their own draws and
/// tests.
#[test]
fn things_that_move_behind_a_wall_stay_hidden() {
    let wall = Aabb::new(Vec3::new(-40.0, -40.0, -1.0), Vec3::new(40.0, 40.0, 0.0));
    let cube = |x: f32, z: f32| Aabb::new(Vec3::new(x, 0.0, z), Vec3::new(x + 0.5, 0.5, z + 0.5));
    let place = |number: usize, frame: usize| {
        let sway = ((frame * (number % 5 + 1)) as f32 * 0.05).sin();
        cube((number % 40) as f32 - 20.0 + sway, -4.0 - (number / 40) as f32)
    };
    let boxes = std::iter::once(wall).chain((0..2_000).map(|number| place(number, 0)));
    let mut walk = crate::walk::Walk::new(boxes.collect(), 2);
    let camera = Camera {
        eye: Vec3::new(0.0, 0.0, 12.0),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.1,
    };
    let mut queries = Vec::new();
    for frame in 0..200 {
        let moved = (0..2_000).step_by(10).map(|n| (ObjectId(n as u32 + 1), place(n, frame)));
        let moved: Vec<_> = moved.collect();
        for (object, bounds) in &moved {
            walk.scene.bounds[object.0 as usize] = *bounds;
            walk.scene.solids[object.0 as usize] = *bounds;
        }
        walk.hierarchy.refit(moved).unwrap();
        walk.hierarchy.rebuild_subtrees(&mut Vec::new());
        walk.step(&camera);
        assert!(walk.is_exact(&camera), "frame {frame}");
        queries.push(walk.plan.query_count());
    }
    assert!(queries[150..].iter().all(|queries| *queries <= 40), "{queries:?}");
    assert!(walk.device.drawn.len() <= 1, "{:?}", walk.device.drawn);
}
