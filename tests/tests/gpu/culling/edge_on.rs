//! Sills at the height of the eye. A rasteriser that interpolates depth from vertices before it
//! snaps them draws streaks of such faces through the walls in front of them. Streaks need a row of
//! samples at that height. With vertices that are already on the grid there are no streaks.

use cull::{Camera, Strategy};
use gpu::{Device, Readback};
use render::{FrameRequest, Renderer, RendererOptions};
use scene::Scene;
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::run_on_all;

/// An odd size, so that the middle of a row of samples is at the height of the eye.
const SIZE: [u32; 2] = [321, 181];

fn request(strategy: Strategy, camera: Camera, image: &Readback) -> FrameRequest<'_> {
    FrameRequest { image: Some(image), ..FrameRequest::new(strategy, camera) }
}

/// Compares the frames of strategies with frustum culling, from an empty history and with a
/// standing camera.
fn compare(device: &Device, scene: &Scene, camera: Camera) {
    let options =
        RendererOptions { methods: methods::all(), size: SIZE, ..RendererOptions::default() };
    let mut renderer = Renderer::new(device, scene, &options).unwrap();
    let images = [0, 1].map(|_| Readback::new(device, SIZE).unwrap());
    let [expected, found] = &images;
    let mut view = renderer.new_view().unwrap();
    renderer.render(&mut view, request(Strategy::FRUSTUM, camera, expected)).unwrap();
    let strategies = [
        methods::NAIVE,
        methods::STOP_AND_WAIT,
        methods::CHC,
        methods::HZB,
        Strategy::ANTUMBRA,
        Strategy::ANTUMBRA_QUERIES,
    ];
    for strategy in strategies {
        let mut view = renderer.new_view().unwrap();
        for frame in 0..4 {
            renderer.render(&mut view, request(strategy, camera, found)).unwrap();
            renderer.wait_idle(&mut view).unwrap();
            let is_equal = *expected.rgba8().unwrap() == *found.rgba8().unwrap();
            assert!(is_equal, "{}: frame {frame} of {strategy}", device.adapter().name);
        }
    }
}

#[test]
fn a_street_is_exact_where_its_sills_are_at_the_height_of_the_eye() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = city(1_000, 3).unwrap();
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        compare(device, &scene, path.camera(5));
    });
}
