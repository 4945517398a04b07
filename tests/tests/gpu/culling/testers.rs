//! The image is the same with every tester of the proxies: queries, fragments, a compute shader.

use std::ops::Range;

use cull::Strategy;
use gpu::{Device, PredicationMode, Readback};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::walk::{ComparedWalk, SceneKind, cameras_along, pixels_that_differ, walk_with};
use tests::{Driver, run, run_on_all};

const TESTERS: [Strategy; 3] =
    [Strategy::ANTUMBRA_QUERIES, Strategy::ANTUMBRA_FLAGS, Strategy::ANTUMBRA_COMPUTE];

/// Returns options of a walk: with an odd number, everything is tested.
fn options(walk: usize) -> RendererOptions {
    let (frames_in_flight, cost_model) =
        if walk.is_multiple_of(2) { (3, CostModel::Measured) } else { (1, CostModel::Off) };
    RendererOptions { size: [160, 90], frames_in_flight, cost_model, ..Default::default() }
}

/// Walks all scenes and paths with every tester. `walks` returns the numbers of the options on a
/// path.
fn walk_testers(device: &Device, frames: u32, walks: impl Fn(usize) -> Range<usize>) {
    let mut number = 0;
    for scene_kind in SceneKind::ALL {
        let scene = scene_kind.build(400);
        for path in PathKind::ALL {
            let cameras = cameras_along(&scene, path, frames);
            for number in walks(number) {
                let mut walk = ComparedWalk::new(device, &scene.scene, &cameras, &options(number));
                for strategy in TESTERS {
                    let found = walk.with(strategy);
                    let what = format!("{strategy}, {scene_kind:?} {path}: {found:?}");
                    assert_eq!(found.pixels_wrong, 0, "{what}");
                    assert_eq!(found.blocking_waits, 0, "{what}");
                }
            }
            number += 1;
        }
    }
}

#[test]
fn every_tester_is_exact() {
    // The second scene has the other options on each path.
    run_on_all(|device| walk_testers(device, 6, |number| number..number + 1));
}

#[test]
#[ignore = "long walk"]
fn every_tester_is_exact_with_and_without_costs() {
    run_on_all(|device| walk_testers(device, 22, |_| 0..2));
}

#[test]
#[ignore = "long walk"]
fn every_tester_is_exact_with_every_way_to_skip_draws() {
    run(Driver::Lavapipe, |device| {
        let scene = SceneKind::City.build(900);
        for predication in
            [PredicationMode::Conditional, PredicationMode::Counts, PredicationMode::Instances]
        {
            for strategy in TESTERS {
                let options = RendererOptions {
                    size: [200, 120],
                    predication: Some(predication),
                    // Everything that may be hidden is tested, regardless of its cost.
                    cost_model: CostModel::Off,
                    ..Default::default()
                };
                let found = walk_with(device, &scene, PathKind::Cut, 25, &options, strategy);
                let what = format!("{strategy}, {}: {found:?}", predication.name());
                assert_eq!(found.pixels_wrong, 0, "{what}");
                assert!(found.draws[1] * 2 < found.draws[0], "{what}");
            }
        }
    });
}

#[test]
#[ignore = "long walk"]
fn every_tester_is_exact_after_the_image_was_resized() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(400);
        let path = CameraPath::new(PathKind::Cut, &routes).unwrap();
        for strategy in TESTERS {
            let options = RendererOptions {
                size: [64, 36],
                cost_model: CostModel::Off,
                ..Default::default()
            };
            let mut renderer = Renderer::new(device, &scene, &options).unwrap();
            let mut views = [0, 1].map(|_| renderer.new_view().unwrap());
            for (round, size) in [[64, 36], [240, 135], [97, 53], [240, 135]].iter().enumerate() {
                renderer.resize(*size).unwrap();
                let images = [0, 1].map(|_| Readback::new(device, *size).unwrap());
                for frame in 0..12 {
                    let camera = path.camera(frame);
                    let strategies = [Strategy::FRUSTUM, strategy];
                    for ((view, image), strategy) in views.iter_mut().zip(&images).zip(strategies) {
                        let request = FrameRequest {
                            image: Some(image),
                            ..FrameRequest::new(strategy, camera)
                        };
                        renderer.render(view, request).unwrap();
                    }
                    device.wait_idle().unwrap();
                    let [expected, found] = images.each_ref().map(|image| image.rgba8().unwrap());
                    let wrong = pixels_that_differ(&expected, &found);
                    assert_eq!(wrong, 0, "{strategy}, round {round}, {size:?}, frame {frame}");
                }
            }
        }
    });
}
