//! Random sequences of the calls that a program makes, against a plain model: a map of the objects
//! that are there. Each frame of each sequence is exact, draws nothing that is gone, and has a plan
//! in order. A sequence that fails is shortened before it is printed.
//!
//! `PROPTEST_CASES=10000` makes it forty times as many sequences, others each time.

use std::cell::Cell;
use std::collections::BTreeMap;

use antumbra_cull::{
    Aabb, BlockingCuller, Camera, CostTable, CullConfig, CullView, Culler, FramePlan, Hierarchy,
    LeafIndex, ObjectId, Projection, SceneCosts, SectionMember, SectionMode, SectionPlane,
    SectionPlanes, Strategy, VisibilityTestSupport,
};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::strategy::Strategy as _;
use proptest::test_runner::TestRunner;

use crate::blocking;
use crate::device::{Device, Mishaps, Solids, draw_caps, seen};
use crate::image::{Image, Shift};
use crate::invariants;
use crate::talk::{Talk, Trouble};

/// The number of sequences in place of one that proptest tries by default.
const CASES: u32 = 8;
const SUB_PIXEL_BITS: u32 = 8;
/// The sizes of images.
const SIZES: [[u32; 2]; 4] = [[24, 16], [16, 24], [32, 18], [1, 1]];
/// The sides of boxes, among them those that hide all others (metres).
const SIDES: [f32; 5] = [0.0, 0.3, 1.0, 4.0, 30.0];
const VIEWS: usize = 2;

/// An object of the model.
#[derive(Clone, Copy, Debug)]
struct Thing {
    bounds: Aabb,
    /// The drawn solid, inside of the box.
    solid: Aabb,
    shift: Shift,
    member: SectionMember,
}

/// A call of a program.
#[derive(Clone, Debug)]
enum Call {
    Add(Vec<Thing>),
    Remove(Index),
    Move(Index, Thing),
    SetMember(Index, SectionMember),
    Restructure,
    Rebuild,
    Section(Vec<(Vec3, f32)>, SectionMode),
    Resize(usize, usize),
    Look(usize, Camera),
    UseStrategy(usize, usize),
    SetCosts(usize, f32),
    /// Forgets the history of a view; answers to earlier frames still come.
    Reset(usize),
    /// Loses the device: no answer comes, and objects keep their ids in another hierarchy.
    LoseDevice,
    Draw(usize, usize),
}

fn thing() -> impl proptest::strategy::Strategy<Value = Thing> {
    let place = [-12.0_f32..12.0, -6.0..6.0, -12.0..12.0];
    let side = || prop::sample::select(&SIDES[..]);
    let shift = 0.5_f64.powi(SUB_PIXEL_BITS as i32);
    let shift = [-shift..shift, -shift..shift];
    let member = prop::sample::select(vec![SectionMember::Cut, SectionMember::Whole]);
    let fill = prop_oneof![Just(1.0_f32), 0.3_f32..1.0];
    (place, [side(), side(), side()], fill, shift, member).prop_map(
        |(place, sides, fill, shift, member)| {
            let centre = Vec3::from_array(place);
            let half = Vec3::from_array(sides) * 0.5;
            let bounds = Aabb::new(centre - half, centre + half);
            let solid = Aabb::new(centre - half * fill, centre + half * fill);
            let solid = Aabb::new(solid.min.max(bounds.min), solid.max.min(bounds.max));
            Thing { bounds, solid, shift, member }
        },
    )
}

fn camera() -> impl proptest::strategy::Strategy<Value = Camera> {
    let eye = [-16.0_f32..16.0, -3.0..6.0, -16.0..16.0];
    let projection = prop_oneof![
        3 => (0.4_f32..1.6).prop_map(Projection::perspective),
        1 => (4.0_f32..40.0)
            .prop_map(|height| Projection::Orthographic { height, far: 60.0 }),
    ];
    let near = prop::sample::select(vec![0.01_f32, 0.1, 1.0]);
    (eye, -3.2_f32..3.2, -0.4_f32..0.4, projection, near).prop_map(
        |(eye, turn, rise, projection, near)| Camera {
            eye: Vec3::from_array(eye),
            forward: Vec3::new(turn.cos(), rise, turn.sin()),
            up: Vec3::Y,
            projection,
            near,
        },
    )
}

fn call() -> impl proptest::strategy::Strategy<Value = Call> {
    let index = any::<Index>;
    let view = || 0..VIEWS;
    let member = prop::sample::select(vec![SectionMember::Cut, SectionMember::Whole]);
    let mode = prop::sample::select(vec![SectionMode::Intersection, SectionMode::Union]);
    let normal = prop_oneof![
        Just(Vec3::X),
        Just(Vec3::NEG_Z),
        [-1.0_f32..1.0, -1.0..1.0, -1.0..1.0].prop_map(Vec3::from_array),
    ];
    let planes = prop::collection::vec((normal, -8.0_f32..8.0), 0..4);
    prop_oneof![
        4 => prop::collection::vec(thing(), 1..8).prop_map(Call::Add),
        4 => index().prop_map(Call::Remove),
        5 => (index(), thing()).prop_map(|(index, to)| Call::Move(index, to)),
        1 => (index(), member).prop_map(|(index, member)| Call::SetMember(index, member)),
        2 => Just(Call::Restructure),
        1 => Just(Call::Rebuild),
        1 => (planes, mode).prop_map(|(planes, mode)| Call::Section(planes, mode)),
        1 => (view(), 0..SIZES.len()).prop_map(|(view, size)| Call::Resize(view, size)),
        2 => (view(), camera()).prop_map(|(view, camera)| Call::Look(view, camera)),
        2 => (view(), 0..strategies()).prop_map(|(view, way)| Call::UseStrategy(view, way)),
        1 => (view(), 0.01_f32..100.0).prop_map(|(view, factor)| Call::SetCosts(view, factor)),
        1 => view().prop_map(Call::Reset),
        1 => Just(Call::LoseDevice),
        9 => (view(), 1..5_usize).prop_map(|(view, frames)| Call::Draw(view, frames)),
    ]
}

/// Returns the number of strategies: those of the culler, and then the blocking ones.
fn strategies() -> usize {
    Strategy::PLANNED.len() + blocking::default_kinds().len()
}

/// A view with its history in each method.
struct Eye {
    camera: Camera,
    size: [u32; 2],
    strategy: usize,
    culler: Culler,
    plan: FramePlan,
    device: Device,
    mishaps: Mishaps,
    blocking: Vec<BlockingCuller>,
    talk: Talk,
}

impl Eye {
    fn new(camera: Camera, latency: u64, is_rough: bool) -> Self {
        let calm = Mishaps::none(latency);
        let rough = Mishaps { late: 0.3, lost: 0.2, twice: 0.2, listed: 6, ..calm };
        let mishaps = if is_rough { rough } else { calm };
        let testers = VisibilityTestSupport {
            queries: true,
            flags: true,
            compute: true,
            leaf_tests: true,
            ..VisibilityTestSupport::default()
        };
        let kinds = blocking::default_kinds().into_iter();
        Self {
            camera,
            size: SIZES[0],
            strategy: latency as usize % strategies(),
            culler: Culler::with_testers(CullConfig::default(), testers),
            plan: FramePlan::default(),
            device: Device::new(SIZES[0], SUB_PIXEL_BITS, mishaps, latency),
            mishaps,
            blocking: kinds.map(BlockingCuller::new).collect(),
            talk: Talk::new(SIZES[0], SUB_PIXEL_BITS, Trouble::default(), latency),
        }
    }

    fn resize(&mut self, size: [u32; 2]) {
        self.size = size;
        self.device.images = vec![Image::new(size)];
        self.talk.image = Image::new(size);
    }

    fn forget(&mut self) {
        self.culler.reset();
        let kinds = blocking::default_kinds().into_iter();
        self.blocking = kinds.map(BlockingCuller::new).collect();
    }

    fn lose_device(&mut self, seed: u64) {
        self.forget();
        self.device = Device::new(self.size, SUB_PIXEL_BITS, self.mishaps, seed);
    }
}

/// The objects that are there by the model, the hierarchy, and views of both.
struct World {
    things: BTreeMap<u32, Thing>,
    hierarchy: Hierarchy,
    section: SectionPlanes,
    eyes: Vec<Eye>,
    /// The frames, the objects that were drawn in them, and those that were there.
    counted: [u64; 3],
}

impl World {
    fn new(things: &[Thing], eyes: Vec<Eye>) -> Self {
        let boxes: Vec<Aabb> = things.iter().map(|thing| thing.bounds).collect();
        let mut world = Self {
            things: (0..).zip(things.iter().copied()).collect(),
            hierarchy: Hierarchy::build(&boxes).unwrap(),
            section: SectionPlanes::default(),
            eyes,
            counted: [0; 3],
        };
        world.set_members();
        world
    }

    fn set_members(&mut self) {
        for (object, thing) in &self.things {
            self.hierarchy.set_section_member(ObjectId(*object), thing.member);
        }
    }

    fn object(&self, index: &Index) -> Option<u32> {
        let place = index.index(self.things.len().max(1));
        self.things.keys().nth(place).copied()
    }

    fn boxes(&self) -> Vec<Aabb> {
        let mut boxes = vec![Aabb::EMPTY; self.hierarchy.leaf_objects().len()];
        for (object, thing) in &self.things {
            boxes[*object as usize] = thing.bounds;
        }
        boxes
    }

    fn call(&mut self, call: &Call) -> Result<(), TestCaseError> {
        match call {
            Call::Add(things) => self.add(things)?,
            Call::Remove(index) => {
                if let Some(object) = self.object(index) {
                    self.hierarchy.remove(ObjectId(object)).unwrap();
                    self.things.remove(&object);
                }
            }
            Call::Move(index, to) => {
                if let Some(object) = self.object(index) {
                    self.hierarchy.refit([(ObjectId(object), to.bounds)]).unwrap();
                    let member = self.things[&object].member;
                    self.things.insert(object, Thing { member, ..*to });
                }
            }
            Call::SetMember(index, member) => {
                if let Some(object) = self.object(index) {
                    self.hierarchy.set_section_member(ObjectId(object), *member);
                    self.things.get_mut(&object).unwrap().member = *member;
                }
            }
            Call::Restructure => self.hierarchy.rebuild_subtrees(&mut Vec::new()),
            Call::Rebuild => drop(self.hierarchy.rebuild(&self.boxes()).unwrap()),
            Call::Section(planes, mode) => self.section = section(planes, *mode),
            Call::Resize(view, size) => self.eyes[*view].resize(SIZES[*size]),
            Call::Look(view, camera) => self.eyes[*view].camera = *camera,
            Call::UseStrategy(view, strategy) => self.eyes[*view].strategy = *strategy,
            Call::SetCosts(view, factor) => {
                let usual = CostTable::default();
                let table = CostTable { draw_ns: usual.draw_ns * factor, ..usual };
                let scene = SceneCosts { triangles_per_leaf: 100.0 };
                self.eyes[*view].culler.set_costs(table, scene).unwrap();
            }
            Call::Reset(view) => self.eyes[*view].forget(),
            Call::LoseDevice => {
                self.hierarchy = Hierarchy::build(&self.boxes()).unwrap();
                self.set_members();
                (1..).zip(&mut self.eyes).for_each(|(seed, eye)| eye.lose_device(seed));
            }
            Call::Draw(view, frames) => {
                for _ in 0..*frames {
                    self.draw(*view)?;
                }
            }
        }
        self.check()
    }

    fn add(&mut self, things: &[Thing]) -> Result<(), TestCaseError> {
        let boxes: Vec<Aabb> = things.iter().map(|thing| thing.bounds).collect();
        let mut added = Vec::new();
        self.hierarchy.insert_all(&boxes, &mut added, &mut Vec::new()).unwrap();
        prop_assert_eq!(added.len(), things.len());
        for (object, thing) in added.iter().zip(things) {
            self.hierarchy.set_section_member(*object, thing.member);
            prop_assert!(self.things.insert(object.0, *thing).is_none(), "{:?} twice", object);
        }
        Ok(())
    }

    /// Compares the hierarchy with the model.
    fn check(&self) -> Result<(), TestCaseError> {
        prop_assert_eq!(self.hierarchy.object_count() as usize, self.things.len());
        for object in 0..self.hierarchy.leaf_objects().len() as u32 {
            let thing = self.things.get(&object);
            let object = ObjectId(object);
            prop_assert_eq!(self.hierarchy.contains(object), thing.is_some());
            let Some(thing) = thing else { continue };
            let node = self.hierarchy.node_of(object).unwrap();
            prop_assert_eq!(self.hierarchy.bounds(node), thing.bounds);
            prop_assert_eq!(self.hierarchy.section_member(object), thing.member);
        }
        Ok(())
    }

    fn draw(&mut self, view: usize) -> Result<(), TestCaseError> {
        let leaves = self.hierarchy.leaf_objects().len();
        let mut solids = vec![Aabb::EMPTY; leaves];
        let mut shifts = vec![[0.0; 2]; leaves];
        for (object, thing) in &self.things {
            solids[*object as usize] = thing.solid;
            shifts[*object as usize] = thing.shift;
        }
        let solids = Solids { solids: &solids, shifts: &shifts };
        let eye = &mut self.eyes[view];
        let hierarchy = &self.hierarchy;
        let seen_by = CullView::new(&eye.camera, eye.size, SUB_PIXEL_BITS);
        let seen_by = CullView { section: self.section, ..seen_by };
        // Answers come whatever the method of this frame is.
        let answers = eye.device.collect(eye.culler.frame().0 + 1, hierarchy);
        eye.culler.ingest(hierarchy, answers);
        let drawn: Vec<LeafIndex>;
        let image;
        if let Some(strategy) = Strategy::PLANNED.get(eye.strategy) {
            let Eye { culler, plan, device, .. } = eye;
            culler.plan(hierarchy, *strategy, &seen_by, 1_000, plan);
            let checked = invariants::check(hierarchy, *strategy, &seen_by, 1_000, plan);
            prop_assert!(checked.is_ok(), "{:?}", checked);
            device.execute(&seen_by, hierarchy, &solids, plan);
            let queried = plan.queried_draws.iter().map(|(leaf, _)| *leaf);
            drawn = plan.draws.iter().copied().chain(queried).collect();
            self.counted[1] += device.drawn.len() as u64;
            image = &device.images[0];
        } else {
            let method = &mut eye.blocking[eye.strategy - Strategy::PLANNED.len()];
            let mut decisions = method.begin(hierarchy, &seen_by);
            eye.talk.frame(&mut decisions, &seen_by, hierarchy, &solids);
            drawn = eye.talk.drawn.clone();
            self.counted[1] += drawn.len() as u64;
            image = &eye.talk.image;
        }
        self.counted[0] += 1;
        self.counted[2] += self.things.len() as u64;
        for leaf in drawn {
            let object = hierarchy.leaf_objects()[leaf.0 as usize];
            prop_assert!(self.things.contains_key(&object.0), "{:?} is drawn and gone", object);
        }
        let mut truth = Image::new(eye.size);
        draw_caps(&mut truth, &seen_by, hierarchy, solids.solids);
        for (object, thing) in &self.things {
            truth.draw(&seen(hierarchy, *object, &seen_by), &thing.solid, thing.shift);
        }
        prop_assert!(truth.depths == image.depths, "view {} has wrong pixels", view);
        Ok(())
    }
}

fn section(planes: &[(Vec3, f32)], mode: SectionMode) -> SectionPlanes {
    let plane = |(normal, offset_m): &(Vec3, f32)| {
        SectionPlane::new(DVec3::from(*normal), f64::from(*offset_m)).ok()
    };
    let planes: Vec<SectionPlane> = planes.iter().filter_map(plane).collect();
    SectionPlanes::new(&planes, mode).unwrap()
}

#[test]
fn every_frame_of_every_sequence_of_calls_is_exact() {
    let usual = ProptestConfig::default();
    let cases = usual.cases * CASES;
    let mut runner = TestRunner::new(ProptestConfig { cases, failure_persistence: None, ..usual });
    let things = prop::collection::vec(thing(), 0..24);
    let eyes = [camera(), camera()];
    let latencies = [1..5_u64, 1..5];
    let calls = prop::collection::vec(call(), 1..40);
    let counted = Cell::new([0; 3]);
    let outcome = runner.run(
        &(things, eyes, latencies, any::<bool>(), calls),
        |(things, cameras, latencies, is_rough, calls)| {
            let eyes = cameras.into_iter().zip(latencies);
            let eyes = eyes.map(|(camera, latency)| Eye::new(camera, latency, is_rough));
            let mut world = World::new(&things, eyes.collect());
            calls.iter().try_for_each(|call| world.call(call))?;
            let before = counted.get();
            counted.set([0, 1, 2].map(|place| before[place] + world.counted[place]));
            Ok(())
        },
    );
    outcome.unwrap_or_else(|error| panic!("{error}"));
    let [frames, drawn, there] = counted.get();
    println!("{cases} sequences, {frames} frames, {drawn} of {there} objects drawn");
    assert!(frames > 10 * u64::from(cases), "{frames} frames");
    assert!(drawn * 2 < there, "nothing was culled: {drawn} of {there}");
}
