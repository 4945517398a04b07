//! An image with culling equals the image without it, at every frame, on every available device.

use cull::{Camera, Projection, Strategy};
use glam::Vec3;
use gpu::{Device, PredicationMode, Readback};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::walk::{Found, SceneKind, frame_loop, pixels_that_differ, walk, walk_cameras};
use tests::{Driver, run, run_on_all};

fn options(size: [u32; 2], frames_in_flight: usize) -> RendererOptions {
    // Measured costs differ from run to run; without costs, everything is tested.
    RendererOptions {
        methods: methods::all(),
        size,
        frames_in_flight,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

fn check(found: &Found, frames_in_flight: usize, what: &str) {
    assert_eq!(found.pixels_wrong, 0, "{what}: wrong pixels: {found:?}");
    assert_eq!(found.blocking_waits, 0, "{what}: {found:?}");
    assert!(found.oldest_answer_frames <= frames_in_flight as u64, "{what}: {found:?}");
}

/// Walks all scenes and paths with 1 to 4 frames in flight.
fn walk_everything(device: &Device, objects: u32, size: [u32; 2], frames: u32) {
    for scene_kind in SceneKind::ALL {
        let scene = scene_kind.build(objects);
        for path in PathKind::ALL {
            for in_flight in 1..=4 {
                let what =
                    format!("{scene_kind:?} {path} {objects} objects, {in_flight} in flight");
                let cost_model =
                    if in_flight % 2 == 0 { CostModel::Off } else { CostModel::Measured };
                let options = RendererOptions { cost_model, ..options(size, in_flight) };
                let found = walk(device, &scene, path, frames, &options);
                check(&found, in_flight, &what);
            }
        }
    }
}

#[test]
fn lavapipe_500_objects() {
    run(Driver::Lavapipe, |device| walk_everything(device, 500, [320, 180], 24));
}

#[test]
fn swiftshader_500_objects() {
    run(Driver::SwiftShader, |device| walk_everything(device, 500, [320, 180], 12));
}

#[test]
#[ignore = "long walk"]
fn lavapipe_10_000_objects() {
    run(Driver::Lavapipe, |device| walk_everything(device, 10_000, [256, 144], 8));
}

#[test]
fn culling_culls() {
    // To draw everything would be exact and useless.
    run_on_all(|device| {
        let scene = SceneKind::City.build(2000);
        let found = walk(device, &scene, PathKind::Street, 30, &options([320, 180], 2));
        check(&found, 2, "city");
        assert!(found.draws[1] * 4 < found.draws[0], "{found:?}");
    });
}

#[test]
fn every_way_to_skip_draws_is_exact() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::City.build(1500);
        for predication in PredicationMode::ALL {
            let options =
                RendererOptions { predication: Some(predication), ..options([320, 180], 3) };
            let found = walk(device, &scene, PathKind::Cut, 25, &options);
            check(&found, 3, predication.name());
            assert!(found.draws[1] * 2 < found.draws[0], "{}: {found:?}", predication.name());
        }
    });
}

#[test]
fn a_full_ring_costs_time_and_not_pixels() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(800);
        for query_budget in [0, 1, 7, 60] {
            let options = RendererOptions { query_budget, ..options([160, 90], 2) };
            let found = walk(device, &scene, PathKind::Cut, 22, &options);
            check(&found, 2, &format!("{query_budget} queries"));
        }
    });
}

#[test]
fn odd_sizes_are_exact() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(400);
        for size in [[1, 1], [3, 200], [333, 7], [641, 363]] {
            let found = walk(device, &scene, PathKind::Cut, 12, &options(size, 2));
            check(&found, 2, &format!("{size:?}"));
        }
    });
}

#[test]
fn eyes_in_walls_and_on_the_ground_are_exact() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(600).scene;
        let boxes = render::object_bounds(&scene).unwrap();
        let eyes = boxes.iter().step_by(23).flat_map(|b| [b.centre(), b.min, b.max]);
        let cameras: Vec<Camera> = eyes
            .enumerate()
            .map(|(number, eye)| {
                let angle = number as f32 * 2.4;
                let forward = Vec3::new(angle.cos(), (number % 5) as f32 * 0.3 - 0.6, angle.sin());
                Camera {
                    eye,
                    forward,
                    up: Vec3::Y,
                    projection: Projection::perspective(1.2),
                    near: 0.05,
                }
            })
            .collect();
        let found = walk_cameras(device, &scene, &cameras, &options([160, 90], 2));
        check(&found, 2, "eyes in boxes");
    });
}

#[test]
fn scenes_of_one_object_and_of_none_in_sight_are_exact() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(1).scene;
        let down = Vec3::new(0.1, -1.0, 0.2);
        let cameras = [Vec3::NEG_Y, Vec3::Y, down, down, Vec3::Y].map(|forward| Camera {
            eye: Vec3::new(1.0, 30.0, 2.0),
            forward,
            up: Vec3::X,
            projection: Projection::perspective(1.0),
            near: 0.1,
        });
        let found = walk_cameras(device, &scene, &cameras, &options([64, 64], 2));
        check(&found, 2, "one object");
    });
}

#[test]
fn strategies_and_views_can_change_from_frame_to_frame() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(700);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options([160, 90], 2)).unwrap();
        let mut views = [renderer.new_view().unwrap(), renderer.new_view().unwrap()];
        let mut plain = renderer.new_view().unwrap();
        // The ideal strategy needs the visible set and is tested in ideal.rs. The literature's
        // methods may be slow or inexact and are tested in strategies.rs.
        let slow = [methods::NAIVE, methods::STOP_AND_WAIT, methods::IDEAL];
        let is_fit = |strategy: &Strategy| strategy.is_exact() && !slow.contains(strategy);
        let strategies: Vec<Strategy> = methods::strategies().into_iter().filter(is_fit).collect();
        let [expected, got] = [(); 2].map(|()| Readback::new(device, [160, 90]).unwrap());
        for frame in 0..40u32 {
            let mut draw = |view, strategy, image| {
                let camera = path.camera(frame * 5);
                let request =
                    FrameRequest { image: Some(image), ..FrameRequest::new(strategy, camera) };
                renderer.render(view, request).unwrap();
            };
            draw(&mut plain, Strategy::FRUSTUM, &expected);
            let strategy = strategies[(frame / 3) as usize % strategies.len()];
            draw(&mut views[(frame / 7) as usize % 2], strategy, &got);
            device.wait_idle().unwrap();
            assert_eq!(
                pixels_that_differ(&expected.rgba8().unwrap(), &got.rgba8().unwrap()),
                0,
                "frame {frame}"
            );
        }
    });
}

#[test]
fn the_comparison_sees_a_difference() {
    run(Driver::Lavapipe, |device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(300);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options([160, 90], 2)).unwrap();
        let mut view = renderer.new_view().unwrap();
        let cameras = [path.camera(0), path.camera(1)];
        let walked = frame_loop(&mut renderer, &mut view, Strategy::FRUSTUM, &cameras);
        let [a, b] = [0, 1].map(|frame: usize| walked.images[frame].rgba8().unwrap());
        assert!(pixels_that_differ(&a, &b) > 100);
    });
}
