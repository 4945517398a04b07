//! Scenes that change between frames: exact at every frame, on both drivers, at a cost proportional
//! to the changes.

mod costs;
mod updates;

use cull::{Aabb, Camera, ObjectId, Strategy};
use glam::{Affine3A, Vec3};
use gpu::{Device, PredicationMode, Readback};
use render::{CostModel, FrameRequest, RenderView, Renderer, RendererOptions};
use scene::{ObjectChange, Scene};
use scenes::{CameraPath, Cast, GeneratedScene, Motion, PathKind};
use tests::shapes::{box_at, box_scene, square_camera};
use tests::walk::{SceneKind, images_that_differ, show_motion};
use tests::{Driver, run, run_on_all};

const SIZE: [u32; 2] = [160, 90];

/// The exact strategies that do not use the device's best mechanism of tests or decisions.
const TESTERS: [Strategy; 7] = [
    methods::BATCHED,
    methods::STOP_AND_WAIT,
    methods::CHC,
    methods::HZB,
    Strategy::ANTUMBRA_QUERIES,
    Strategy::ANTUMBRA_FLAGS,
    Strategy::ANTUMBRA_COMPUTE,
];

fn options(frames_in_flight: usize) -> RendererOptions {
    // Measured costs differ from run to run; without costs, everything is tested.
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        frames_in_flight,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

/// A scene during a motion.
struct Moving {
    scene: Scene,
    path: CameraPath,
    motion: Motion,
}

impl Moving {
    fn new(generated: GeneratedScene, path: PathKind, percent: u32) -> Self {
        let GeneratedScene { scene, routes } = generated;
        let path = CameraPath::new(path, &routes).unwrap();
        let motion = Motion::new(&scene, percent, 11).unwrap();
        Self { scene, path, motion }
    }

    /// Draws `frames` one after the other without reading results. Returns their images and the
    /// number of drawn objects.
    fn walk(
        &self,
        renderer: &mut Renderer,
        cast: &mut Cast,
        strategy: Strategy,
        frames: &[u32],
    ) -> (Vec<Readback>, u64) {
        let mut view = renderer.new_view().unwrap();
        let mut images = Vec::new();
        let waits = renderer.device().wait_counts().other;
        for frame in frames {
            show_motion(renderer, &self.motion, cast, *frame).unwrap();
            let image = Readback::new(renderer.device(), SIZE).unwrap();
            let camera = self.path.camera(*frame);
            render(renderer, &mut view, strategy, camera, &image);
            images.push(image);
        }
        let waited = renderer.device().wait_counts().other - waits;
        assert_eq!(waited > 0, strategy.is_blocking(), "{strategy} waited for {waited} answers");
        renderer.wait_idle(&mut view).unwrap();
        let draws = view.drain_stats().map(|outcome| outcome.draws).sum();
        (images, draws)
    }

    /// Walks with our strategy and compares images with frustum culling. Returns the number of
    /// objects that frustum culling and our strategy drew.
    fn check(&self, device: &Device, options: &RendererOptions, frames: u32) -> [u64; 2] {
        self.check_with(device, Strategy::ANTUMBRA, options, frames)
    }

    fn check_with(
        &self,
        device: &Device,
        strategy: Strategy,
        options: &RendererOptions,
        frames: u32,
    ) -> [u64; 2] {
        let mut renderer = Renderer::new(device, &self.scene, options).unwrap();
        let mut cast = Cast::new(&self.motion);
        let frames: Vec<u32> = (0..frames).collect();
        let [(expected, all), (got, ours)] = [Strategy::FRUSTUM, strategy]
            .map(|strategy| self.walk(&mut renderer, &mut cast, strategy, &frames));
        for (frame, (expected, got)) in expected.iter().zip(&got).enumerate() {
            let wrong = images_that_differ(expected, got);
            let in_flight = options.frames_in_flight;
            assert_eq!(wrong, 0, "{strategy}, frame {frame}, {in_flight} in flight");
        }
        let changed = images_that_differ(&expected[0], &expected[1]);
        assert!(changed > 0, "something moves");
        [all, ours]
    }
}

fn render(
    renderer: &mut Renderer,
    view: &mut RenderView,
    strategy: Strategy,
    camera: Camera,
    image: &Readback,
) {
    let request = FrameRequest { image: Some(image), ..FrameRequest::new(strategy, camera) };
    renderer.render(view, request).unwrap();
}

fn exact_while_moving(device: &Device, objects: u32, frames: u32) {
    for (path, percent, in_flight) in [
        (PathKind::Street, 10, 1),
        (PathKind::Street, 100, 2),
        (PathKind::Cut, 10, 3),
        (PathKind::Cut, 100, 2),
    ] {
        let moving = Moving::new(SceneKind::City.build(objects), path, percent);
        let [all, ours] = moving.check(device, &options(in_flight), frames);
        assert!(ours * 4 < all * 3, "{path}, {percent} %: {ours} of {all} drawn");
    }
}

#[test]
fn lavapipe_is_exact_while_objects_move() {
    run(Driver::Lavapipe, |device| exact_while_moving(device, 1_200, 14));
}

#[test]
fn swiftshader_is_exact_while_objects_move() {
    run(Driver::SwiftShader, |device| exact_while_moving(device, 1_200, 8));
}

#[test]
#[ignore = "long walk"]
fn every_way_to_skip_draws_is_exact_while_objects_move() {
    run(Driver::Lavapipe, |device| {
        let moving = Moving::new(SceneKind::City.build(1_000), PathKind::Cut, 60);
        for predication in PredicationMode::ALL {
            let options = RendererOptions { predication: Some(predication), ..options(2) };
            moving.check(device, &options, 24);
        }
    });
}

/// Checks that every tester is exact while objects move: with boxes that move on the GPU, draws of
/// leaves that other objects took over, and free leaves.
#[test]
#[ignore = "long walk"]
fn every_tester_is_exact_while_objects_move() {
    run_on_all(|device| {
        for (path, percent) in [(PathKind::Street, 10), (PathKind::Cut, 100)] {
            let moving = Moving::new(SceneKind::City.build(1_000), path, percent);
            for strategy in TESTERS {
                let [all, ours] = moving.check_with(device, strategy, &options(2), 24);
                assert!(ours < all, "{strategy}: {ours} of {all} drawn");
            }
        }
    });
}

/// The ways to skip draws that are not the best one of a device with conditional rendering.
const OTHER_WAYS: [PredicationMode; 3] =
    [PredicationMode::Counts, PredicationMode::Instances, PredicationMode::Compacted];

#[test]
fn every_tester_is_exact_with_some_way_to_skip_draws_while_objects_move() {
    run(Driver::Lavapipe, |device| {
        let moving = Moving::new(SceneKind::City.build(500), PathKind::Cut, 60);
        for (strategy, predication) in TESTERS.into_iter().zip(OTHER_WAYS.into_iter().cycle()) {
            let options = RendererOptions { predication: Some(predication), ..options(2) };
            moving.check_with(device, strategy, &options, 14);
        }
    });
}

#[test]
#[ignore = "long walk"]
fn every_tester_and_way_to_skip_draws_is_exact_while_objects_move() {
    run(Driver::Lavapipe, |device| {
        let moving = Moving::new(SceneKind::City.build(800), PathKind::Cut, 60);
        for predication in OTHER_WAYS {
            let options = RendererOptions { predication: Some(predication), ..options(2) };
            for strategy in TESTERS {
                moving.check_with(device, strategy, &options, 22);
            }
        }
    });
}

#[test]
fn a_field_that_moves_is_exact_from_above() {
    run_on_all(|device| {
        let moving = Moving::new(SceneKind::Field.build(300), PathKind::Fly, 100);
        moving.check(device, &options(2), 12);
    });
}

/// Checks that updates leave the same state on the GPU as a renderer of the moved scene.
#[test]
fn an_updated_scene_is_the_scene_built_anew() {
    run_on_all(|device| {
        let moving = Moving::new(SceneKind::City.build(900), PathKind::Fly, 100);
        let mut renderer = Renderer::new(device, &moving.scene, &options(2)).unwrap();
        let mut cast = Cast::new(&moving.motion);
        let frames = [0, 1, 2, 90, 91, 30, 400];
        let (images, _) = moving.walk(&mut renderer, &mut cast, Strategy::FRUSTUM, &frames);
        for (frame, image) in frames.iter().zip(&images) {
            let scene = moving.motion.scene_at(&moving.scene, *frame);
            let mut fresh = Renderer::new(device, &scene, &options(1)).unwrap();
            let mut view = fresh.new_view().unwrap();
            let expected = Readback::new(device, SIZE).unwrap();
            let camera = moving.path.camera(*frame);
            render(&mut fresh, &mut view, Strategy::FRUSTUM, camera, &expected);
            device.wait_idle().unwrap();
            let wrong = images_that_differ(&expected, image);
            assert_eq!(wrong, 0, "frame {frame}");
        }
    });
}

/// Checks views of one moving scene that alternate, pause and look elsewhere.
#[test]
fn views_that_pause_stay_exact() {
    run(Driver::Lavapipe, |device| {
        let moving = Moving::new(SceneKind::City.build(500), PathKind::Street, 80);
        let mut renderer = Renderer::new(device, &moving.scene, &options(3)).unwrap();
        let mut cast = Cast::new(&moving.motion);
        let mut views = [(); 3].map(|()| renderer.new_view().unwrap());
        let mut plain = renderer.new_view().unwrap();
        let [expected, got] = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        for frame in 0..42_u32 {
            show_motion(&mut renderer, &moving.motion, &mut cast, frame * 3).unwrap();
            let eye = (frame / 7) as usize % 3;
            let camera = moving.path.camera(frame + 300 * eye as u32);
            render(&mut renderer, &mut plain, Strategy::FRUSTUM, camera, &expected);
            render(&mut renderer, &mut views[eye], Strategy::ANTUMBRA, camera, &got);
            device.wait_idle().unwrap();
            assert_eq!(images_that_differ(&expected, &got), 0, "frame {frame}");
        }
    });
}

/// Returns a wall in front of a crowd, and a camera that sees both.
fn wall_and_crowd(count: usize) -> Vec<Aabb> {
    let wall = box_at(Vec3::new(0.0, 0.0, -5.0), Vec3::new(20.0, 20.0, 0.1));
    let crowd = (0..count).map(|number| {
        let column = (number % 12) as f32 - 6.0;
        let row = (number / 12 % 12) as f32 - 6.0;
        let centre = Vec3::new(column * 1.3, row * 1.3, -14.0 - (number / 144) as f32 * 1.7);
        box_at(centre, Vec3::new(0.31, 0.27, 0.23))
    });
    std::iter::once(wall).chain(crowd).collect()
}

#[test]
fn what_a_wall_hid_shows_in_the_frame_in_which_it_goes() {
    run_on_all(|device| {
        let scene = box_scene(&wall_and_crowd(300));
        // On some devices, such small objects are cheaper to draw than to test.
        let options = options(2);
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        let mut plain = renderer.new_view().unwrap();
        let [expected, got] = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        let mut wall = ObjectId(0);
        for frame in 0..60 {
            // After it was hidden for long, the crowd is uncovered, covered, and uncovered again.
            let change = match frame {
                25 => Some(ObjectChange::Remove { object: wall }),
                35 => Some(ObjectChange::Add { object: scene.objects[0] }),
                50 => Some(ObjectChange::Move {
                    object: wall,
                    transform: Affine3A::from_translation(Vec3::X * 60.0),
                }),
                _ => None,
            };
            let report = renderer.update(change.as_slice()).unwrap();
            wall = report.added.first().copied().unwrap_or(wall);
            render(&mut renderer, &mut view, Strategy::ANTUMBRA, square_camera(), &got);
            render(&mut renderer, &mut plain, Strategy::FRUSTUM, square_camera(), &expected);
            device.wait_idle().unwrap();
            assert_eq!(images_that_differ(&expected, &got), 0, "frame {frame}");
            if frame == 24 || frame == 49 {
                let plan = view.plan();
                assert_eq!(plan.draws.len() + plan.queried_draws.len(), 1, "all but the wall hide");
            }
        }
    });
}

/// Checks that all objects can change places with distant ones, so that parts of the hierarchy or
/// the whole hierarchy are rebuilt.
#[test]
fn objects_that_jump_far_stay_exact() {
    run_on_all(|device| {
        let boxes = wall_and_crowd(700);
        let scene = box_scene(&boxes);
        let mut renderer = Renderer::new(device, &scene, &options(2)).unwrap();
        let mut view = renderer.new_view().unwrap();
        let mut plain = renderer.new_view().unwrap();
        let [expected, got] = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        let mut moved = scene.clone();
        let mut drawn = 0;
        let mut rebuilt = 0;
        for frame in 0..22_usize {
            // Every third object changes places; the others still move in the hierarchy. The number
            // of seats is a prime, so that no two objects get the same seat.
            let seat =
                |n: usize| scene.objects[1 + 3 * ((n * (frame + 1) + frame) % 233)].transform;
            let move_to = |n: usize| ObjectChange::Move {
                object: ObjectId(1 + 3 * n as u32),
                transform: seat(n),
            };
            let changes: Vec<ObjectChange> =
                (0..233).filter(|_| frame.is_multiple_of(2)).map(move_to).collect();
            for change in &changes {
                if let ObjectChange::Move { object, transform } = change {
                    moved.objects[object.0 as usize].transform = *transform;
                }
            }
            rebuilt += renderer.update(&changes).unwrap().rebuilt_leaves;
            if frame == 16 {
                renderer.rebuild_hierarchy().unwrap();
            }
            // A part of the crowd is visible over the wall.
            let camera = Camera { eye: Vec3::new(0.0, 24.0, -1.0), ..square_camera() };
            let camera = Camera { forward: Vec3::new(0.0, -1.0, -1.0), ..camera };
            render(&mut renderer, &mut view, Strategy::ANTUMBRA, camera, &got);
            render(&mut renderer, &mut plain, Strategy::FRUSTUM, camera, &expected);
            device.wait_idle().unwrap();
            assert_eq!(images_that_differ(&expected, &got), 0, "frame {frame}");
            renderer.wait_idle(&mut view).unwrap();
            drawn += view.drain_stats().map(|outcome| outcome.draws).sum::<u64>();
            // Both images show the state on the GPU. A new renderer shows the expected state.
            if frame % 7 == 6 {
                let mut fresh = Renderer::new(device, &moved, &options(1)).unwrap();
                let mut view = fresh.new_view().unwrap();
                render(&mut fresh, &mut view, Strategy::FRUSTUM, camera, &expected);
                device.wait_idle().unwrap();
                let wrong = images_that_differ(&expected, &got);
                assert_eq!(wrong, 0, "frame {frame}, built again");
            }
        }
        assert!(rebuilt > 0, "nothing was worn");
        assert!((22 * 20..22 * 500).contains(&drawn), "{drawn}: some show, some do not");
    });
}
