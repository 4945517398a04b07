//! An image with culling equals the image without it, at every frame, on every available device.

use cull::{Camera, Strategy};
use gpu::{Device, PredicationMode, Readback};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::walk::{
    ComparedWalk, Found, SceneKind, cameras_along, eyes_in_boxes, frame_loop, images_that_differ,
    pixels_that_differ, up_and_down,
};
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

/// The numbers of frames in flight of a walk.
#[derive(Clone, Copy, PartialEq, Eq)]
enum InFlight {
    /// One number for each path, in turns.
    InTurns,
    /// Every number on every path.
    All,
}

/// Walks with strategies, and checks that images are exact, that nothing waits that need not, and
/// that answers are not too old.
fn check(
    walk: &mut ComparedWalk<'_, Camera>,
    strategies: &[Strategy],
    frames_in_flight: usize,
    what: &str,
) -> Vec<Found> {
    let check = |strategy: &Strategy| {
        let found = walk.with(*strategy);
        let what = format!("{what}, {strategy}: {found:?}");
        assert_eq!(found.pixels_wrong, 0, "{what}");
        if !strategy.is_blocking() {
            assert_eq!(found.blocking_waits, 0, "{what}");
            assert!(found.oldest_answer_frames <= frames_in_flight as u64, "{what}");
        }
        found
    };
    strategies.iter().map(check).collect()
}

/// Strategies of different origin that never wait.
const BOTH: [Strategy; 2] = [Strategy::ANTUMBRA, methods::HZB];

/// Walks all scenes and paths with `every` of 1 to 4 frames in flight, and each number of frames at
/// least once.
fn walk_everything(device: &Device, objects: u32, size: [u32; 2], frames: u32, every: InFlight) {
    let mut walks = 0;
    for scene_kind in SceneKind::ALL {
        let scene = scene_kind.build(objects);
        for path in PathKind::ALL {
            let cameras = cameras_along(&scene, path, frames);
            let next = walks % 4 + 1;
            walks += 1;
            let numbers = if every == InFlight::InTurns { next..=next } else { 1..=4 };
            for in_flight in numbers {
                let what =
                    format!("{scene_kind:?} {path} {objects} objects, {in_flight} in flight");
                let cost_model =
                    if in_flight % 2 == 0 { CostModel::Off } else { CostModel::Measured };
                let options = RendererOptions { cost_model, ..options(size, in_flight) };
                let mut walk = ComparedWalk::new(device, &scene.scene, &cameras, &options);
                check(&mut walk, &BOTH, in_flight, &what);
            }
        }
    }
}

#[test]
fn lavapipe_500_objects() {
    run(Driver::Lavapipe, |device| {
        walk_everything(device, 500, [160, 90], 10, InFlight::InTurns);
    });
}

#[test]
fn swiftshader_500_objects() {
    run(Driver::SwiftShader, |device| {
        walk_everything(device, 500, [160, 90], 5, InFlight::InTurns);
    });
}

#[test]
#[ignore = "long walk"]
fn any_number_of_frames_in_flight_is_exact() {
    run_on_all(|device| walk_everything(device, 500, [320, 180], 24, InFlight::All));
}

#[test]
#[ignore = "long walk"]
fn lavapipe_10_000_objects() {
    run(Driver::Lavapipe, |device| {
        walk_everything(device, 10_000, [256, 144], 8, InFlight::All);
    });
}

#[test]
fn culling_culls() {
    // To draw everything would be exact and useless.
    run_on_all(|device| {
        let scene = SceneKind::City.build(1200);
        let cameras = cameras_along(&scene, PathKind::Street, 12);
        let mut walk = ComparedWalk::new(device, &scene.scene, &cameras, &options([160, 90], 2));
        let found = check(&mut walk, &BOTH, 2, "city");
        for (found, share) in found.iter().zip([3, 2]) {
            assert!(found.draws[1] * share < found.draws[0], "{found:?}");
        }
    });
}

#[test]
fn every_way_to_skip_draws_is_exact() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::City.build(700);
        let cameras = cameras_along(&scene, PathKind::Cut, 16);
        for predication in PredicationMode::ALL {
            let options =
                RendererOptions { predication: Some(predication), ..options([160, 90], 3) };
            let mut walk = ComparedWalk::new(device, &scene.scene, &cameras, &options);
            let found = &check(&mut walk, &BOTH[..1], 3, predication.name())[0];
            assert!(found.draws[1] * 2 < found.draws[0], "{}: {found:?}", predication.name());
        }
    });
}

#[test]
fn a_full_ring_costs_time_and_not_pixels() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(500);
        let cameras = cameras_along(&scene, PathKind::Cut, 11);
        for query_budget in [0, 1, 7, 60] {
            let options = RendererOptions { query_budget, ..options([160, 90], 2) };
            let mut walk = ComparedWalk::new(device, &scene.scene, &cameras, &options);
            check(&mut walk, &BOTH[..1], 2, &format!("{query_budget} queries"));
        }
    });
}

#[test]
fn odd_sizes_are_exact() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(400);
        let cameras = cameras_along(&scene, PathKind::Cut, 12);
        for size in [[1, 1], [3, 200], [333, 7], [641, 363]] {
            let mut walk = ComparedWalk::new(device, &scene.scene, &cameras, &options(size, 2));
            check(&mut walk, &BOTH, 2, &format!("{size:?}"));
        }
    });
}

#[test]
fn eyes_in_walls_and_on_the_ground_are_exact() {
    look_around(47);
}

#[test]
#[ignore = "long walk"]
fn eyes_in_many_walls_and_on_the_ground_are_exact() {
    look_around(11);
}

/// Looks out of every `step`th object.
fn look_around(step: usize) {
    run_on_all(|device| {
        let scene = SceneKind::City.build(600).scene;
        let cameras = eyes_in_boxes(&scene, step);
        let mut walk = ComparedWalk::new(device, &scene, &cameras, &options([160, 90], 2));
        let strategies = [Strategy::ANTUMBRA, methods::HZB, methods::BATCHED, methods::CHC];
        check(&mut walk, &strategies, 2, "eyes in boxes");
    });
}

#[test]
fn scenes_of_one_object_and_of_none_in_sight_are_exact() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(1).scene;
        let cameras = up_and_down();
        let mut walk = ComparedWalk::new(device, &scene, &cameras, &options([64, 64], 2));
        let mut strategies = methods::strategies();
        strategies.retain(|strategy| !strategy.needs_still_scene());
        check(&mut walk, &strategies, 2, "one object");
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
        for frame in 0..30u32 {
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
            assert_eq!(images_that_differ(&expected, &got), 0, "frame {frame}");
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
