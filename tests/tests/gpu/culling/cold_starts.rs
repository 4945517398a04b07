//! The first frames of a view with an empty history, for standing cameras, odd image sizes and
//! scenes of several seeds. Every frame is compared, including the first.

use cull::{Camera, Strategy};
use gpu::Device;
use render::{Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::walk::{frame_loop, images_that_differ};
use tests::{Driver, run};

/// The number of frames for which a camera stands. The results of the first frame are read back
/// before the last frame.
const FRAMES: usize = 4;

/// Returns the exact strategies that need no preparation, except the one that waits for each
/// object.
fn strategies() -> impl Iterator<Item = Strategy> {
    let left_out = [Strategy::FRUSTUM, methods::NAIVE, methods::IDEAL];
    methods::strategies()
        .into_iter()
        .filter(move |strategy| strategy.is_exact() && !left_out.contains(strategy))
}

/// Checks that no strategy has wrong pixels with a standing `camera`, each with a new view.
fn check_standing(renderer: &mut Renderer, camera: Camera, what: &str) {
    let cameras = [camera; FRAMES];
    let mut plain = renderer.new_view().unwrap();
    let expected = frame_loop(renderer, &mut plain, Strategy::FRUSTUM, &cameras[..1]);
    for strategy in strategies() {
        let mut view = renderer.new_view().unwrap();
        let found = frame_loop(renderer, &mut view, strategy, &cameras);
        for (frame, image) in found.images.iter().enumerate() {
            let wrong = images_that_differ(&expected.images[0], image);
            assert_eq!(wrong, 0, "{strategy}, {what}, frame {frame}");
        }
    }
}

fn stand_everywhere(device: &Device, seeds: &[u64], size: [u32; 2]) {
    let options = RendererOptions {
        methods: methods::all(),
        size,
        frames_in_flight: 2,
        ..Default::default()
    };
    for seed in seeds {
        let GeneratedScene { scene, routes } = scenes::city(600, *seed).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        for path in PathKind::ALL {
            let cameras = CameraPath::new(path, &routes).unwrap();
            for frame in [0, 45, 170] {
                let what = format!("seed {seed}, {size:?}, frame {frame} of {path}");
                check_standing(&mut renderer, cameras.camera(frame), &what);
            }
        }
    }
}

#[test]
#[ignore = "long walk"]
fn lavapipe_is_exact_from_the_first_frame_on() {
    run(Driver::Lavapipe, |device| {
        stand_everywhere(device, &[1, 3], [321, 181]);
        stand_everywhere(device, &[2], [97, 203]);
    });
}

#[test]
#[ignore = "long walk"]
fn swiftshader_is_exact_from_the_first_frame_on() {
    run(Driver::SwiftShader, |device| {
        stand_everywhere(device, &[1, 3], [321, 181]);
        stand_everywhere(device, &[2], [97, 203]);
    });
}
