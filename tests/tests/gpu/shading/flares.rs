//! Lens flares. The visible fraction of a light comes from the depth N frames earlier. Bars in
//! front of the light change the fraction only as fast as they cover the light. Images do not
//! depend on culling.

mod occluders;

use cull::{Aabb, Camera, CullView, ObjectId, Strategy};
use glam::{Affine3A, Quat, Vec2, Vec3, vec3};
use gpu::{Device, Readback};
use render::{
    CostModel, Error, FlareBlock, FlareSamples, FrameRequest, RenderView, Renderer,
    RendererOptions, ViewRequest, ViewsRequest,
};
use scene::limits::MAX_FLARES;
use scene::{FlarePlace, LensFlare, ObjectChange, Scene};
use tests::shapes::{box_at, box_scene, square_camera};
use tests::walk::images_that_differ;
use tests::{Driver, run, run_on_all};

pub const SIDE: u32 = 128;
pub const SIZE: [u32; 2] = [SIDE, SIDE];

pub fn options(frames_in_flight: usize) -> RendererOptions {
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        frames_in_flight,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

pub fn lamp(point: Vec3, radius: f32) -> LensFlare {
    LensFlare {
        place: FlarePlace::At(point),
        radius,
        colour: [0.9, 0.7, 0.5],
        glow: 0.4,
        ghosts: 1.0,
    }
}

fn sun(direction: Vec3) -> LensFlare {
    LensFlare { place: FlarePlace::Towards(direction), ..lamp(Vec3::ZERO, 0.1) }
}

/// Returns the bars of a fence, slightly slanted so that they are seen from one side.
fn fence(shift: f32) -> Vec<Aabb> {
    let bar = |number: i32| {
        let left = number as f32 * 0.83 - 5.0 + shift;
        Aabb::new(vec3(left, -4.0, -5.2), vec3(left + 0.41, 4.0, -5.0))
    };
    (0..13).map(bar).collect()
}

/// Returns the view depth at which the ray through a place in the image first meets a box (metres).
fn hit_m(view: &CullView, ndc: Vec2, boxes: &[Aabb]) -> f32 {
    let from = view.rays.origin;
    let to = view.rays.point(ndc, 1.0);
    let towards = to - from;
    let met = |bounds: &Aabb| {
        let a = (bounds.min - from) / towards;
        let b = (bounds.max - from) / towards;
        let enter = a.min(b).max_element();
        let leave = a.max(b).min_element();
        (enter <= leave && enter > 0.0).then_some(enter)
    };
    boxes.iter().filter_map(met).fold(f32::INFINITY, f32::min)
}

/// The pixels of a block by ray casting: pixels that surely show the light, and pixels at the edge
/// of a box.
#[derive(Debug, Clone, Copy)]
struct Expected {
    total: u32,
    visible: u32,
    unsure: u32,
}

impl Expected {
    fn of(flare: &LensFlare, view: &CullView, boxes: &[Aabb]) -> Self {
        let mut expected = Self { total: 0, visible: 0, unsure: 0 };
        let Some(block) = FlareBlock::of(flare, view) else { return expected };
        let near = view.rays.depth[1];
        for y in 0..block.side as i32 {
            for x in 0..block.side as i32 {
                let pixel = [block.origin[0] + x, block.origin[1] + y];
                let is_in = |axis: usize| (0..view.size[axis] as i32).contains(&pixel[axis]);
                if !is_in(0) || !is_in(1) {
                    continue;
                }
                expected.total += 1;
                // A device with four sub-pixel bits moves vertices by up to a 32nd of a pixel.
                let shows =
                    [(0.0, 0.0), (-0.04, -0.04), (-0.04, 0.04), (0.04, -0.04), (0.04, 0.04)].map(
                        |(right, down)| {
                            let at = |axis: usize, by: f32| {
                                (pixel[axis] as f32 + 0.5 + by) * 2.0 / view.size[axis] as f32 - 1.0
                            };
                            let ndc = Vec2::new(at(0, right), at(1, down));
                            near / hit_m(view, ndc, boxes) <= block.depth
                        },
                    );
                match shows.iter().filter(|shows| **shows).count() {
                    0 => {}
                    5 => expected.visible += 1,
                    _ => expected.unsure += 1,
                }
            }
        }
        expected
    }

    fn assert_fits(&self, samples: &FlareSamples, what: &str) {
        assert_eq!(samples.total, self.total, "{what}: {samples:?}");
        let possible = self.visible..=self.visible + self.unsure;
        assert!(possible.contains(&samples.visible), "{what}: {samples:?} {self:?}");
    }
}

pub fn draw(
    renderer: &mut Renderer,
    view: &mut RenderView,
    strategy: Strategy,
    camera: Camera,
) -> Readback {
    let image = Readback::new(renderer.device(), renderer.size()).unwrap();
    let request = FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, camera) };
    renderer.render(view, request).unwrap();
    image
}

/// Returns the samples of the first flare for a frame in which the scene is at rest.
pub fn settled(renderer: &mut Renderer, view: &mut RenderView, strategy: Strategy) -> FlareSamples {
    for _ in 0..=renderer.frames_in_flight() {
        draw(renderer, view, strategy, square_camera());
    }
    view.flares()[0].samples.unwrap()
}

const STRATEGIES: [Strategy; 3] = [Strategy::FRUSTUM, Strategy::ANTUMBRA, methods::HZB];

/// Moves a fence sideways before a lamp and a sun, and a lamp past the edge of the image.
#[test]
fn the_fraction_is_that_of_the_depth_n_frames_earlier() {
    run_on_all(|device| {
        for frames_in_flight in [1, 2, 3] {
            let scene = box_scene(&fence(0.0));
            let options = options(frames_in_flight);
            let mut renderer = Renderer::new(device, &scene, &options).unwrap();
            for strategy in STRATEGIES {
                cross(device, &mut renderer, &scene, strategy, frames_in_flight as u64);
            }
        }
    });
}

/// The distance that the fence moves per frame.
const STEP_M: f32 = 0.045;

fn cross(device: &Device, renderer: &mut Renderer, scene: &Scene, strategy: Strategy, age: u64) {
    let mut view = renderer.new_view().unwrap();
    let camera = |frame: u32| Camera { eye: Vec3::X * (0.01 * frame as f32), ..square_camera() };
    let mut expected: Vec<[Expected; 3]> = Vec::new();
    let mut unsure = 0;
    let mut counted = 0;
    let mut fractions: Vec<f32> = Vec::new();
    let waits = device.wait_counts().other;
    for frame in 0..40 {
        let boxes = fence(frame as f32 * STEP_M);
        let moves = scene.objects.iter().zip(0..).map(|(object, number)| {
            let by = Affine3A::from_translation(Vec3::X * (frame as f32 * STEP_M));
            ObjectChange::Move { object: ObjectId(number), transform: by * object.transform }
        });
        renderer.update(&moves.collect::<Vec<_>>()).unwrap();
        let leaving = lamp(vec3(8.0 + frame as f32 * 0.1, 0.5, -10.0), 0.6);
        let flares = [lamp(vec3(0.1, 0.2, -10.0), 1.0), sun(vec3(-0.2, 0.1, -1.0)), leaving];
        renderer.set_flares(&flares).unwrap();
        let seen = renderer.view_of(&camera(frame));
        expected.push(flares.map(|flare| Expected::of(&flare, &seen, &boxes)));
        renderer.render(&mut view, FrameRequest::new(strategy, camera(frame))).unwrap();
        let Some(of) = (frame as usize).checked_sub(age as usize) else {
            assert!(view.flares().iter().all(|state| state.samples.is_none()));
            continue;
        };
        for (number, (state, expected)) in view.flares().iter().zip(expected[of]).enumerate() {
            let samples = state.samples.unwrap();
            assert_eq!((samples.age_frames, samples.frame.0), (age, of as u64 + 1));
            expected.assert_fits(&samples, &format!("{strategy}, {age}, {frame}, {number}"));
            (unsure, counted) = (unsure + expected.unsure, counted + expected.total);
        }
        fractions.push(view.flares()[0].fraction());
    }
    assert_eq!(device.wait_counts().other, waits, "{strategy} waited");
    assert!(unsure * 20 < counted, "a reference that knows: {unsure} of {counted}");
    // Bars cover half of the block, and each edge in it moves by less than a pixel per frame: at
    // most one column changes per edge.
    let side = 13.0;
    let edges = 4.0;
    for pair in fractions.windows(2) {
        assert!((pair[1] - pair[0]).abs() <= edges / side + 1.0e-6, "{strategy}: {pair:?}");
    }
    let [least, most] =
        [f32::min, f32::max].map(|of| fractions.iter().copied().reduce(of).unwrap());
    assert!(least > 0.2 && most < 0.85 && most - least > 0.05, "{strategy}: {least} to {most}");
    let left = view.flares()[2].samples.unwrap();
    assert_eq!((left.total, view.flares()[2].brightness), (0, 0.0), "{left:?}");
    renderer.wait_idle(&mut view).unwrap();
}

/// Returns the fence, a wall beside it, and rows of boxes behind both.
fn crowd() -> Vec<Aabb> {
    let mut boxes = fence(0.0);
    boxes.push(Aabb::new(vec3(1.5, -4.0, -6.2), vec3(9.0, 4.0, -6.0)));
    boxes.extend((0..300).map(|number| {
        let row = number / 30;
        let column = number % 30;
        let place = vec3(column as f32 - 15.0, row as f32 * 0.4 - 2.0, -8.0 - row as f32 * 1.3);
        box_at(place, vec3(0.3, 0.15, 0.3))
    }));
    boxes
}

#[test]
fn images_with_flares_are_the_same_with_and_without_culling() {
    run_on_all(|device| {
        let mut renderer = Renderer::new(device, &box_scene(&crowd()), &options(2)).unwrap();
        let row = |number: i32| lamp(vec3(number as f32 * 1.7 - 6.0, 0.3, -9.0), 0.9);
        let mut flares = vec![sun(vec3(0.2, 0.3, -1.0)), sun(vec3(-0.3, 0.0, -1.0))];
        flares.extend((0..8).map(row));
        let camera = |frame: u32| Camera {
            eye: vec3(0.07 * frame as f32 - 1.0, 0.1, 0.03 * frame as f32),
            ..square_camera()
        };
        let film = |renderer: &mut Renderer, strategy| {
            let mut view = renderer.new_view().unwrap();
            let mut partial = 0;
            let images = (0..30).map(|frame| {
                let image = draw(renderer, &mut view, strategy, camera(frame));
                let fractions = view.flares().iter().map(|state| state.fraction());
                partial += fractions.filter(|fraction| (0.05..0.95).contains(fraction)).count();
                image
            });
            let images: Vec<Readback> = images.collect();
            renderer.wait_idle(&mut view).unwrap();
            (images, partial)
        };
        let (plain, _) = film(&mut renderer, Strategy::FRUSTUM);
        renderer.set_flares(&flares).unwrap();
        let (expected, partial) = film(&mut renderer, Strategy::FRUSTUM);
        let differ = |a: &[Readback], b: &[Readback]| -> usize {
            let pairs = a.iter().zip(b);
            let pair = |(a, b): (&Readback, &Readback)| images_that_differ(a, b);
            pairs.map(pair).sum()
        };
        assert!(differ(&plain, &expected) > 2_000, "flares show");
        assert!(partial > 100, "bars cut them: {partial}");
        for strategy in [Strategy::ANTUMBRA, Strategy::ANTUMBRA_QUERIES, methods::HZB] {
            let (found, _) = film(&mut renderer, strategy);
            for (frame, (a, b)) in expected.iter().zip(&found).enumerate() {
                let wrong = images_that_differ(a, b);
                assert_eq!(wrong, 0, "{strategy}, frame {frame}");
            }
        }
        renderer.set_flares(&[]).unwrap();
        assert_eq!(differ(&plain, &film(&mut renderer, Strategy::ANTUMBRA).0), 0);
    });
}

#[test]
fn each_view_has_flares_of_its_own() {
    run_on_all(|device| {
        let wall = Aabb::new(vec3(-8.0, -8.0, -5.1), vec3(0.0, 8.0, -5.0));
        let mut renderer = Renderer::new(device, &box_scene(&[wall]), &options(2)).unwrap();
        renderer.set_flares(&[lamp(vec3(0.0, 0.0, -10.0), 1.0)]).unwrap();
        let mut views = [(); 2].map(|()| renderer.new_view().unwrap());
        let eyes = [-3.0, 3.0].map(|x| Camera { eye: Vec3::X * x, ..square_camera() });
        let areas = [0, 64].map(|x| render::Rect { origin: [x, 30], size: [64, 64] });
        for _ in 0..8 {
            let targets = views.iter_mut().zip(eyes).zip(areas);
            let mut targets: Vec<ViewRequest<'_>> = targets
                .map(|((state, camera), rect)| ViewRequest {
                    state,
                    viewpoint: camera.into(),
                    visible: None,
                    rect,
                })
                .collect();
            let request = ViewsRequest {
                strategy: Strategy::ANTUMBRA,
                image: None,
                overlay: None,
                after: None,
            };
            renderer.render_views(&mut targets, &request).unwrap();
        }
        let [hidden, seen] = views.each_ref().map(|view| view.flares()[0]);
        assert_eq!((hidden.fraction(), hidden.brightness), (0.0, 0.0), "{hidden:?}");
        assert_eq!((seen.fraction(), seen.brightness), (1.0, 1.0), "{seen:?}");
        // A view with a cleared history begins without flares.
        views[1].reset();
        let request = FrameRequest::new(Strategy::ANTUMBRA, eyes[1]);
        renderer.render(&mut views[1], request).unwrap();
        assert_eq!(views[1].flares()[0], render::FlareState::default());
        for view in &mut views {
            renderer.wait_idle(view).unwrap();
        }
    });
}

#[test]
fn no_flares_cost_nothing() {
    run_on_all(|device| {
        let mut renderer = Renderer::new(device, &box_scene(&fence(0.0)), &options(2)).unwrap();
        renderer.time_passes().unwrap();
        let mut view = renderer.new_view().unwrap();
        let labels = |renderer: &mut Renderer, view: &mut RenderView| {
            for _ in 0..8 {
                draw(renderer, view, Strategy::ANTUMBRA, square_camera());
            }
            let passes = renderer.pass_times().iter();
            passes.filter(|pass| pass.label.contains("flares")).count()
        };
        assert_eq!(labels(&mut renderer, &mut view), 0);
        renderer.set_flares(&[lamp(vec3(0.0, 0.0, -10.0), 1.0)]).unwrap();
        assert_eq!(labels(&mut renderer, &mut view), 2);
        // A light outside the view needs no query.
        renderer.set_flares(&[lamp(vec3(0.0, 0.0, 10.0), 1.0)]).unwrap();
        assert_eq!(labels(&mut renderer, &mut view), 0);
        renderer.set_flares(&[]).unwrap();
        assert_eq!(labels(&mut renderer, &mut view), 0);
        assert_eq!(view.flares(), []);
        renderer.wait_idle(&mut view).unwrap();
    });
}

#[test]
fn impossible_flares_are_refused_by_a_sentence() {
    run(Driver::Lavapipe, |device| {
        let mut renderer = Renderer::new(device, &box_scene(&fence(0.0)), &options(2)).unwrap();
        let good = lamp(vec3(0.0, 0.0, -10.0), 1.0);
        renderer.set_flares(&[good]).unwrap();
        let bad = LensFlare { radius: f32::NAN, ..good };
        let error = renderer.set_flares(&[good, bad]).unwrap_err();
        assert!(matches!(error, Error::Flare { index: 1, .. }), "{error}");
        let error = renderer.set_flares(&vec![good; MAX_FLARES + 1]).unwrap_err();
        assert!(matches!(error, Error::SceneTooLarge { .. }), "{error}");
        assert_eq!(renderer.flares(), [good]);
        renderer.set_flares(&[good; MAX_FLARES]).unwrap();
        let mut view = renderer.new_view().unwrap();
        let samples = settled(&mut renderer, &mut view, Strategy::ANTUMBRA);
        assert!(samples.total > 0);
        assert!(view.flares().iter().all(|state| *state == view.flares()[0]));
        renderer.wait_idle(&mut view).unwrap();
    });
}

pub fn moved(by: Vec3) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::IDENTITY, by)
}
