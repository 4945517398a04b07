//! The share of frames that need no test, on walks of a culler with true results. The tables are in
//! docs/lab/performance.md.

use std::fmt;

use antumbra_cull::{
    Aabb, Camera, CostTable, CullConfig, CullView, Culler, Hierarchy, LeafIndex, NodeId, QueryKind,
    SceneCosts, Strategy, VisibilityTestSupport,
};
use glam::Vec3;

use super::occluders::{Setting, eroded_surfaces, seen_by_one_eye, shrunk_solids};
use super::streets::{Motion, Place};
use super::{Certificate, Sides};
use crate::device::{Device, Mishaps, Solids};
use crate::random::Random;
use crate::walk::{BUDGET, Walk};

/// The size of the frames of most walks (pixels).
const SIZE: [u32; 2] = [320, 180];
/// The frames in flight, and with them the frames until an answer arrives.
const LATENCY: u64 = 2;
/// The frames from the depth image of a certificate to the first frame that can use it.
const AGE: usize = LATENCY as usize + 1;
/// The frames of a walk before the first that counts, and those that count.
const WARM_UP: u32 = 60;
const COUNTED: u32 = 150;
/// The interval of the frames that are compared with certificates.
const STEP: usize = 10;

/// A walk to record.
#[derive(Clone, Copy, Debug)]
struct Course {
    place: Place,
    motion: Motion,
    /// The size of the frames (pixels).
    size: [u32; 2],
}

/// A test of the frontier.
struct Tested {
    node: NodeId,
    /// True if a sample of the node's proxy showed.
    showed: bool,
}

/// A frame of a walk.
struct Frame {
    camera: Camera,
    view: CullView,
    tests: Vec<Tested>,
    /// The number of drawn objects.
    drawn: usize,
}

/// The frames of one walk.
struct Recorded {
    size: [u32; 2],
    hierarchy: Hierarchy,
    solids: Vec<Aabb>,
    frames: Vec<Frame>,
}

impl Recorded {
    /// Returns the frames that are compared with certificates.
    fn compared(&self) -> impl Iterator<Item = usize> {
        (WARM_UP as usize..self.frames.len()).step_by(STEP)
    }
}

fn record(course: Course, seed: u64, costs: Option<CostTable>) -> Recorded {
    let Course { place, motion, size } = course;
    let mut random = Random::new(seed);
    let scene = place.scene(&mut random);
    let mut walk = Walk::new(scene.bounds.clone(), LATENCY);
    walk.scene = scene;
    walk.device = Device::new(size, 8, Mishaps::none(LATENCY), seed);
    let testers =
        VisibilityTestSupport { flags: true, leaf_tests: true, ..VisibilityTestSupport::default() };
    walk.culler = Culler::with_testers(CullConfig { seed, ..CullConfig::default() }, testers);
    if let Some(table) = costs {
        walk.culler.set_costs(table, SceneCosts { triangles_per_leaf: 400.0 }).unwrap();
    }
    let start = random.between(0.0, 64.0);
    let mut frames = Vec::new();
    for frame in 0..WARM_UP + COUNTED {
        let camera = motion.camera(place, start, frame);
        let view = CullView::new(&camera, size, 8);
        let answers = walk.device.collect(walk.culler.frame().0 + 1, &walk.hierarchy);
        walk.culler.ingest(&walk.hierarchy, answers);
        walk.culler.plan(&walk.hierarchy, Strategy::ANTUMBRA, &view, BUDGET, &mut walk.plan);
        let solids = Solids { solids: &walk.scene.solids, shifts: &walk.scene.shifts };
        walk.device.execute(&view, &walk.hierarchy, &solids, &walk.plan);
        let answers = walk.device.answers_of(walk.plan.frame, &walk.hierarchy);
        let frontier = walk.plan.tests.iter().filter(|test| !test.leaves.is_empty());
        let tests = frontier.map(|test| {
            let node = test.tag.node;
            let answer = answers
                .iter()
                .find(|answer| answer.tag.node == node && answer.tag.kind != QueryKind::Leaf);
            Tested { node, showed: answer.is_some_and(|answer| answer.shows()) }
        });
        let tests = tests.collect();
        frames.push(Frame { camera, view, tests, drawn: walk.device.drawn.len() });
    }
    Recorded { size, hierarchy: walk.hierarchy, solids: walk.scene.solids, frames }
}

/// A way to find certificates.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// A bound of all certificates: what neither the later eye nor six eyes at the edge of the
    /// radius see in the middles of pixels, in the later frame's direction of sight.
    Bound,
    /// Solids, shrunk.
    Solids { guard: f32 },
    /// Solids as they are: a certificate for one eye and one grid of samples.
    Whole,
    /// Surfaces, eroded.
    Surfaces,
}

/// A kind of certificate for a radius and with an image of a size.
#[derive(Clone, Copy, Debug)]
struct Method {
    kind: Kind,
    radius_m: f32,
    size: [u32; 2],
}

/// The leaves and tests of one frame by a method.
struct Judge<'a> {
    recorded: &'a Recorded,
    later: &'a Frame,
    certificates: Vec<Certificate>,
    /// The sides that may be crossed.
    around: Sides,
}

impl<'a> Judge<'a> {
    fn new(recorded: &'a Recorded, number: usize, method: Method) -> Self {
        let later = &recorded.frames[number];
        let old = &recorded.frames[number - AGE].camera;
        // The margin of larger frames is smaller.
        let margin_m = CullView::new(old, [1280, 720], 8).margin.metres()[0];
        let setting =
            |guard| Setting { radius_m: method.radius_m, size: method.size, guard, margin_m };
        let solids = &recorded.solids;
        let certificates = match method.kind {
            Kind::Bound => {
                let ends = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| [axis, -axis]);
                let ends = ends.into_iter().flatten().map(|end| end * method.radius_m);
                let eyes = std::iter::once(later.camera.eye).chain(ends.map(|end| old.eye + end));
                let see =
                    |eye| seen_by_one_eye(&Camera { eye, ..later.camera }, method.size, solids);
                eyes.map(see).collect()
            }
            Kind::Solids { guard } => vec![shrunk_solids(&setting(guard), old, solids)],
            Kind::Whole => {
                let setting = Setting { radius_m: 0.0, margin_m: 0.0, ..setting(0.0) };
                vec![shrunk_solids(&setting, old, solids)]
            }
            Kind::Surfaces => vec![eroded_surfaces(&setting(0.0), old, solids)],
        };
        let around = match method.kind {
            Kind::Bound => [true; 4],
            _ => certificates[0].sides_around(&later.view),
        };
        Self { recorded, later, certificates, around }
    }

    fn is_in_frustum(&self, node: NodeId) -> bool {
        let bounds = self.recorded.hierarchy.bounds(node);
        let mask = antumbra_cull::PlaneMask::ALL;
        self.later.view.frustum.classify(&bounds, mask).0 != antumbra_cull::Containment::Outside
    }

    /// Returns true if a box as a whole has a certificate.
    fn covers(&self, bounds: &Aabb) -> bool {
        self.certificates.iter().all(|certificate| {
            certificate.covers(bounds).is_some_and(|crossed| {
                crossed.iter().zip(self.around).all(|(crossed, around)| around || !crossed)
            })
        })
    }

    /// Collects the leaves in the frustum below a node without a certificate of their own or of a
    /// node above.
    fn uncovered(&self, node: NodeId, leaves: &mut Vec<LeafIndex>) {
        let hierarchy = &self.recorded.hierarchy;
        if !self.is_in_frustum(node) || self.covers(&hierarchy.bounds(node)) {
            return;
        }
        match hierarchy.children(node) {
            Some(children) => children.into_iter().for_each(|child| self.uncovered(child, leaves)),
            None => leaves.push(hierarchy.leaves(node).first),
        }
    }
}

/// Counts of frames and tests.
#[derive(Clone, Debug, Default)]
struct Tally {
    frames: usize,
    frames_covered: usize,
    tests: usize,
    tests_covered: usize,
    /// The leaves of each frame without a certificate.
    left: Vec<usize>,
}

impl Tally {
    fn add(&mut self, recorded: &Recorded, method: Method) {
        for number in recorded.compared() {
            let frame = &recorded.frames[number];
            let judge = Judge::new(recorded, number, method);
            let mut left = Vec::new();
            let mut covered = 0;
            for test in &frame.tests {
                let before = left.len();
                judge.uncovered(test.node, &mut left);
                covered += usize::from(left.len() == before);
            }
            self.frames += 1;
            self.frames_covered += usize::from(covered == frame.tests.len());
            self.tests += frame.tests.len();
            self.tests_covered += covered;
            self.left.push(left.len());
        }
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut left = self.left.clone();
        left.sort_unstable();
        let frames = percent(self.frames_covered, self.frames);
        let tests = percent(self.tests_covered, self.tests);
        write!(formatter, "{frames:.0} / {tests:.0} / {}", left[left.len() / 2])
    }
}

fn percent(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

/// The reasons for which a test has no certificate of shrunk solids.
#[derive(Clone, Copy, Debug)]
enum Reason {
    /// It shows.
    Shows,
    /// An eye within the radius sees the box.
    SeenWithinRadius,
    /// The box crosses an edge of the old image beyond which the later view sees.
    CrossesEdge,
    /// No pixels that one solid covers completely hide the box, even if solids are not shrunk.
    Coverage,
    /// The solids hide the box unless they are shrunk.
    Shrinking,
}

/// Counts the tests without a certificate of shrunk solids by [`Reason`].
fn count_reasons(recorded: &Recorded, method: Method, counts: &mut [usize; 5]) {
    let leaves = |judge: &Judge<'_>, node: NodeId| {
        let mut left = Vec::new();
        judge.uncovered(node, &mut left);
        left.len()
    };
    for number in recorded.compared() {
        let judge = |kind, size| Judge::new(recorded, number, Method { kind, size, ..method });
        let strict = judge(method.kind, method.size);
        let bound = judge(Kind::Bound, recorded.size);
        let whole = Judge { around: [true; 4], ..judge(Kind::Whole, method.size) };
        let anywhere = Judge { around: [true; 4], ..judge(method.kind, method.size) };
        let tests = recorded.frames[number].tests.iter();
        for test in tests.filter(|test| leaves(&strict, test.node) > 0) {
            let reason = match test.node {
                _ if test.showed => Reason::Shows,
                node if leaves(&bound, node) > 0 => Reason::SeenWithinRadius,
                node if leaves(&anywhere, node) == 0 => Reason::CrossesEdge,
                node if leaves(&whole, node) > 0 => Reason::Coverage,
                _ => Reason::Shrinking,
            };
            counts[reason as usize] += 1;
        }
    }
}

/// Prints the rows of one motion in one scene.
fn measure(course: Course, seeds: std::ops::Range<u64>, radii_m: &[f32]) {
    let Course { place, motion, size } = course;
    let recorded: Vec<Recorded> = seeds.clone().map(|seed| record(course, seed, None)).collect();
    let counted = || recorded.iter().flat_map(|walk| &walk.frames[WARM_UP as usize..]);
    let frames = counted().count();
    let tests: usize = counted().map(|frame| frame.tests.len()).sum();
    let drawn: usize = counted().map(|frame| frame.drawn).sum();
    let calm = counted().filter(|frame| frame.tests.iter().all(|test| !test.showed)).count();
    let priced: Vec<Recorded> =
        seeds.map(|seed| record(course, seed, Some(CostTable::default()))).collect();
    let priced = priced.iter().flat_map(|walk| &walk.frames[WARM_UP as usize..]);
    let today = priced.filter(|frame| frame.tests.is_empty()).count();
    println!(
        "{place:?} {motion:?} {size:?} | {} objects | {:.0} drawn | {:.0} tests | without tests \
         today {:.0} % | no test shows {:.0} %",
        recorded[0].solids.len(),
        drawn as f64 / frames as f64,
        tests as f64 / frames as f64,
        percent(today, frames),
        percent(calm, frames),
    );
    for radius_m in radii_m.iter().copied() {
        let kinds = [
            (Kind::Bound, size),
            (Kind::Solids { guard: 0.0 }, [160, 90]),
            (Kind::Solids { guard: 0.0 }, [320, 180]),
            (Kind::Solids { guard: 0.0 }, [640, 360]),
            (Kind::Solids { guard: 0.25 }, [640, 360]),
            (Kind::Surfaces, [640, 360]),
        ];
        let mut row = format!("{place:?} {motion:?} | {radius_m}");
        for (kind, size) in kinds {
            let mut tally = Tally::default();
            for walk in &recorded {
                tally.add(walk, Method { kind, radius_m, size });
            }
            row += &format!(" | {tally}");
        }
        println!("{row}");
    }
}

// The first radius of each motion is the least with which a certificate lives until the first frame
// that can use it.

#[test]
#[ignore = "a measurement: docs/lab/performance.md"]
fn frames_without_a_break_in_streets() {
    let course = |motion| Course { place: Place::Districts, motion, size: SIZE };
    measure(course(Motion::Straight(1.4)), 0..4, &[0.071, 0.2]);
    measure(course(Motion::Walk(1.4)), 0..4, &[0.071, 0.2]);
    measure(course(Motion::Walk(6.0)), 0..4, &[0.301]);
}

#[test]
#[ignore = "a measurement: docs/lab/performance.md"]
fn frames_without_a_break_in_turns_and_flights() {
    let course = |motion| Course { place: Place::Districts, motion, size: SIZE };
    measure(course(Motion::Turn(0.5)), 0..4, &[0.01]);
    measure(course(Motion::Fly(30.0)), 0..4, &[1.501]);
}

#[test]
#[ignore = "a measurement: docs/lab/performance.md"]
fn frames_without_a_break_between_blocks() {
    let course = |motion| Course { place: Place::Blocks, motion, size: SIZE };
    measure(course(Motion::Straight(1.4)), 0..4, &[0.071, 0.2]);
    measure(course(Motion::Walk(1.4)), 0..4, &[0.071]);
    measure(course(Motion::Walk(6.0)), 0..4, &[0.301]);
    measure(course(Motion::Turn(0.5)), 0..4, &[0.01]);
}

/// Measures walks with larger frames, which look through narrower gaps.
#[test]
#[ignore = "a measurement: docs/lab/performance.md"]
fn frames_without_a_break_in_larger_images() {
    for motion in [Motion::Straight(1.4), Motion::Walk(1.4)] {
        let course = Course { place: Place::Districts, motion, size: [640, 360] };
        measure(course, 0..2, &[0.071]);
    }
}

/// Prints the reasons for which tests have no certificate.
#[test]
#[ignore = "a measurement: docs/lab/performance.md"]
fn tests_without_a_certificate() {
    let kind = Kind::Solids { guard: 0.0 };
    for motion in [Motion::Straight(1.4), Motion::Walk(1.4)] {
        let course = Course { place: Place::Districts, motion, size: SIZE };
        let mut counts = [0; 5];
        for seed in 0..2 {
            let recorded = record(course, seed, None);
            let method = Method { kind, radius_m: 0.071, size: [640, 360] };
            count_reasons(&recorded, method, &mut counts);
        }
        println!("{motion:?}: shows, seen, edge, coverage, shrinking: {counts:?}");
    }
}

/// Measures larger images than an asynchronous pass would have, and bounds that look through gaps
/// narrower than a pixel of the frame.
#[test]
#[ignore = "a measurement: docs/lab/performance.md"]
fn frames_without_a_break_with_huge_certificates() {
    let solids = Kind::Solids { guard: 0.0 };
    for motion in [Motion::Straight(1.4), Motion::Walk(1.4)] {
        let course = Course { place: Place::Districts, motion, size: SIZE };
        let recorded = [0, 1].map(|seed| record(course, seed, None));
        let methods = [
            (Kind::Bound, [640, 360]),
            (Kind::Bound, [1280, 720]),
            (solids, [1280, 720]),
            (solids, [2560, 1440]),
        ];
        for (kind, size) in methods {
            let mut tally = Tally::default();
            for walk in &recorded {
                tally.add(walk, Method { kind, radius_m: 0.071, size });
            }
            println!("{motion:?} {kind:?} {size:?}: {tally}");
        }
    }
}
