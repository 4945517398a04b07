//! Tests of several views with their own histories on one budget of queries: each image is the same
//! as with everything drawn, and no view stays without queries.

use antumbra_cull::{
    Camera, CullConfig, CullView, Culler, DrawPhases, FramePlan, Hierarchy, ObjectId, QueryShares,
    Strategy, VisibilityTestSupport,
};
use glam::Vec3;

use crate::device::{Device, Mishaps, Solids};
use crate::image::Image;
use crate::invariants;
use crate::random::Random;
use crate::scene::{Path, Scene, city};

const SEEDS: u64 = 500;
const FRAMES: u64 = 20;
const SIZE: [u32; 2] = [28, 20];

/// A view with its history and the simulated GPU that answers it.
struct SharingView {
    culler: Culler,
    device: Device,
    plan: FramePlan,
    camera: Camera,
}

impl SharingView {
    fn new(seed: u64, camera: Camera, mishaps: Mishaps, testers: VisibilityTestSupport) -> Self {
        let config = CullConfig { seed, ..CullConfig::default() };
        Self {
            culler: Culler::with_testers(config, testers),
            device: Device::new(SIZE, 8, mishaps, seed),
            plan: FramePlan::default(),
            camera,
        }
    }

    fn queries(&self) -> usize {
        self.plan.query_count()
    }
}

/// Plans and executes a frame, and checks images and plans. Returns the share of each view.
fn draw(
    scene: &Scene,
    hierarchy: &Hierarchy,
    shares: &mut QueryShares,
    query_budget: usize,
    strategy: Strategy,
    views: &mut [SharingView],
) -> Vec<usize> {
    let mut shared = vec![0; views.len()];
    shares.plan_views(query_budget, views, SharingView::queries, |number, view, share| {
        let SharingView { culler, device, plan, camera } = view;
        culler.ingest(hierarchy, device.collect(culler.frame().0 + 1, hierarchy));
        let eye = CullView::new(camera, SIZE, 8);
        culler.plan(hierarchy, strategy, &eye, share, plan);
        invariants::check(hierarchy, strategy, &eye, share, plan).unwrap();
        shared[number] = share;
    });
    let queries: usize = views.iter().map(SharingView::queries).sum();
    assert!(queries <= query_budget, "{queries} queries of {query_budget}");
    let solids = Solids { solids: &scene.solids, shifts: &scene.shifts };
    for (number, SharingView { device, plan, camera, .. }) in views.iter_mut().enumerate() {
        let eye = CullView::new(camera, SIZE, 8);
        device.execute(&eye, hierarchy, &solids, plan);
        let mut truth = Image::new(SIZE);
        for (solid, shift) in scene.solids.iter().zip(&scene.shifts) {
            truth.draw(&eye, solid, *shift);
        }
        assert!(truth.depths == device.images[0].depths, "view {number} is wrong");
    }
    shared
}

/// Runs one seed. Returns the objects drawn, and those in the frustum.
fn verify(seed: u64) -> [u64; 2] {
    let mut random = Random::new(seed.wrapping_mul(37) + 11);
    let mut scene = Scene::random(&mut random, 8);
    let mut hierarchy = Hierarchy::build(&scene.bounds).unwrap();
    let count = 1 + random.below(6);
    let query_budget = [0, 1, 3, 12, 40, 10_000][random.below(6)];
    let strategy = [Strategy::ANTUMBRA, Strategy::ANTUMBRA_QUERIES][random.below(2)];
    let calm = Mishaps::none(1 + random.below(3) as u64);
    let rough = Mishaps { late: 0.3, lost: 0.2, twice: 0.2, listed: 6, ..calm };
    let mishaps = [calm, rough][random.below(2)];
    let testers = VisibilityTestSupport {
        queries: true,
        flags: random.chance(0.4),
        compute: false,
        leaf_tests: random.chance(0.5),
        draw_phases: [DrawPhases::PerRound, DrawPhases::Two][random.below(2)],
    };
    let path = [Path::Still, Path::Turning, Path::Cuts, Path::Wander][random.below(4)];
    let mut views: Vec<SharingView> = (0..count as u64)
        .map(|view| SharingView::new(seed + view, Path::start(&mut random), mishaps, testers))
        .collect();
    let mut shares = QueryShares::default();
    let mut drawn = [0; 2];
    for frame in 0..FRAMES {
        views.iter_mut().for_each(|view| path.advance(&mut view.camera, frame, &mut random));
        if random.chance(0.3) {
            let object = scene.move_one(&mut random);
            hierarchy.refit([(ObjectId(object as u32), scene.bounds[object])]).unwrap();
        }
        draw(&scene, &hierarchy, &mut shares, query_budget, strategy, &mut views);
        for SharingView { device, plan, .. } in &views {
            drawn[0] += device.drawn.len() as u64;
            drawn[1] += (plan.draws.len() + plan.queried_draws.len()) as u64;
            drawn[1] += u64::from(plan.stats.tested_leaves);
        }
    }
    drawn
}

#[test]
fn views_on_one_budget_are_exact() {
    let mut drawn = [0; 2];
    for seed in 0..SEEDS {
        let found = std::panic::catch_unwind(|| verify(seed));
        let [ours, all] = found.unwrap_or_else(|_| panic!("seed {seed}"));
        drawn[0] += ours;
        drawn[1] += all;
    }
    let [ours, all] = drawn;
    assert!(ours * 20 < all * 19, "nothing was culled: {ours} of {all}");
}

/// Checks that a view of an empty corner leaves its queries to views of a city, and that with fewer
/// queries than views each view gets some in turn.
#[test]
fn queries_go_where_they_are_asked_for() {
    let scene = Scene::solid(city(&mut Random::new(3), 16));
    let hierarchy = Hierarchy::build(&scene.bounds).unwrap();
    let street = Camera { eye: Vec3::new(-1.0, 1.7, 60.0), ..Path::start(&mut Random::new(1)) };
    let camera = |forward| Camera { forward, near: 0.1, ..street };
    let cameras = [Vec3::NEG_Z, Vec3::Z, Vec3::new(-0.4, 0.0, -1.0)].map(camera);
    let new_views = || {
        let new = |camera| {
            SharingView::new(1, camera, Mishaps::none(2), VisibilityTestSupport::default())
        };
        cameras.map(new)
    };
    let draw_frames = |query_budget| {
        let mut views = new_views();
        let mut shares = QueryShares::default();
        let frames = (0..40).map(|_| {
            let strategy = Strategy::ANTUMBRA;
            let given = draw(&scene, &hierarchy, &mut shares, query_budget, strategy, &mut views);
            (given, [0, 1, 2].map(|view: usize| views[view].queries()))
        });
        frames.collect::<Vec<_>>()
    };
    let rich = &draw_frames(60)[20..];
    assert!(rich.iter().all(|(_, used)| used[1] < 5), "the view of the corner is cheap: {rich:?}");
    assert!(rich.iter().all(|(given, _)| given[0] > 26 && given[2] > 26), "{rich:?}");
    let poor = draw_frames(1);
    for view in [0, 2] {
        let served = poor.windows(4).all(|window| window.iter().any(|(given, _)| given[view] == 1));
        assert!(served, "view {view}: {poor:?}");
    }
}
