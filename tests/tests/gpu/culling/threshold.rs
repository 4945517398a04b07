//! A visibility threshold: images are not exact, and the counted error is an upper bound of their
//! error.

use cull::{Aabb, Camera, ChcOptions, Strategy};
use glam::Vec3;
use gpu::{Device, PredicationMode, Readback};
use render::{CostModel, FrameRequest, Rect, Renderer, RendererOptions};
use scene::Scene;
use scenes::{CameraPath, Cast, GeneratedScene, Motion, PathKind, Routes};
use tests::shapes::{box_at, box_scene, square_camera};
use tests::walk::{SceneKind, frame_loop, images_that_differ, pixels_that_differ, show_motion};
use tests::{Driver, run, run_on_all};

const SIZE: [u32; 2] = [240, 135];

fn options(threshold_samples: u32) -> RendererOptions {
    let coherent =
        ChcOptions { visibility_threshold_samples: threshold_samples, ..ChcOptions::default() };
    // Measured costs differ from run to run; without costs, everything is tested.
    RendererOptions {
        methods: vec![methods::chc(coherent)],
        size: SIZE,
        threshold_samples,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

/// The results of a walk, over all frames.
#[derive(Debug, Default)]
struct Found {
    pixels_wrong: u64,
    below_threshold: u64,
    draws: u64,
}

/// Walks with `strategy`, and checks that no frame has more wrong pixels than its count.
fn walk(
    device: &Device,
    scene: &Scene,
    cameras: &[Camera],
    options: &RendererOptions,
    strategy: Strategy,
) -> Found {
    let mut renderer = Renderer::new(device, scene, options).unwrap();
    let [expected, got] = [Strategy::FRUSTUM, strategy].map(|strategy| {
        let mut view = renderer.new_view().unwrap();
        frame_loop(&mut renderer, &mut view, strategy, cameras)
    });
    assert_eq!(got.outcomes.len(), cameras.len());
    let mut found = Found::default();
    let images = expected.images.iter().zip(&got.images);
    for (number, ((expected, got), outcome)) in images.zip(&got.outcomes).enumerate() {
        let wrong = images_that_differ(expected, got) as u64;
        let what = format!("{strategy}, threshold {}", options.threshold_samples);
        assert!(
            wrong <= outcome.samples_below_threshold,
            "{what}, frame {number}: {wrong}, {outcome:?}"
        );
        found.pixels_wrong += wrong;
        found.below_threshold += outcome.samples_below_threshold;
        found.draws += outcome.draws;
    }
    assert!(expected.outcomes.iter().all(|outcome| outcome.samples_below_threshold == 0));
    found
}

fn cameras(routes: &Routes, path: PathKind, frames: u32) -> Vec<Camera> {
    let path = CameraPath::new(path, routes).unwrap();
    (0..frames).map(|frame| path.camera(frame)).collect()
}

#[test]
#[ignore = "long walk"]
fn no_frame_is_more_wrong_than_what_was_counted() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(1_500);
        for strategy in [Strategy::ANTUMBRA, Strategy::ANTUMBRA_QUERIES, methods::CHC] {
            for path in [PathKind::Street, PathKind::Cut] {
                let cameras = cameras(&routes, path, 20);
                let walk =
                    |threshold| walk(device, &scene, &cameras, &options(threshold), strategy);
                let [exact, little, much] = [0, 12, 200].map(walk);
                let what = format!("{strategy}, {path}: {exact:?} {little:?} {much:?}");
                assert_eq!((exact.pixels_wrong, exact.below_threshold), (0, 0), "{what}");
                assert!(much.pixels_wrong > 0 && little.below_threshold > 0, "{what}");
                assert!(little.below_threshold < much.below_threshold, "{what}");
                assert!(much.draws < exact.draws && much.draws < little.draws, "{what}");
            }
        }
    });
}

#[test]
fn every_executor_that_can_compare_leaves_out_the_same() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(700);
        let cameras = cameras(&routes, PathKind::Cut, 14);
        let mut found = Vec::new();
        for predication in
            [PredicationMode::Counts, PredicationMode::Instances, PredicationMode::Compacted]
        {
            // With more frames in flight, the arrival of answers depends on the load of the
            // machine.
            let options = RendererOptions {
                predication: Some(predication),
                frames_in_flight: 1,
                ..options(40)
            };
            if Renderer::new(device, &scene, &options).is_ok() {
                found.push(walk(device, &scene, &cameras, &options, Strategy::ANTUMBRA));
            }
        }
        assert!(!found.is_empty());
        for one in &found {
            assert!(one.pixels_wrong > 0, "{found:?}");
            assert_eq!(one.pixels_wrong, found[0].pixels_wrong, "{found:?}");
        }
    });
}

/// Checks that an object with as many visible samples as the threshold is hidden, and an object
/// with one more is not. Each box in a row behind a wall shows slightly more than the previous one.
#[test]
fn what_shows_as_much_as_the_threshold_is_hidden_and_a_sample_more_is_not() {
    run_on_all(|device| {
        let size = [256, 256];
        let wall = Aabb::new(Vec3::new(-9.0, -9.0, -10.1), Vec3::new(9.0, 0.0, -10.0));
        let peeping = (0..8).map(|number| {
            let x = number as f32 * 2.0 - 7.0;
            box_at(Vec3::new(x, -0.6 + 0.15 * number as f32, -11.0), Vec3::new(0.5, 0.6, 0.1))
        });
        let boxes: Vec<Aabb> = std::iter::once(wall).chain(peeping).collect();
        let scene = box_scene(&boxes);
        let cameras = vec![square_camera(); 16];
        let mut last = None;
        for threshold in [0, 1, 10, 60, 1_000, u32::MAX] {
            // Everything is tested, regardless of its cost.
            let options = RendererOptions { size, ..options(threshold) };
            let found = walk(device, &scene, &cameras, &options, Strategy::ANTUMBRA);
            let (draws, wrong) = last.unwrap_or((found.draws, 0));
            assert!(found.draws <= draws && found.pixels_wrong >= wrong, "{threshold}: {found:?}");
            last = Some((found.draws, found.pixels_wrong));
            let is_all_lost = threshold >= 100_000;
            assert_eq!(found.draws == 0, is_all_lost, "{threshold}: {found:?}");
        }
    });
}

#[test]
fn moving_scenes_and_costs_keep_the_bound() {
    run(Driver::Lavapipe, |device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(600);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let motion = Motion::new(&scene, 20, 3).unwrap();
        let options = RendererOptions {
            cost_model: render::CostModel::Table(cull::CostTable::default()),
            ..options(50)
        };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut cast = Cast::new(&motion);
        let mut views = [(); 2].map(|()| renderer.new_view().unwrap());
        let images = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        let mut wrong_in_all = 0;
        for number in 0..30 {
            show_motion(&mut renderer, &motion, &mut cast, number).unwrap();
            let strategies = [Strategy::FRUSTUM, Strategy::ANTUMBRA];
            for ((view, image), strategy) in views.iter_mut().zip(&images).zip(strategies) {
                let request = FrameRequest {
                    image: Some(image),
                    ..FrameRequest::new(strategy, path.camera(number * 2))
                };
                renderer.render(view, request).unwrap();
                renderer.wait_idle(view).unwrap();
            }
            let [expected, got] = images.each_ref().map(|image| image.rgba8().unwrap());
            let wrong = pixels_that_differ(&expected, &got) as u64;
            let outcome = views[1].drain_stats().next_back().unwrap();
            assert!(
                wrong <= outcome.samples_below_threshold,
                "frame {number}: {wrong} {outcome:?}"
            );
            wrong_in_all += wrong;
        }
        assert!(wrong_in_all > 0);
    });
}

#[test]
#[ignore = "long walk"]
fn the_ideal_and_other_methods_stay_exact() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(400);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options(500)).unwrap();
        let mut finder = renderer.new_view().unwrap();
        let images = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        let others = methods::strategies()
            .into_iter()
            .filter(|strategy| strategy.is_exact() && !strategy.has_sample_threshold());
        for strategy in others.filter(|other| renderer.supports(*other).is_ok()).collect::<Vec<_>>()
        {
            let mut view = renderer.new_view().unwrap();
            for number in 0..4 {
                let camera = path.camera(number);
                let set = renderer.visible_set(&mut finder, camera, Rect::whole(SIZE)).unwrap();
                for (strategy, image) in [Strategy::FRUSTUM, strategy].into_iter().zip(&images) {
                    let request = FrameRequest {
                        visible: Some(&set),
                        image: Some(image),
                        ..FrameRequest::new(strategy, camera)
                    };
                    renderer.render(&mut view, request).unwrap();
                }
                renderer.wait_idle(&mut view).unwrap();
                let [expected, got] = images.each_ref().map(|image| image.rgba8().unwrap());
                assert_eq!(pixels_that_differ(&expected, &got), 0, "{strategy}, frame {number}");
            }
            assert!(view.drain_stats().all(|outcome| outcome.samples_below_threshold == 0));
        }
    });
}

#[test]
fn what_cannot_count_or_compare_is_refused() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(60);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let renderer = |predication, threshold| {
            let options = RendererOptions { predication, ..options(threshold) };
            Renderer::new(device, &scene, &options)
        };
        let refused = renderer(Some(PredicationMode::Conditional), 3).err().unwrap().to_string();
        assert!(refused.contains("cannot compare samples with a threshold of 3"), "{refused}");
        let mut chosen = renderer(None, 3).unwrap();
        assert_ne!(chosen.predication(), PredicationMode::Conditional);
        let mut view = chosen.new_view().unwrap();
        for strategy in [Strategy::ANTUMBRA_FLAGS, Strategy::ANTUMBRA_COMPUTE] {
            let request = FrameRequest::new(strategy, path.camera(0));
            let refused = chosen.render(&mut view, request).unwrap_err().to_string();
            assert!(refused.contains("use `antumbra` or `antumbra_queries`"), "{refused}");
        }
        chosen.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, path.camera(0))).unwrap();
        chosen.wait_idle(&mut view).unwrap();
    });
}
