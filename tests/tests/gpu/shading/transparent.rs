//! Transparent objects: back to front over the finished image, the same with any culling.

use cull::{Camera, Projection, Strategy};
use glam::{Affine3A, Quat, Vec3, vec3};
use gpu::{Device, PredicationMode, Readback};
use render::{
    CostModel, Error, FrameReport, FrameRequest, Renderer, RendererOptions, TransparentError,
};
use scene::{Alpha, Material, MaterialId, MeshId, Object, ObjectChange, Scene, TransparentId};
use tests::shapes::coloured_cubes;
use tests::walk::images_that_differ;
use tests::{Driver, run, run_on_all};

const SIZE: [u32; 2] = [160, 90];
const COLOURS: u32 = 5;
const PANES: u32 = 24;

fn object(mesh: u32, low: Vec3, size: Vec3) -> Object {
    let transform = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, low);
    Object { mesh: MeshId(mesh), transform, tint: u32::MAX }
}

fn pane(number: u32) -> Object {
    let row = number / 6;
    let column = number % 6;
    let low = vec3(column as f32 * 1.6 - 5.0, -1.0, -4.0 - 3.0 * row as f32);
    // Some panes cross walls or each other, and some are in the same place.
    let size = match number % 3 {
        0 => vec3(2.0, 2.0, 0.1),
        1 => vec3(0.2, 2.5, 3.5),
        _ => vec3(2.0, 2.0, 0.1),
    };
    object(COLOURS + number % 3, low, size)
}

/// Returns walls with doors, one behind the other, and panes in front of, between and behind them.
pub(crate) fn scene() -> Scene {
    let mut objects = Vec::new();
    for wall in 0..4 {
        let z = -5.5 - 3.0 * wall as f32;
        let door = wall as f32 * 1.5 - 3.0;
        let low = vec3(-8.0, -2.0, z);
        objects.push(object(wall % COLOURS, low, vec3(8.0 + door, 5.0, 0.4)));
        let low = vec3(door + 1.5, -2.0, z);
        objects.push(object((wall + 1) % COLOURS, low, vec3(8.0 - door, 5.0, 0.4)));
        for thing in 0..8 {
            let low = vec3(thing as f32 * 1.9 - 7.0, -2.0, z - 2.0);
            objects.push(object((thing + wall) % COLOURS, low, Vec3::splat(0.7)));
        }
    }
    let mut scene = coloured_cubes(COLOURS, objects);
    let surfaces = scene.surfaces.as_mut().unwrap();
    for glass in 0..3 {
        scene.meshes.push(scene.meshes[glass].clone());
        let mut surface = surfaces.meshes[glass].clone();
        surface.material = MaterialId(surfaces.materials.len() as u32);
        surfaces.meshes.push(surface);
        let base_colour = [0.9 - 0.3 * glass as f32, 0.4, 0.3 * glass as f32, 0.45];
        let alpha = Alpha::Blend;
        let pane = Material { base_colour, alpha, is_unlit: true, ..Material::default() };
        surfaces.materials.push(pane);
    }
    surfaces.transparent = (0..PANES).map(pane).collect();
    scene
}

pub(crate) fn camera(frame: u32) -> Camera {
    let time = frame as f32 * 0.4;
    Camera {
        eye: vec3(3.0 * time.sin(), 0.3, 0.0 - 0.4 * frame as f32),
        forward: vec3(0.4 * (time * 1.3).sin(), -0.05, -1.0),
        up: Vec3::Y,
        projection: Projection::perspective(1.0),
        near: 0.05,
    }
}

pub(crate) fn options(frames_in_flight: usize) -> RendererOptions {
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        frames_in_flight,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

fn draw_into(
    renderer: &mut Renderer,
    view: &mut render::RenderView,
    strategy: Strategy,
    camera: Camera,
) -> (Readback, FrameReport) {
    let image = Readback::new(renderer.device(), SIZE).unwrap();
    let request = FrameRequest { image: Some(&image), ..FrameRequest::new(strategy, camera) };
    let report = renderer.render(view, request).unwrap();
    (image, report)
}

/// Returns all frames, drawn without a wait in between, while a door opens and panes move.
fn film(renderer: &mut Renderer, strategy: Strategy) -> Vec<Readback> {
    let closed = scene().objects[0].transform;
    // Where they were before the film before.
    for number in 0..PANES {
        renderer.move_transparent(TransparentId(number), pane(number).transform).unwrap();
    }
    let mut view = renderer.new_view().unwrap();
    let frame = |frame: u32| {
        let slide = Affine3A::from_translation(vec3(0.0, (frame % 4) as f32 * 1.5, 0.0));
        let door = cull::ObjectId(0);
        let change = ObjectChange::Move { object: door, transform: slide * closed };
        renderer.update(&[change]).unwrap();
        for number in (frame % 3..PANES).step_by(5) {
            let fly = Affine3A::from_translation(vec3(0.3 * frame as f32, 0.0, 0.5));
            let transform = fly * pane(number).transform;
            renderer.move_transparent(TransparentId(number), transform).unwrap();
        }
        draw_into(renderer, &mut view, strategy, camera(frame)).0
    };
    let images = (0..8).map(frame).collect();
    renderer.wait_idle(&mut view).unwrap();
    images
}

/// Returns the frames of plain frustum culling.
pub(crate) fn unculled(device: &Device, options: &RendererOptions) -> Vec<Readback> {
    film(&mut Renderer::new(device, &scene(), options).unwrap(), Strategy::FRUSTUM)
}

/// Compares each frame of each strategy.
pub(crate) fn compare(
    device: &Device,
    expected: &[Readback],
    strategies: &[Strategy],
    options: &RendererOptions,
) {
    let mut renderer = Renderer::new(device, &scene(), options).unwrap();
    for strategy in strategies {
        let found = film(&mut renderer, *strategy);
        for (frame, (expected, found)) in expected.iter().zip(&found).enumerate() {
            let wrong = images_that_differ(expected, found);
            let in_flight = options.frames_in_flight;
            assert_eq!(wrong, 0, "{strategy}, {in_flight} in flight, frame {frame}");
        }
    }
}

/// Returns the exact strategies that need no set of visible objects.
pub(crate) fn exact() -> Vec<Strategy> {
    let mut strategies = methods::strategies();
    strategies.retain(|strategy| strategy.is_exact() && !strategy.needs_still_scene());
    strategies
}

#[test]
fn every_strategy_shows_the_same_panes() {
    run_on_all(|device| {
        let expected = unculled(device, &options(1));
        compare(device, &expected, &exact(), &options(2));
        compare(device, &expected, &[Strategy::ANTUMBRA], &options(1));
        compare(device, &expected, &[Strategy::ANTUMBRA], &options(3));
        for predication in
            [PredicationMode::Counts, PredicationMode::Instances, PredicationMode::Compacted]
        {
            let options = RendererOptions { predication: Some(predication), ..options(2) };
            if Renderer::new(device, &scene(), &options).is_ok() {
                compare(device, &expected, &[Strategy::ANTUMBRA_QUERIES], &options);
            }
        }
    });
}

#[test]
fn what_was_hidden_shows_in_the_frame_in_which_it_shows() {
    run_on_all(|device| {
        let wall = object(0, vec3(-9.0, -9.0, -6.0), vec3(18.0, 18.0, 0.5));
        let mut scene = scene();
        scene.objects = vec![wall, object(1, vec3(-9.0, -9.0, -20.0), vec3(18.0, 18.0, 0.5))];
        let behind = object(COLOURS, vec3(-1.0, -1.0, -10.0), Vec3::splat(2.0));
        scene.surfaces.as_mut().unwrap().transparent = vec![behind];
        let mut renderer = Renderer::new(device, &scene, &options(2)).unwrap();
        let mut view = renderer.new_view().unwrap();
        let camera = camera(0);
        let mut draw =
            |renderer: &mut Renderer| draw_into(renderer, &mut view, Strategy::ANTUMBRA, camera).0;
        for _ in 0..5 {
            draw(&mut renderer);
        }
        let hidden = draw(&mut renderer);
        let gone = Affine3A::from_translation(Vec3::X * 50.0) * wall.transform;
        let change = ObjectChange::Move { object: cull::ObjectId(0), transform: gone };
        renderer.update(&[change]).unwrap();
        let open = draw(&mut renderer);
        let away = Affine3A::from_translation(Vec3::Y * 90.0);
        renderer.move_transparent(TransparentId(0), away).unwrap();
        let without = draw(&mut renderer);
        device.wait_idle().unwrap();
        let differ = |a: &Readback, b: &Readback| images_that_differ(a, b);
        assert!(differ(&hidden, &open) > 1000);
        assert!(differ(&open, &without) > 100, "the pane shows at once");
    });
}

#[test]
fn the_farther_pane_is_drawn_first() {
    run_on_all(|device| {
        let mut scene = scene();
        scene.objects.truncate(1);
        scene.objects[0] = object(0, vec3(-9.0, -9.0, -9.0), vec3(18.0, 18.0, 0.5));
        let at = |mesh, z| object(COLOURS + mesh, vec3(-9.0, -9.0, z), vec3(18.0, 18.0, 0.1));
        let colour = |scene: &Scene| {
            let mut renderer = Renderer::new(device, scene, &options(2)).unwrap();
            let mut view = renderer.new_view().unwrap();
            let camera = Camera { eye: Vec3::ZERO, forward: Vec3::NEG_Z, ..camera(0) };
            let (image, report) = draw_into(&mut renderer, &mut view, Strategy::ANTUMBRA, camera);
            renderer.wait_idle(&mut view).unwrap();
            assert_eq!(report.transparent, 2);
            let middle = (SIZE[1] / 2 * SIZE[0] + SIZE[0] / 2) as usize * 4;
            let linear = |byte: u8| (f32::from(byte) / 255.0).powf(2.2);
            [0, 1, 2].map(|channel| linear(image.rgba8().unwrap()[middle + channel]))
        };
        let materials = scene.surfaces.as_ref().unwrap().materials.clone();
        let mixed = |behind: [f32; 3], pane: &Material| {
            let alpha = pane.base_colour[3];
            [0, 1, 2]
                .map(|channel| behind[channel] * (1.0 - alpha) + pane.base_colour[channel] * alpha)
        };
        let [red, green, blue, _] = materials[0].base_colour;
        let [first, third] = [0, 2].map(|offset| &materials[COLOURS as usize + offset]);
        for (order, expected) in [
            ([at(0, -4.0), at(2, -6.0)], mixed(mixed([red, green, blue], third), first)),
            ([at(0, -6.0), at(2, -4.0)], mixed(mixed([red, green, blue], first), third)),
        ] {
            scene.surfaces.as_mut().unwrap().transparent = order.to_vec();
            let found = colour(&scene);
            let near = |(a, b): (f32, f32)| (a - b).abs() < 0.03;
            assert!(found.into_iter().zip(expected).all(near), "{found:?} for {expected:?}");
        }
    });
}

#[test]
fn bad_moves_are_refused_and_change_nothing() {
    run(Driver::Lavapipe, |device| {
        let scene = scene();
        let mut renderer = Renderer::new(device, &scene, &options(2)).unwrap();
        let nowhere = Affine3A::from_translation(Vec3::splat(f32::NAN));
        for (number, transform, expected) in [
            (PANES, Affine3A::IDENTITY, TransparentError::UnknownObject),
            (0, nowhere, TransparentError::BadTransform),
        ] {
            let error = renderer.move_transparent(TransparentId(number), transform).unwrap_err();
            assert!(
                matches!(error, Error::Transparent { reason, .. } if reason == expected),
                "{error}"
            );
        }
    });
}
