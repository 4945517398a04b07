//! The literature's methods on real drivers: exact if they promise exactness, otherwise with
//! counted errors, and each with its known waits.

use cull::{Camera, ChcOptions, FirstPass, LeafTest, Strategy};
use gpu::{Device, FrameRing, Readback, Tick, Timeline};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::walk::{Found, SceneKind, frame_loop, images_that_differ, walk_with};
use tests::{Driver, run, run_on_all};

const DIALOGUES: [Strategy; 4] =
    [methods::NAIVE, methods::BATCHED, methods::STOP_AND_WAIT, methods::CHC];

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

fn coherent(coherent: ChcOptions) -> RendererOptions {
    RendererOptions { methods: vec![methods::chc(coherent)], ..options([160, 90], 2) }
}

fn check(found: &Found, what: &str) {
    assert_eq!(found.pixels_wrong, 0, "{what}: wrong pixels: {found:?}");
    assert!(found.draws[1] <= found.draws[0], "{what}: {found:?}");
}

fn walk_everything(device: &Device, strategy: Strategy, objects: u32, frames: u32) {
    for scene_kind in SceneKind::ALL {
        let scene = scene_kind.build(objects);
        for path in PathKind::ALL {
            let what = format!("{strategy} {scene_kind:?} {path}, {objects} objects");
            let options = options([160, 90], 2);
            check(&walk_with(device, &scene, path, frames, &options, strategy), &what);
        }
    }
}

#[test]
fn lavapipe_every_blocking_method_is_exact() {
    run(Driver::Lavapipe, |device| {
        for (strategy, objects, frames) in [
            (methods::NAIVE, 200, 2),
            (methods::BATCHED, 400, 5),
            (methods::STOP_AND_WAIT, 300, 3),
            (methods::CHC, 400, 7),
        ] {
            walk_everything(device, strategy, objects, frames);
        }
    });
}

#[test]
fn swiftshader_every_blocking_method_is_exact() {
    run(Driver::SwiftShader, |device| {
        for (strategy, objects, frames) in [
            (methods::NAIVE, 150, 1),
            (methods::BATCHED, 250, 3),
            (methods::STOP_AND_WAIT, 200, 2),
            (methods::CHC, 250, 4),
        ] {
            walk_everything(device, strategy, objects, frames);
        }
    });
}

#[test]
#[ignore = "long walk"]
fn coherent_is_exact_with_ten_thousand_objects() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::City.build(10_000);
        for path in [PathKind::Street, PathKind::Cut] {
            let options = options([256, 144], 3);
            let found = walk_with(device, &scene, path, 12, &options, methods::CHC);
            check(&found, &format!("10,000 objects, {path}"));
            assert!(found.draws[1] * 4 < found.draws[0], "{found:?}");
        }
    });
}

#[test]
fn coherent_is_exact_with_all_options() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(500);
        let plain = ChcOptions::default();
        for options in [
            ChcOptions { leaf_test: LeafTest::Box, ..plain },
            ChcOptions { assumed_visible_frames: 0, ..plain },
            ChcOptions { tests_per_submit: 1, draws_per_submit: 1, ..plain },
            ChcOptions { tests_per_submit: 10_000, draws_per_submit: 10_000, ..plain },
        ] {
            let renderer = coherent(options);
            let found = walk_with(device, &scene, PathKind::Cut, 12, &renderer, methods::CHC);
            check(&found, &format!("{options:?}"));
        }
    });
}

#[test]
fn a_depth_only_first_pass_gives_the_same_image() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(500);
        for path in [PathKind::Street, PathKind::Cut] {
            let first_pass = FirstPass::DepthOnly;
            let options = coherent(ChcOptions { first_pass, ..Default::default() });
            let found = walk_with(device, &scene, path, 12, &options, methods::CHC);
            // Where two faces of an object have the same depth at a pixel, the last one wins
            // instead of the first.
            assert!(found.pixels_wrong <= 12 * 160 * 90 / 10_000, "{path}: {found:?}");
            assert!(found.draws[1] < found.draws[0], "{path}: {found:?}");
        }
    });
}

#[test]
fn a_visibility_threshold_leaves_out_what_hardly_shows() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(600);
        let walk = |visibility_threshold_samples| {
            let plain = ChcOptions { assumed_visible_frames: 0, ..Default::default() };
            let options = coherent(ChcOptions { visibility_threshold_samples, ..plain });
            walk_with(device, &scene, PathKind::Street, 10, &options, methods::CHC)
        };
        let exact = walk(0);
        let loose = walk(20);
        check(&exact, "no threshold");
        assert!(loose.draws[1] < exact.draws[1], "{loose:?} {exact:?}");
        // Objects of up to 20 pixels may be missing, so the image is only slightly wrong.
        assert!(loose.pixels_wrong > 0 && loose.pixels_wrong < 10 * 160 * 90 / 20, "{loose:?}");
    });
}

#[test]
fn a_blocking_method_waits_and_says_how_often() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(500);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let cameras: Vec<Camera> = (0..6).map(|frame| path.camera(frame)).collect();
        let mut renderer = Renderer::new(device, &scene, &options([160, 90], 2)).unwrap();
        let mut waits = Vec::new();
        for strategy in DIALOGUES {
            let mut view = renderer.new_view().unwrap();
            let walked = frame_loop(&mut renderer, &mut view, strategy, &cameras);
            let told: u64 = walked.reports.iter().map(|report| u64::from(report.waits)).sum();
            assert_eq!(told, walked.blocking_waits, "{strategy}");
            for (report, outcome) in walked.reports.iter().zip(&walked.outcomes) {
                assert_eq!(outcome.draws, u64::from(report.plan.visible), "{strategy}");
                assert!(report.queries >= report.tests && report.tests > 0, "{strategy}");
                assert!(report.waits <= report.queries, "{strategy}");
            }
            waits.push(told);
        }
        let [naive, batched, stop, coherent] = waits[..] else { panic!("{waits:?}") };
        assert!(coherent * 8 < stop && batched * 8 < naive, "{waits:?}");
        let mut view = renderer.new_view().unwrap();
        let walked = frame_loop(&mut renderer, &mut view, methods::NEXT_FRAME, &cameras);
        assert_eq!(walked.blocking_waits, 0);
        assert!(walked.reports.iter().all(|report| report.waits == 0));
    });
}

#[test]
fn next_frame_is_right_at_rest_and_counted_wrong_on_the_way() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(500);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options([160, 90], 2)).unwrap();
        let mut plain = renderer.new_view().unwrap();
        let mut view = renderer.new_view().unwrap();
        let mut wrong = |cameras: &[Camera], renderer: &mut Renderer| -> Vec<usize> {
            let expected = frame_loop(renderer, &mut plain, Strategy::FRUSTUM, cameras).images;
            let got = frame_loop(renderer, &mut view, methods::NEXT_FRAME, cameras);
            let draws = got.draws();
            assert!(draws > 0 && draws < (scene.objects.len() * cameras.len()) as u64);
            let pairs = expected.iter().zip(&got.images);
            pairs.map(|(a, b)| images_that_differ(a, b)).collect()
        };
        let still = vec![path.camera(0); 16];
        let at_rest = wrong(&still, &mut renderer);
        assert_eq!(at_rest[0], 0, "of what nothing is known is drawn");
        assert!(at_rest[10..].iter().all(|pixels| *pixels == 0), "{at_rest:?}");
        // Five times as fast as a walk.
        let moving: Vec<Camera> = (0..24).map(|frame| path.camera(5 * frame)).collect();
        let total: usize = wrong(&moving, &mut renderer).iter().sum();
        assert!(total > 0, "then it would be exact");
        assert!(total < 24 * 160 * 90 / 20, "{total} pixels");
    });
}

#[test]
fn strategies_change_from_frame_to_frame() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(300);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options([160, 90], 3)).unwrap();
        let mut views = [renderer.new_view().unwrap(), renderer.new_view().unwrap()];
        let mut plain = renderer.new_view().unwrap();
        let turns = [
            methods::CHC,
            methods::NEXT_FRAME,
            Strategy::ANTUMBRA,
            methods::BATCHED,
            methods::CHC,
            methods::HZB,
            methods::STOP_AND_WAIT,
        ];
        for (turn, strategy) in turns.into_iter().cycle().take(21).enumerate() {
            let cameras: Vec<Camera> =
                (0..2).map(|frame| path.camera(turn as u32 * 5 + frame)).collect();
            let expected = frame_loop(&mut renderer, &mut plain, Strategy::FRUSTUM, &cameras);
            let got = frame_loop(&mut renderer, &mut views[turn % 2], strategy, &cameras);
            assert_eq!(got.outcomes.len(), cameras.len());
            for (expected, got) in expected.images.iter().zip(&got.images) {
                let wrong = images_that_differ(expected, got);
                assert!(wrong == 0 || !strategy.is_exact(), "turn {turn}, {strategy}: {wrong}");
            }
        }
    });
}

#[test]
fn passes_are_timed_by_their_labels() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(300);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let first_pass = FirstPass::DepthOnly;
        let options = coherent(ChcOptions { first_pass, ..Default::default() });
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        renderer.time_passes().unwrap();
        let mut view = renderer.new_view().unwrap();
        // Each slot has only one frame with times that are read back, and nothing is known in it.
        let cameras: Vec<_> = (0..3).map(|frame| path.camera(frame)).collect();
        frame_loop(&mut renderer, &mut view, methods::CHC, &cameras);
        let labels: Vec<_> = renderer.pass_times().iter().map(|time| time.label).collect();
        let batches = labels.iter().filter(|label| **label == "draw and query").count();
        assert!(batches > 1, "{labels:?}");
        assert_eq!(&labels[batches..], ["shade", "copy image"]);
        let total_ms: f64 = renderer.pass_times().iter().map(|time| time.gpu_ms).sum();
        assert!(total_ms > 0.0 && total_ms < 60_000.0, "{total_ms} ms");
    });
}

#[test]
fn a_frame_is_sent_off_in_pieces() {
    run_on_all(|device| {
        let gate = Timeline::new(device, "gate").unwrap();
        let mut ring = FrameRing::new(device, 2).unwrap();
        let before = device.completed().unwrap();
        let mut frame = ring.begin().unwrap();
        // More pieces than share descriptors. The commands of all pieces run in order.
        let mut ticks: Vec<Tick> =
            (0..100).map(|_| frame.flush(Some(gate.at(Tick(1)))).unwrap()).collect();
        assert_eq!(device.completed().unwrap(), before, "all pieces are held back");
        assert_eq!(frame.waits(), 0);
        gate.signal(Tick(1)).unwrap();
        frame.wait(ticks[50]).unwrap();
        assert!(device.completed().unwrap() >= ticks[50]);
        // A tick that was never submitted is not awaited.
        frame.wait(Tick(u64::MAX)).unwrap();
        assert!(frame.waits() <= 2);
        ticks.push(frame.submit(None).unwrap());
        assert!(ticks.is_sorted());
        // A frame that is given up after a piece does not affect the next frame.
        for _ in 0..5 {
            let mut given_up = ring.begin().unwrap();
            given_up.flush(None).unwrap();
        }
        ring.begin().unwrap().submit(None).unwrap();
        device.wait_idle().unwrap();
    });
}

#[test]
fn a_host_holds_a_blocking_method_back_only_up_to_its_gate() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(300);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options([160, 90], 2)).unwrap();
        let mut view = renderer.new_view().unwrap();
        let gate = Timeline::new(device, "gate").unwrap();
        gate.signal(Tick(1)).unwrap();
        let [expected, got] = [(); 2].map(|()| Readback::new(device, [160, 90]).unwrap());
        for (strategy, image) in [(Strategy::FRUSTUM, &expected), (methods::CHC, &got)] {
            let request = FrameRequest {
                image: Some(image),
                after: Some(gate.at(Tick(1))),
                ..FrameRequest::new(strategy, path.camera(3))
            };
            renderer.render(&mut view, request).unwrap();
        }
        renderer.wait_idle(&mut view).unwrap();
        assert_eq!(images_that_differ(&expected, &got), 0);
    });
}
