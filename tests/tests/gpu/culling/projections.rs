//! Images are the same with and without culling in every kind of projection: orthographic,
//! jittered, off-centre, and with a far plane. All testers and all ways to skip draws are compared.

use cull::{Camera, ClipY, DepthConvention, Projection, Strategy, ViewProjection};
use glam::{Vec2, Vec3};
use gpu::{Device, OptionalFeature, PredicationMode};
use render::{CostModel, Error, FrameRequest, Renderer, RendererOptions, Viewpoint};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::projections::Lens;
use tests::walk::{ComparedWalk, SceneKind};
use tests::{Driver, run, run_on_all};

const SIZE: [u32; 2] = [160, 90];

const STRATEGIES: [Strategy; 5] = [
    Strategy::ANTUMBRA,
    Strategy::ANTUMBRA_QUERIES,
    Strategy::ANTUMBRA_FLAGS,
    Strategy::ANTUMBRA_COMPUTE,
    methods::HZB,
];

fn options(predication: Option<PredicationMode>) -> RendererOptions {
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        predication,
        // Everything that may be hidden is tested, regardless of its cost.
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

/// Walks with every strategy and every way to skip draws of a device. Returns the share of the
/// objects in the frustum that the first combination drew.
fn check(device: &Device, scene: &GeneratedScene, seen: &[Viewpoint], what: &str) -> f64 {
    let mut share = 1.0;
    let all = PredicationMode::ALL.map(Some);
    let has_all = device.capabilities().has(OptionalFeature::ConditionalRendering);
    let ways = if has_all { &all[..] } else { &[None] };
    for (number, way) in ways.iter().enumerate() {
        let mut walk = ComparedWalk::new(device, &scene.scene, seen, &options(*way));
        for strategy in STRATEGIES.into_iter().skip(number).step_by(ways.len()) {
            let found = walk.with(strategy);
            assert_eq!(found.pixels_wrong, 0, "{what}, {strategy}: {found:?}");
            assert_eq!(found.blocking_waits, 0, "{what}, {strategy}: {found:?}");
            if strategy == STRATEGIES[0] {
                share = found.draws[1] as f64 / found.draws[0].max(1) as f64;
            }
        }
    }
    share
}

/// Returns orthographic cameras: across streets, from above at a slant, and straight down.
fn orthographic(scene: &GeneratedScene) -> Vec<(&'static str, Vec<Camera>)> {
    let path = CameraPath::new(PathKind::Street, &scene.routes).unwrap();
    let along = |height: f32| Projection::Orthographic { height, far: 300.0 };
    let from = |offset: Vec3, frame: u32| {
        let camera = path.camera(frame);
        let eye = camera.eye + offset;
        let up = camera.forward;
        Camera { eye, forward: -offset, up, projection: along(40.0), near: 1.0 }
    };
    // The view from a street through the blocks beside it.
    let across = |frame: u32| {
        let camera = path.camera(frame * 5);
        let forward = camera.forward.cross(Vec3::Y);
        Camera { forward, projection: along(20.0), near: 0.0, ..camera }
    };
    let frames = 0..8_u32;
    vec![
        ("across", frames.clone().map(across).collect()),
        (
            "slant",
            frames.clone().map(|frame| from(Vec3::new(60.0, 70.0, 45.0), frame * 4)).collect(),
        ),
        ("down", frames.map(|frame| from(Vec3::Y * 120.0, frame * 4)).collect()),
    ]
}

#[test]
fn orthographic_views_are_exact_with_every_tester() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(500);
        for (what, cameras) in orthographic(&scene) {
            let seen: Vec<Viewpoint> = cameras.into_iter().map(Viewpoint::from).collect();
            let share = check(device, &scene, &seen, what);
            if what == "across" {
                assert!(share < 0.9, "{what}: {share} of all objects drawn");
            }
        }
    });
}

#[test]
fn jittered_and_off_centre_views_are_exact_with_every_tester() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(500);
        let path = CameraPath::new(PathKind::Street, &scene.routes).unwrap();
        let jittered = Lens { jitter_pixels: 0.5, ..Lens::PLAIN };
        let odd =
            Lens { y: ClipY::Up, far: Some(120.0), off_centre: Vec2::new(0.7, -0.4), ..jittered };
        for (lens, what) in [(jittered, "jittered"), (odd, "off-centre, far plane, y up")] {
            let seen: Vec<Viewpoint> = (0..9)
                .map(|frame| {
                    lens.projection(&path.camera(frame / 4 * 9), frame.into(), SIZE).into()
                })
                .collect();
            let share = check(device, &scene, &seen, what);
            assert!(share < 0.6, "{what}: {share} of all objects drawn");
        }
    });
}

#[test]
fn matrices_that_cannot_be_drawn_are_refused() {
    run(Driver::Lavapipe, |device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(20);
        let camera = CameraPath::new(PathKind::Street, &routes).unwrap().camera(0);
        let mut renderer = Renderer::new(device, &scene, &options(None)).unwrap();
        let mut view = renderer.new_view().unwrap();
        let mut render = |projection: ViewProjection| {
            renderer.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, projection))
        };
        let good = Lens::PLAIN.projection(&camera, 0, SIZE);
        let standard = Lens { depth: DepthConvention::Standard, ..Lens::PLAIN };
        let error = render(standard.projection(&camera, 0, SIZE)).unwrap_err();
        assert!(matches!(error, Error::StandardDepth), "{error}");
        let flat = ViewProjection { matrix: glam::Mat4::ZERO, ..good };
        let error = render(flat).unwrap_err();
        assert!(matches!(error, Error::CullView(_)), "{error}");
        render(good).unwrap();
    });
}
