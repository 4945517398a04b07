//! Images with several samples per pixel that hosts copy by their own commands.

use std::sync::{Arc, Mutex};

use cull::Strategy;
use gpu::{Purpose, Readback, SampleCount};
use render::{FrameRequest, Renderer};
use scenes::{CameraPath, PathKind};
use tests::Driver;
use tests::host_device::Host;
use tests::walk::SceneKind;

use super::options;

const SIZE: [u32; 2] = [96, 64];

/// Runs only on Mesa's driver: SwiftShader averages encoded values, and has no exact culling.
#[test]
fn lavapipe_hosts_read_averages_of_four_samples() {
    let host = Host::new(Driver::Lavapipe, Purpose::Renderer);
    let lock = Arc::new(Mutex::new(()));
    let device = host.adopt(Some(host.share_queue(Arc::clone(&lock) as _)));
    let city = SceneKind::City.build(300);
    let path = CameraPath::new(PathKind::Street, &city.routes).unwrap();
    let film = |samples: SampleCount| -> Vec<Vec<u8>> {
        let mut renderer = Renderer::new(&device, &city.scene, &options(SIZE, samples)).unwrap();
        let mut views = [renderer.new_view().unwrap(), renderer.new_view().unwrap()];
        let own = Readback::new(&device, SIZE).unwrap();
        let mut frame = |number: u32| {
            let [culled, plain] = [Strategy::ANTUMBRA, Strategy::FRUSTUM].map(|strategy| {
                let view = &mut views[usize::from(strategy == Strategy::FRUSTUM)];
                // With and without a copy by the engine.
                let image = (strategy == Strategy::FRUSTUM).then_some(&own);
                let request = FrameRequest::new(strategy, path.camera(number * 20));
                renderer.render(view, FrameRequest { image, ..request }).unwrap();
                let finished = renderer.finished_image().unwrap();
                assert_eq!(finished.size, SIZE);
                host.copy(&*lock, &finished)
            });
            // The host's copy was submitted after both to the same queue.
            assert!(plain == *own.rgba8().unwrap(), "frame {number}: not the engine's own image");
            assert!(culled == plain, "frame {number}: culling shows");
            plain
        };
        let images = (0..6).map(&mut frame).collect();
        let [culled, plain] = &mut views;
        renderer.wait_idle(culled).unwrap();
        renderer.wait_idle(plain).unwrap();
        images
    };
    let [one, four] = [SampleCount::One, SampleCount::Four].map(film);
    for (one, four) in one.iter().zip(&four) {
        let pixels = one.chunks_exact(4).zip(four.chunks_exact(4));
        let differing = pixels.filter(|(one, four)| one != four).count();
        let all = (SIZE[0] * SIZE[1]) as usize;
        assert!((all / 100..all * 3 / 4).contains(&differing), "{differing} pixels at edges");
    }
    drop(device);
    host.finish();
}
