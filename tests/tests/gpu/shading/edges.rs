//! Edges as in CAD drawings: the same with every strategy and every way to draw them. Hidden edges
//! are dashed and always shown, silhouettes are closed, and edges that are off cost nothing.

mod changes;
mod outlines;

use std::f32::consts::TAU;

use ash::vk;
use cull::{Camera, Projection, Strategy};
use glam::{Quat, Vec3, vec3};
use gpu::{Device, DeviceOptions, OptionalFeature, Readback, SampleCount};
use render::{
    CostModel, EdgeMode, EdgeOptions, FrameRequest, RenderView, Renderer, RendererOptions,
};
use scene::{Mesh, Scene};
use scenes::{CameraPath, PathKind};
use tests::fault_injection::FaultInjection;
use tests::shapes::{box_at, box_scene};
use tests::walk::{SceneKind, frame_loop, images_that_differ, pixels_that_differ};
use tests::{Driver, instance_with, run, run_on_all};

const SIZE: [u32; 2] = [160, 120];

/// The encoded colours: visible edges, hidden edges, paper.
const BLACK: [u8; 3] = [0, 0, 0];
const RED: [u8; 3] = [255, 0, 0];
const WHITE: [u8; 3] = [255, 255, 255];

fn options(mode: EdgeMode) -> EdgeOptions {
    EdgeOptions { mode, hidden_colour: [1.0, 0.0, 0.0], ..EdgeOptions::default() }
}

fn renderer_of(device: &Device, scene: &Scene, samples: SampleCount) -> Renderer {
    let options = RendererOptions {
        methods: methods::all(),
        size: SIZE,
        samples,
        cost_model: CostModel::Off,
        ..Default::default()
    };
    Renderer::new(device, scene, &options).unwrap()
}

/// An image of RGBA.
struct Image(Vec<u8>);

impl Image {
    fn at(&self, x: u32, y: u32) -> [u8; 3] {
        let place = 4 * (y * SIZE[0] + x) as usize;
        self.0[place..place + 3].try_into().unwrap()
    }

    fn count(&self, colour: [u8; 3]) -> usize {
        self.0.as_chunks::<4>().0.iter().filter(|pixel| pixel[..3] == colour).count()
    }

    /// Returns the number of pixels of a colour in an area and two pixels around it.
    fn count_near(&self, area: &Area, colour: [u8; 3]) -> usize {
        let columns = area.left - 2..=area.right + 2;
        let pixels =
            (area.top - 2..=area.bottom + 2).flat_map(|y| columns.clone().map(move |x| (x, y)));
        pixels.filter(|(x, y)| self.at(*x, *y) == colour).count()
    }
}

/// A part of an image in pixels, including the last column and row.
struct Area {
    left: u32,
    top: u32,
    right: u32,
    bottom: u32,
}

fn draw(renderer: &mut Renderer, view: &mut RenderView, strategy: Strategy, seen: Camera) -> Image {
    let image = Readback::new(renderer.device(), SIZE).unwrap();
    let request = FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, seen) };
    renderer.render(view, request).unwrap();
    renderer.wait_idle(view).unwrap();
    Image(image.rgba8().unwrap().to_vec())
}

/// Returns the fourth image of a view at rest: by then the strategy knows the hidden objects.
fn settled(renderer: &mut Renderer, strategy: Strategy, seen: Camera) -> Image {
    let mut view = renderer.new_view().unwrap();
    let images = [0; 4].map(|_| draw(renderer, &mut view, strategy, seen));
    let [.., last] = images;
    last
}

fn exact() -> impl Iterator<Item = Strategy> {
    let is_usual = |strategy: &Strategy| strategy.is_exact() && !strategy.needs_still_scene();
    methods::strategies().into_iter().filter(is_usual)
}

/// Looks along -z at 8 by 6 metres, with 20 pixels per metre.
fn straight() -> Camera {
    Camera {
        eye: Vec3::ZERO,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::Orthographic { height: 6.0, far: 100.0 },
        near: 0.0,
    }
}

#[test]
fn a_far_box_wholly_behind_a_near_one_has_no_visible_and_four_dashed_edges() {
    let near = box_at(vec3(0.0, 0.0, -10.0), vec3(2.0, 2.0, 1.0));
    let far = box_at(vec3(0.0, 0.0, -20.0), vec3(1.0, 1.0, 3.0));
    run_on_all(|device| {
        let alone = {
            let mut renderer = renderer_of(device, &box_scene(&[near]), SampleCount::One);
            renderer.set_edges(options(EdgeMode::HiddenDashed)).unwrap();
            settled(&mut renderer, Strategy::FRUSTUM, straight())
        };
        // Two pixels wide, one of them outside 80 by 80 pixels.
        assert_eq!(alone.count(BLACK), 82 * 82 - 78 * 78);
        let mut renderer = renderer_of(device, &box_scene(&[near, far]), SampleCount::One);
        for strategy in exact() {
            renderer.set_edges(options(EdgeMode::Visible)).unwrap();
            let visible = settled(&mut renderer, strategy, straight());
            assert_eq!(visible.count(BLACK), alone.count(BLACK), "{strategy}");
            assert_eq!(visible.count(WHITE) + visible.count(BLACK), 160 * 120, "{strategy}");
            renderer.set_edges(options(EdgeMode::HiddenDashed)).unwrap();
            let dashed = settled(&mut renderer, strategy, straight());
            assert_eq!(dashed.count(BLACK), alone.count(BLACK), "{strategy}");
            // The far box is 40 pixels wide, around the middle: all four sides, and nothing else.
            let whole = Area { left: 60, top: 40, right: 100, bottom: 80 };
            let sides = [
                Area { bottom: 40, ..whole },
                Area { top: 80, ..whole },
                Area { right: 60, ..whole },
                Area { left: 100, ..whole },
            ];
            for side in sides {
                let red = dashed.count_near(&side, RED);
                let paper = dashed.count_near(&side, WHITE);
                assert!(red >= 40 && paper >= 40, "{strategy}: {red} red, {paper} white");
            }
            let around = dashed.count_near(&whole, RED);
            let middle = Area { left: 64, top: 44, right: 96, bottom: 76 };
            let inside = dashed.count_near(&middle, RED);
            assert_eq!((around, inside), (dashed.count(RED) - alone.count(RED), 0), "{strategy}");
        }
    });
}

#[test]
fn a_beam_wholly_under_a_slab_is_dashed_and_never_absent() {
    let slab = box_at(vec3(0.0, 2.0, 0.0), vec3(4.0, 0.2, 4.0));
    let beam = box_at(vec3(0.0, 1.0, 0.0), vec3(2.5, 0.3, 0.3));
    let above = Camera {
        eye: vec3(1.0, 12.0, 2.0),
        forward: vec3(-0.08, -1.0, -0.15),
        up: Vec3::NEG_Z,
        projection: Projection::perspective(1.0),
        near: 0.1,
    };
    run_on_all(|device| {
        let alone = {
            let mut renderer = renderer_of(device, &box_scene(&[slab]), SampleCount::One);
            renderer.set_edges(options(EdgeMode::ShadedWithHiddenDashed)).unwrap();
            settled(&mut renderer, Strategy::FRUSTUM, above)
        };
        let mut renderer = renderer_of(device, &box_scene(&[slab, beam]), SampleCount::One);
        for strategy in exact() {
            renderer.set_edges(options(EdgeMode::ShadedWithHiddenDashed)).unwrap();
            let dashed = settled(&mut renderer, strategy, above);
            let red = dashed.count(RED);
            assert!(red > alone.count(RED) + 100, "{strategy}: {red} red");
            renderer.set_edges(options(EdgeMode::Shaded)).unwrap();
            assert_eq!(settled(&mut renderer, strategy, above).count(RED), 0, "{strategy}");
        }
    });
}

/// Returns an upright cylinder of radius 1 and height 2 around the origin, with one vertex per
/// corner of each triangle.
fn cylinder(sides: u32) -> Mesh {
    let at = |side: u32, y: f32| {
        let angle = TAU * (side % sides) as f32 / sides as f32;
        [angle.cos(), y, angle.sin()]
    };
    let mut corners = Vec::new();
    for side in 0..sides {
        let next = side + 1;
        let middle = |y: f32| [0.0, y, 0.0];
        corners.extend([at(side, -1.0), at(side, 1.0), at(next, 1.0)]);
        corners.extend([at(side, -1.0), at(next, 1.0), at(next, -1.0)]);
        corners.extend([at(side, 1.0), middle(1.0), at(next, 1.0)]);
        corners.extend([at(next, -1.0), middle(-1.0), at(side, -1.0)]);
    }
    Mesh::of_triangles(
        "cylinder",
        &corners.into_iter().map(|place| (place, [0.5; 3])).collect::<Vec<_>>(),
    )
}

/// Returns true if paper leads from the corner of an image to its middle.
fn reaches_the_middle(image: &Image) -> bool {
    let mut is_seen = vec![false; (SIZE[0] * SIZE[1]) as usize];
    let mut open = vec![[0_u32; 2]];
    while let Some([x, y]) = open.pop() {
        let is_paper = x < SIZE[0] && y < SIZE[1] && image.at(x, y) == WHITE;
        if is_paper && !std::mem::replace(&mut is_seen[(y * SIZE[0] + x) as usize], true) {
            open.extend([[x + 1, y], [x.wrapping_sub(1), y], [x, y + 1], [x, y.wrapping_sub(1)]]);
        }
    }
    is_seen[(SIZE[1] / 2 * SIZE[0] + SIZE[0] / 2) as usize]
}

#[test]
fn a_cylinder_has_a_closed_outline_from_everywhere() {
    run_on_all(|device| {
        let mut renderer = renderer_of(device, &Scene::single(cylinder(48)), SampleCount::One);
        for view in 0..24 {
            let turn = Quat::from_rotation_y(0.37 * view as f32)
                * Quat::from_rotation_x(-1.5 + 0.13 * view as f32);
            let projection = match view % 2 {
                0 => Projection::perspective(0.8),
                _ => Projection::Orthographic { height: 4.0, far: 20.0 },
            };
            let eye = turn * Vec3::Z * 6.0;
            let forward = turn * Vec3::NEG_Z;
            let seen = Camera { eye, forward, up: turn * Vec3::Y, projection, near: 0.1 };
            for mode in [EdgeMode::Visible, EdgeMode::HiddenDashed] {
                renderer.set_edges(EdgeOptions { width_pixels: 1.5, ..options(mode) }).unwrap();
                let image = settled(&mut renderer, Strategy::FRUSTUM, seen);
                assert!(!reaches_the_middle(&image), "view {view} is open");
                assert!(image.count(WHITE) > 160 * 120 / 2, "view {view} is full");
            }
        }
    });
}

fn walk(device: &Device, scene: &Scene, cameras: &[Camera], samples: SampleCount) {
    let mut renderer = renderer_of(device, scene, samples);
    let modes = [EdgeMode::Visible, EdgeMode::HiddenDashed, EdgeMode::ShadedWithHiddenDashed];
    for (number, mode) in modes.into_iter().enumerate() {
        // Wide, so that lines reach far beyond what hides their objects.
        renderer.set_edges(EdgeOptions { width_pixels: 5.0, ..options(mode) }).unwrap();
        let mut images = |strategy| {
            let mut view = renderer.new_view().unwrap();
            frame_loop(&mut renderer, &mut view, strategy, cameras).images
        };
        let expected = images(Strategy::FRUSTUM);
        // The modes share the strategies.
        let strategies = exact().filter(|strategy| *strategy != Strategy::FRUSTUM);
        for strategy in strategies.skip(number).step_by(modes.len()) {
            for (frame, (a, b)) in expected.iter().zip(images(strategy)).enumerate() {
                let wrong = images_that_differ(a, &b);
                assert_eq!(wrong, 0, "{strategy}, {mode:?}, frame {frame}");
            }
        }
    }
}

fn city() -> (Scene, Vec<Camera>) {
    let city = SceneKind::City.build(300);
    let path = CameraPath::new(PathKind::Street, &city.routes).unwrap();
    (city.scene, (0..4).map(|frame| path.camera(7 * frame)).collect())
}

#[test]
fn every_strategy_draws_the_same_edges() {
    let (scene, cameras) = city();
    run_on_all(|device| walk(device, &scene, &cameras, SampleCount::One));
}

#[test]
fn edges_of_panes_and_of_four_samples_are_the_same_under_every_strategy() {
    let cameras: Vec<Camera> = (0..4).map(crate::shading::transparent::camera).collect();
    let scene = crate::shading::transparent::scene();
    run_on_all(|device| {
        walk(device, &scene, &cameras[..2], SampleCount::One);
        if device.capabilities().has(OptionalFeature::SampleDepths) {
            walk(device, &scene, &cameras, SampleCount::Four);
        }
    });
}

#[test]
fn the_geometry_shader_and_quads_draw_the_same_bits() {
    let (scene, cameras) = city();
    let film = |device: &Device| {
        let mut renderer = renderer_of(device, &scene, SampleCount::One);
        let mut view = renderer.new_view().unwrap();
        renderer
            .set_edges(EdgeOptions { width_pixels: 3.0, ..options(EdgeMode::HiddenDashed) })
            .unwrap();
        frame_loop(&mut renderer, &mut view, Strategy::ANTUMBRA, &cameras).images
    };
    let mut by_geometry = Vec::new();
    run(Driver::Lavapipe, |device| {
        assert!(device.capabilities().has(OptionalFeature::GeometryShaders));
        let images = film(device);
        by_geometry.extend(images.iter().map(|image| image.rgba8().unwrap().to_vec()));
    });
    let hides: fn(&mut vk::PhysicalDeviceFeatures) =
        |features| features.geometry_shader = vk::FALSE;
    let faults = FaultInjection { hides: Some(hides), ..FaultInjection::default() };
    let instance = instance_with(faults.entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    assert!(!device.capabilities().has(OptionalFeature::GeometryShaders));
    for (expected, found) in by_geometry.iter().zip(film(&device)) {
        assert_eq!(pixels_that_differ(expected, &found.rgba8().unwrap()), 0);
    }
    drop(device);
    assert_eq!(instance.validation_log().drain(), []);
}

#[test]
fn edges_that_are_off_leave_no_trace() {
    let (scene, cameras) = city();
    run_on_all(|device| {
        let mut renderer = renderer_of(device, &scene, SampleCount::One);
        let before = settled(&mut renderer, Strategy::ANTUMBRA, cameras[3]);
        for wrong in [0.0, -1.0, f32::NAN, 65.0] {
            let wrong = EdgeOptions { width_pixels: wrong, ..options(EdgeMode::Visible) };
            assert!(renderer.set_edges(wrong).is_err());
        }
        assert_eq!(*renderer.edges(), EdgeOptions::default());
        renderer.set_edges(options(EdgeMode::Shaded)).unwrap();
        let lines = settled(&mut renderer, Strategy::ANTUMBRA, cameras[3]);
        assert!(pixels_that_differ(&before.0, &lines.0) > 300);
        renderer.set_edges(options(EdgeMode::Off)).unwrap();
        let after = settled(&mut renderer, Strategy::ANTUMBRA, cameras[3]);
        assert_eq!(pixels_that_differ(&before.0, &after.0), 0);
        let has_edges = |renderer: &Renderer| {
            renderer.pass_times().iter().any(|pass| pass.label == "draw edges")
        };
        assert!(!has_edges(&renderer));
    });
}
