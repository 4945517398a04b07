//! Tests of plans for several views that are drawn in one pass: each image is the same as with
//! everything drawn, whatever happens to the answers.

use antumbra_cull::{
    Camera, CostTable, CullConfig, CullView, Culler, DrawPhases, FramePlan, Hierarchy, MultiView,
    NodeState, ObjectId, Projection, SceneCosts, Strategy, VisibilityTest, VisibilityTestSupport,
};
use glam::{Quat, Vec3};

use crate::device::{Device, Mishaps, Solids};
use crate::image::Image;
use crate::invariants;
use crate::random::{Random, seeds};
use crate::scene::{Lens, PATHS, Path, Scene};

const SEEDS: u64 = 200;
const FRAMES: u64 = 20;
const SIZE: [u32; 2] = [28, 20];
const STRATEGIES: [Strategy; 4] = [
    Strategy::ANTUMBRA,
    Strategy::ANTUMBRA_FLAGS,
    Strategy::ANTUMBRA_QUERIES,
    Strategy::ANTUMBRA_COMPUTE,
];

/// The places of the views of a pass.
#[derive(Clone, Copy, Debug)]
enum Rig {
    /// Eyes side by side that look ahead, or at one point, with their distance (metres).
    Pair { apart: f32, turned: f32 },
    /// The faces of a cube around the camera.
    Faces,
    /// Independent views, one of them orthographic.
    Scattered,
}

impl Rig {
    fn random(random: &mut Random) -> Self {
        match random.below(4) {
            0 => Self::Faces,
            1 => Self::Scattered,
            _ => {
                let apart = [0.065, 0.065, random.between(0.5, 6.0)][random.below(3)];
                Self::Pair { apart, turned: [0.0, random.between(0.0, 0.4)][random.below(2)] }
            }
        }
    }

    fn cameras(self, camera: &Camera) -> Vec<Camera> {
        let side = camera.forward.cross(Vec3::Y).normalize_or(Vec3::X);
        match self {
            Self::Pair { apart, turned } => [-0.5, 0.5]
                .map(|share: f32| Camera {
                    eye: camera.eye + side * (share * apart),
                    forward: Quat::from_rotation_y(share * turned) * camera.forward,
                    ..*camera
                })
                .into(),
            Self::Faces => [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z]
                .map(|forward| Camera {
                    forward,
                    up: if forward.y == 0.0 { Vec3::Y } else { Vec3::X },
                    projection: Projection::perspective(std::f32::consts::FRAC_PI_2),
                    ..*camera
                })
                .into(),
            Self::Scattered => {
                let above = Camera {
                    eye: camera.eye + Vec3::Y * 20.0,
                    forward: Vec3::NEG_Y,
                    up: Vec3::X,
                    projection: Projection::Orthographic { height: 24.0, far: 40.0 },
                    near: 0.1,
                };
                let mirrored = Camera { eye: -camera.eye, forward: -camera.forward, ..*camera };
                vec![*camera, above, mirrored]
            }
        }
    }
}

/// The counts of the checked cases.
#[derive(Debug, Default)]
struct Checked {
    frames: u64,
    behind: u64,
    hidden: u64,
    /// Objects drawn, with frustum culling and with the strategy.
    drawn: [u64; 2],
}

/// Returns the image of each view with all objects drawn.
fn truths(views: &[CullView], scene: &Scene) -> Vec<Image> {
    let truth = |view: &CullView| {
        let mut image = Image::new(SIZE);
        for (solid, shift) in scene.solids.iter().zip(&scene.shifts) {
            image.draw(view, solid, *shift);
        }
        image
    };
    views.iter().map(truth).collect()
}

fn culler(seed: u64, random: &mut Random) -> Culler {
    let testers = VisibilityTestSupport {
        queries: true,
        flags: random.chance(0.7),
        compute: random.chance(0.3),
        leaf_tests: random.chance(0.7),
        draw_phases: [DrawPhases::PerRound, DrawPhases::Two][random.below(2)],
    };
    let mut culler = Culler::with_testers(CullConfig { seed, ..CullConfig::default() }, testers);
    if random.chance(0.2) {
        let costs = SceneCosts { triangles_per_leaf: 100.0 };
        culler.set_costs(CostTable::default(), costs).unwrap();
    }
    culler
}

/// Runs one seed.
fn verify(seed: u64, checked: &mut Checked) {
    let mut random = Random::new(seed.wrapping_mul(31) + 5);
    let sub_pixel_bits = [4, 8][random.below(2)];
    let mut scene = Scene::random(&mut random, sub_pixel_bits);
    let mut hierarchy = Hierarchy::build(&scene.bounds).unwrap();
    let mut camera = Path::start(&mut random);
    let rig = Rig::random(&mut random);
    let lens = match rig {
        Rig::Faces => Lens::Camera,
        _ => Lens::random(&mut random, &mut camera),
    };
    let path = PATHS[random.below(PATHS.len())];
    let is_moving = random.chance(0.4);
    let budget = [6, 10_000, 10_000][random.below(3)];
    let strategy = STRATEGIES[random.below(STRATEGIES.len())];
    let latency = 1 + random.below(3) as u64;
    let calm = Mishaps::none(latency);
    let rough = Mishaps { late: 0.3, lost: 0.2, twice: 0.2, listed: 6, ..calm };
    let mishaps = [calm, rough][random.below(2)];
    let mut runs = [Strategy::FRUSTUM, strategy].map(|strategy| {
        let device = Device::new(SIZE, sub_pixel_bits, mishaps, seed);
        (strategy, culler(seed, &mut random), device, FramePlan::default())
    });
    for frame in 0..FRAMES {
        path.advance(&mut camera, frame, &mut random);
        if is_moving {
            let object = scene.move_one(&mut random);
            hierarchy.refit([(ObjectId(object as u32), scene.bounds[object])]).unwrap();
        }
        let view = |camera: &Camera| lens.view(camera, frame, SIZE, sub_pixel_bits);
        let views: Vec<CullView> = rig.cameras(&camera).iter().map(view).collect();
        let views = MultiView::new(&views).unwrap();
        let truths = truths(views.as_slice(), &scene);
        let solids = Solids { solids: &scene.solids, shifts: &scene.shifts };
        for (run, (strategy, culler, device, plan)) in runs.iter_mut().enumerate() {
            let context = || format!("seed {seed}, frame {frame}, {strategy}, {rig:?}");
            culler.ingest(&hierarchy, device.collect(culler.frame().0 + 1, &hierarchy));
            culler.plan(&hierarchy, *strategy, views, budget, plan);
            invariants::check(&hierarchy, *strategy, views, budget, plan)
                .unwrap_or_else(|broken| panic!("{}: {broken}", context()));
            for test in &plan.tests {
                let VisibilityTest::SharedProxy(front) = test.tester else { continue };
                let front = culler.state(plan.tests[front as usize].tag.node);
                assert_eq!(front, NodeState::Hidden, "{}: what answers for others", context());
            }
            device.execute(views, &hierarchy, &solids, plan);
            for (number, (truth, image)) in truths.iter().zip(&device.images).enumerate() {
                assert!(truth.depths == image.depths, "{}: view {number} is wrong", context());
            }
            checked.frames += 1;
            checked.behind += u64::from(plan.stats.shared_proxies);
            checked.hidden += u64::from(plan.stats.tested_leaves);
            checked.drawn[run] += device.drawn.len() as u64;
        }
    }
}

#[test]
fn nothing_visible_in_any_view_is_ever_missing() {
    let mut checked = Checked::default();
    (0..seeds(SEEDS)).for_each(|seed| verify(seed, &mut checked));
    println!("{checked:?}");
    assert!(checked.behind > 40, "hardly a test answered for another");
    let [frustum, ours] = checked.drawn;
    assert!(ours * 20 < frustum * 19, "nothing was culled: {ours} of {frustum}");
}

/// Checks that a plan for a pair has about the number of tests of a plan for one eye.
#[test]
fn a_pair_of_eyes_costs_few_more_tests_than_one() {
    let scene = Scene::solid(crate::scene::city(&mut Random::new(3), 20));
    let hierarchy = Hierarchy::build(&scene.bounds).unwrap();
    let solids = Solids { solids: &scene.solids, shifts: &scene.shifts };
    let testers = VisibilityTestSupport { flags: true, leaf_tests: true, ..Default::default() };
    let mut camera = Camera {
        eye: Vec3::new(-1.0, 1.7, 60.0),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.1,
    };
    let mut counted = [0; 2];
    let mut runs = [1, 2].map(|_| {
        let device = Device::new(SIZE, 8, Mishaps::none(2), 1);
        (Culler::with_testers(CullConfig::default(), testers), device, FramePlan::default())
    });
    for _ in 0..60 {
        camera.eye.z -= 0.2;
        let eyes = Rig::Pair { apart: 0.065, turned: 0.0 }.cameras(&camera);
        let views: Vec<CullView> = eyes.iter().map(|eye| CullView::new(eye, SIZE, 8)).collect();
        for (run, (culler, device, plan)) in runs.iter_mut().enumerate() {
            let views = MultiView::new(&views[..=run]).unwrap();
            culler.ingest(&hierarchy, device.collect(culler.frame().0 + 1, &hierarchy));
            culler.plan(&hierarchy, Strategy::ANTUMBRA, views, 4096, plan);
            device.execute(views, &hierarchy, &solids, plan);
            counted[run] += plan.tests.len();
        }
    }
    let [one, pair] = counted;
    assert!(one > 500 && pair * 4 < one * 5, "{pair} tests for two eyes, {one} for one");
}
