//! The image is the same with every tester of the proxies: queries, fragments, a compute shader.

use cull::Strategy;
use gpu::{Device, PredicationMode, Readback};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::walk::{SceneKind, pixels_that_differ, walk_with};
use tests::{Driver, run, run_on_all};

const TESTERS: [Strategy; 3] =
    [Strategy::ANTUMBRA_QUERIES, Strategy::ANTUMBRA_FLAGS, Strategy::ANTUMBRA_COMPUTE];

fn walk_testers(device: &Device, objects: u32, options: &RendererOptions, frames: u32) {
    for scene_kind in SceneKind::ALL {
        let scene = scene_kind.build(objects);
        for path in PathKind::ALL {
            for strategy in TESTERS {
                let found = walk_with(device, &scene, path, frames, options, strategy);
                let what = format!("{strategy}, {scene_kind:?} {path}: {found:?}");
                assert_eq!(found.pixels_wrong, 0, "{what}");
                assert_eq!(found.blocking_waits, 0, "{what}");
            }
        }
    }
}

#[test]
fn every_tester_is_exact() {
    run_on_all(|device| {
        for (frames_in_flight, cost_model) in [(1, CostModel::Off), (3, CostModel::Measured)] {
            let options = RendererOptions {
                size: [160, 90],
                frames_in_flight,
                cost_model,
                ..Default::default()
            };
            walk_testers(device, 400, &options, 22);
        }
    });
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
