//! The end of a walk: the image and the counts of its last frame, and views that cannot be
//! finished.

use cull::Strategy;
use gpu::{Readback, SampleCount};
use render::{Error, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, PathKind};
use tests::run_on_all;
use tests::walk::SceneKind;

const SIZE: [u32; 2] = [96, 64];

#[test]
fn the_last_frame_is_the_one_that_was_drawn_and_counted() {
    run_on_all(|device| {
        let city = SceneKind::City.build(300);
        let path = CameraPath::new(PathKind::Street, &city.routes).unwrap();
        for samples in [SampleCount::One, SampleCount::Four] {
            let options = RendererOptions { size: SIZE, samples, ..Default::default() };
            let mut renderer = Renderer::new(device, &city.scene, &options).unwrap();
            if renderer.supports(Strategy::default()).is_err() {
                // SwiftShader does not test samples individually.
                assert_eq!(samples, SampleCount::Four);
                continue;
            }
            let mut view = renderer.new_view().unwrap();
            let nothing = renderer.finish(&mut view);
            assert!(matches!(nothing, Err(Error::Gpu(gpu::Error::NoImage))), "no frame yet");
            let copy = Readback::new(device, SIZE).unwrap();
            let mut known = None;
            for frame in 0..8 {
                let request = FrameRequest::from(path.camera(frame));
                let request = FrameRequest { image: Some(&copy), ..request };
                known = renderer.render(&mut view, request).unwrap().known;
            }
            let last = renderer.finish(&mut view).unwrap();
            assert_eq!(last.image.size, SIZE);
            assert!(*last.image.pixels == *copy.rgba8().unwrap(), "{samples:?}: another image");
            let newest = view.newest_stats().unwrap();
            assert_eq!([last.drawn, last.triangles], [newest.draws, newest.triangles]);
            assert_eq!(view.drain_stats().next_back(), Some(newest));
            let known = known.expect("results of frames before");
            assert!(known.frame <= newest.frame, "{known:?} {newest:?}");
            let seen = renderer.view_of(&path.camera(7));
            let in_frustum = renderer.hierarchy().objects_in_frustum(&seen);
            assert_eq!(last.in_frustum, u64::from(in_frustum));
            assert!(last.drawn > 0 && last.drawn <= last.in_frustum, "{last:?}");
            // The view can be finished again, and can go on.
            assert!(renderer.finish(&mut view).unwrap() == last);
            renderer.render(&mut view, path.camera(8)).unwrap();
            assert!(renderer.finish(&mut view).unwrap().image != last.image);

            // A second view has another image, and another one has none.
            let mut second = renderer.new_view().unwrap();
            renderer.render(&mut second, path.camera(3)).unwrap();
            for absent in [&mut view, &mut renderer.new_view().unwrap()] {
                let refused = renderer.finish(absent);
                assert!(matches!(refused, Err(Error::NotNewest)), "{refused:?}");
            }
            assert!(renderer.finish(&mut second).unwrap().drawn > 0);

            let mut other = Renderer::new(device, &city.scene, &options).unwrap();
            other.render(&mut other.new_view().unwrap(), path.camera(0)).unwrap();
            assert!(other.finish(&mut view).is_err(), "a view of another renderer");
        }
    });
}
