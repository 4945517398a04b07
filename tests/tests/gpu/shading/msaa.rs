//! Several samples per pixel: exact with any culling, smooth at edges, and unchanged inside
//! surfaces. Devices and numbers that do not allow them are refused.

mod depths;
mod finished;
mod fringes;

use cull::{Camera, Projection, Strategy};
use glam::{Affine3A, Mat3A, Quat, Vec2, Vec3, vec2, vec3};
use gpu::{Device, DeviceOptions, OptionalFeature, Readback, SampleCount};
use render::{CostModel, FlareBlock, FrameRequest, Rect, Renderer, RendererOptions};
use scene::{Alpha, MeshId, Object, Scene};
use scenes::{CameraPath, PathKind};
use shadows::{ShadowMethod, ShadowOptions};
use tests::fault_injection::FaultInjection;
use tests::shapes::{box_at, box_scene, coloured_cubes, slivers, square_camera};
use tests::single_frame::first_image;
use tests::walk::{SceneKind, frame_loop, images_that_differ};
use tests::{Driver, instance_with, run_on_all, shadow_scene};

use crate::shading::flares::{lamp, settled};

fn options(size: [u32; 2], samples: SampleCount) -> RendererOptions {
    RendererOptions {
        methods: methods::all(),
        size,
        samples,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

/// Returns the strategies that promise to be exact.
fn exact() -> impl Iterator<Item = Strategy> {
    methods::strategies()
        .into_iter()
        .filter(|strategy| strategy.is_exact() && *strategy != Strategy::FRUSTUM)
}

/// Draws with one strategy from an empty history.
fn images(renderer: &mut Renderer, strategy: Strategy, cameras: &[Camera]) -> Vec<Readback> {
    let mut view = renderer.new_view().unwrap();
    if !strategy.needs_still_scene() {
        return frame_loop(renderer, &mut view, strategy, cameras).images;
    }
    let mut finding = renderer.new_view().unwrap();
    let draw = |camera: &Camera| {
        let image = Readback::new(renderer.device(), renderer.size()).unwrap();
        let area = Rect::whole(renderer.size());
        let visible = renderer.visible_set(&mut finding, camera, area).unwrap();
        let visible = Some(&visible);
        let wanted = Some(&image);
        let request = FrameRequest::new(strategy, *camera);
        renderer.render(&mut view, FrameRequest { visible, image: wanted, ..request }).unwrap();
        renderer.wait_idle(&mut view).unwrap();
        image
    };
    cameras.iter().map(draw).collect()
}

/// Compares every frame of every exact strategy with plain frustum culling. A device that misplaces
/// depths refuses these strategies.
fn check_exact(device: &Device, scene: &Scene, cameras: &[Camera], options: &RendererOptions) {
    let mut renderer = Renderer::new(device, scene, options).unwrap();
    assert_eq!(renderer.samples(), options.samples);
    let expected = images(&mut renderer, Strategy::FRUSTUM, cameras);
    for strategy in exact() {
        if !device.capabilities().has(OptionalFeature::SampleDepths) {
            let error = renderer.supports(strategy).unwrap_err().to_string();
            assert!(error.contains(&format!("so `{strategy}` could lose some")), "{error}");
            continue;
        }
        let found = images(&mut renderer, strategy, cameras);
        for (frame, (expected, found)) in expected.iter().zip(&found).enumerate() {
            let wrong = images_that_differ(expected, found);
            assert_eq!(wrong, 0, "{strategy}, frame {frame} of {}", scene.name);
        }
    }
}

#[test]
fn every_exact_strategy_is_exact_with_four_samples() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(400);
        let path = CameraPath::new(PathKind::Cut, &scene.routes).unwrap();
        // The path jumps at every tenth frame.
        let cameras: Vec<Camera> = (5..13).map(|frame| path.camera(frame)).collect();
        check_exact(device, &scene.scene, &cameras, &options([160, 90], SampleCount::Four));
    });
}

#[test]
fn slivers_that_only_a_sample_off_the_middle_sees_are_not_lost() {
    run_on_all(|device| {
        let rolled = |number: u32| Camera {
            eye: vec3(0.001 * number as f32, 0.0007 * number as f32, 0.0),
            up: vec3(0.02 * number as f32, 1.0, 0.0),
            ..square_camera()
        };
        let cameras: Vec<Camera> = (0..5).map(rolled).collect();
        check_exact(device, &slivers(200), &cameras, &options([200, 200], SampleCount::Four));
    });
}

/// Returns walls with holes and panes, before and behind each other, and in one plane where they
/// meet.
fn masked_and_transparent() -> Scene {
    let object = |number: u32| {
        let row = (number / 9) as f32;
        let column = (number % 9) as f32;
        let low = vec3(column * 0.9 - 4.0, -1.0, -3.0 - row * 1.5);
        let turn = Quat::from_rotation_y(0.2 * (number % 3) as f32);
        let size = vec3(1.0, 1.6, 0.3);
        let transform = Affine3A::from_scale_rotation_translation(size, turn, low);
        Object { mesh: MeshId(number % 5), transform, tint: u32::MAX }
    };
    let mut scene = coloured_cubes(5, (0..54).filter(|index| index % 5 != 3).map(object).collect());
    let surfaces = scene.surfaces.as_mut().unwrap();
    surfaces.materials[1].alpha = Alpha::Mask { cutoff: 0.5 };
    surfaces.materials[3].alpha = Alpha::Blend;
    surfaces.materials[3].base_colour[3] = 0.5;
    surfaces.transparent = (0..54).filter(|index| index % 5 == 3).map(object).collect();
    scene
}

#[test]
fn surfaces_panes_and_shadows_are_exact_with_four_samples() {
    run_on_all(|device| {
        let along = |frame: u32| {
            let time = frame as f32 * 0.5;
            let forward = vec3(0.5 * time.sin(), -0.1, -1.0);
            let eye = vec3(2.0 * time.sin(), 0.2, 1.0 - 0.6 * frame as f32);
            let projection = Projection::perspective(1.0);
            Camera { eye, forward, up: Vec3::Y, projection, near: 0.05 }
        };
        let cameras: Vec<Camera> = (0..5).map(along).collect();
        let four = options([120, 90], SampleCount::Four);
        check_exact(device, &masked_and_transparent(), &cameras, &four);
        let yard_scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let moved = |frame: u32| {
            let eye = shadow_scene::camera().eye + vec3(0.4, -0.2, -0.6) * frame as f32;
            Camera { eye, ..shadow_scene::camera() }
        };
        let cameras: Vec<Camera> = (0..3).map(moved).collect();
        let shadows = ShadowOptions { method: ShadowMethod::Maps, ..ShadowOptions::default() };
        check_exact(device, &yard_scene, &cameras, &RendererOptions { shadows, ..four });
    });
}

/// The side of the image of an edge (pixels).
const SIDE: u32 = 96;

/// The direction of the edge's normal in the image, to the right and down.
const EDGE: Vec2 = Vec2::new(0.917_43, 0.397_89);

/// Returns a white square that fills half of the image, up to an edge through its middle.
fn half_plane() -> Scene {
    let mut scene = coloured_cubes(
        1,
        vec![Object { mesh: MeshId(0), transform: Affine3A::IDENTITY, tint: u32::MAX }],
    );
    let surfaces = scene.surfaces.as_mut().unwrap();
    surfaces.materials[0].base_colour = [1.0; 4];
    // Up in the world is up in the image, whose y points down.
    let out = vec3(EDGE.x, -EDGE.y, 0.0);
    let along = vec3(EDGE.y, EDGE.x, 0.0);
    let axes = Mat3A::from_cols((out * 40.0).into(), (along * 80.0).into(), Vec3::Z.into());
    let corner = out * -40.0 - along * 40.0 + Vec3::NEG_Z * 11.0;
    scene.objects[0].transform = Affine3A { matrix3: axes, translation: corner.into() };
    scene.light.sky = [0.0; 3];
    scene
}

fn drawn(device: &Device, scene: &Scene, samples: SampleCount) -> Vec<u8> {
    first_image(device, scene, &options([SIDE; 2], samples), square_camera())
}

/// Returns the part of a pixel on the inner side of the edge, estimated from 64 by 64 places.
fn coverage(x: u32, y: u32) -> f32 {
    let middle = Vec2::splat(SIDE as f32 * 0.5);
    let inside = (0..64 * 64).filter(|place| {
        let at = vec2((place % 64) as f32 + 0.5, (place / 64) as f32 + 0.5) / 64.0;
        (vec2(x as f32, y as f32) + at - middle).dot(EDGE) < 0.0
    });
    inside.count() as f32 / (64.0 * 64.0)
}

/// Returns the linear value of an sRGB-encoded channel.
fn linear(encoded: u8) -> f32 {
    let value = f32::from(encoded) / 255.0;
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// Compares an edge with its coverage. Mesa's driver averages linear light, as GPUs do. SwiftShader
/// averages encoded values.
#[test]
fn an_edge_has_the_light_of_its_coverage() {
    run_on_all(|device| {
        let scene = half_plane();
        let averages_codes = device.adapter().name.contains(Driver::SwiftShader.device_name());
        let linear = |code: u8| if averages_codes { f32::from(code) / 255.0 } else { linear(code) };
        let [plain, smooth] =
            [SampleCount::One, SampleCount::Four].map(|samples| drawn(device, &scene, samples));
        let mut levels = [0_u32; 5];
        let mut errors = [0.0_f32; 2];
        let mut edge_pixels = 0_u32;
        for pixel in 0..SIDE * SIDE {
            let covered = coverage(pixel % SIDE, pixel / SIDE);
            let at = pixel as usize * 4;
            let [one, four] = [&plain, &smooth].map(|image| &image[at..at + 4]);
            if covered == 0.0 || covered == 1.0 {
                assert_eq!(one, four, "inside of surfaces, {pixel}");
                assert_eq!(linear(one[0]), covered, "{pixel}");
                continue;
            }
            assert!(one[0] == 0 || one[0] == 255, "{one:?}");
            let light = linear(four[0]);
            let level = (light * 4.0).round();
            assert!((light * 4.0 - level).abs() < 0.02, "a quarter of the samples each: {four:?}");
            levels[level as usize] += 1;
            assert!((light - covered).abs() <= 0.3, "{pixel}: {light} for {covered}");
            for (error, light) in errors.iter_mut().zip([linear(one[0]), light]) {
                *error += (light - covered).abs();
            }
            edge_pixels += 1;
        }
        assert!(levels.iter().all(|count| *count >= 3), "{levels:?}");
        let [plain, smooth] = errors.map(|error| error / edge_pixels as f32);
        assert!(plain > 0.15 && smooth < 0.12 && plain > 1.9 * smooth, "{plain} {smooth}");
    });
}

/// Counts the samples of a block half behind a wall. The visible share equals the share of pixels.
#[test]
fn flares_count_each_sample() {
    run_on_all(|device| {
        let mut shares = Vec::new();
        for samples in [SampleCount::One, SampleCount::Four] {
            let wall = box_at(vec3(-3.0, 0.0, -5.0), vec3(3.0, 4.0, 0.1));
            let sampled = options([SIDE; 2], samples);
            let mut renderer = Renderer::new(device, &box_scene(&[wall]), &sampled).unwrap();
            renderer.set_flares(&[lamp(vec3(0.0, 0.0, -20.0), 2.0)]).unwrap();
            let mut view = renderer.new_view().unwrap();
            let counted = settled(&mut renderer, &mut view, Strategy::FRUSTUM);
            let block = FlareBlock::of(&renderer.flares()[0], &renderer.view_of(&square_camera()));
            assert_eq!(counted.block, block.unwrap().pixels() * samples.count());
            assert_eq!(counted.total, counted.block, "all of it is in the image");
            shares.push(counted.fraction());
        }
        assert!(
            shares[0] > 0.3 && shares[0] < 0.7 && (shares[0] - shares[1]).abs() < 0.1,
            "{shares:?}"
        );
    });
}

#[test]
fn depths_of_samples_are_at_their_places_where_a_device_says_so() {
    for (driver, expected) in [(Driver::Lavapipe, true), (Driver::SwiftShader, false)] {
        tests::run(driver, |device| {
            assert_eq!(device.capabilities().has(OptionalFeature::SampleDepths), expected);
        });
    }
}

#[test]
fn a_device_without_four_samples_says_so() {
    let faults = FaultInjection { has_one_sample: true, ..FaultInjection::default() };
    let instance = instance_with(faults.entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let scene = box_scene(&[box_at(vec3(0.0, 0.0, -5.0), Vec3::ONE)]);
    let of = |samples| Renderer::new(&device, &scene, &options([32, 32], samples));
    let error = of(SampleCount::Four).err().unwrap().to_string();
    assert!(error.contains("TYPE_4 samples per pixel"), "{error}");
    assert!(error.contains("this device draws to TYPE_1"), "{error}");
    assert!(of(SampleCount::One).is_ok());
    assert_eq!(instance.validation_log().drain(), []);
}
