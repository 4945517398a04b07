//! The yardstick is right: the ideal's picture is the whole one, and nothing in it could be left out.
#![forbid(unsafe_code)]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use cull::{ObjectId, Strategy};
use gpu::Readback;
use render::scene::{CameraPath, ObjectChange, PathKind};
use render::{Area, FrameRequest, Renderer, RendererOptions};
use tests::run_on_all;
use tests::walk::{SceneKind, pixels_that_differ};

const SIZE: [u32; 2] = [160, 90];
const AREA: Area = Area { origin: [0, 0], size: SIZE };

#[test]
fn the_ideal_is_exact_and_draws_only_what_owns_a_pixel() {
    run_on_all(|device| {
        let scene = SceneKind::City.build(600);
        let path = CameraPath::new(PathKind::Cut, &scene).unwrap();
        let options = RendererOptions { size: SIZE, ..Default::default() };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut finder = renderer.new_view().unwrap();
        let mut view = renderer.new_view().unwrap();
        let [expected, got] = [(); 2].map(|()| Readback::new(device, SIZE).unwrap());
        for frame in [0, 1, 9, 10, 20] {
            let camera = path.camera(frame);
            let set = renderer.visible_set(&mut finder, &camera, AREA).unwrap();
            let request = |strategy, picture| FrameRequest {
                visible: Some(&set),
                picture: Some(picture),
                ..FrameRequest::new(strategy, camera)
            };
            let all = request(Strategy::Frustum, &expected);
            let in_frustum = renderer.render(&mut view, &all).unwrap().plan.visible;
            renderer.render(&mut view, &request(Strategy::Ideal, &got)).unwrap();
            renderer.drain(&mut view).unwrap();
            assert_eq!(pixels_that_differ(expected.rgba8(), got.rgba8()), 0, "frame {frame}");
            assert!((set.leaves().len() as u32) < in_frustum, "frame {frame}");

            let again = renderer.visible_set(&mut finder, &camera, AREA).unwrap();
            assert_eq!(again, set, "frame {frame}: the past of the finder must not matter");
        }
    });
}

#[test]
fn the_ideal_without_a_set_is_refused() {
    run_on_all(|device| {
        let scene = SceneKind::Field.build(20);
        let path = CameraPath::new(PathKind::Street, &scene).unwrap();
        let options = RendererOptions { size: SIZE, ..Default::default() };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        let request = FrameRequest::new(Strategy::Ideal, path.camera(0));
        let refused = renderer.render(&mut view, &request).unwrap_err().to_string();
        assert!(refused.contains("Renderer::visible_set"), "{refused}");
        renderer.render(&mut view, &FrameRequest::new(Strategy::Antumbra, path.camera(0))).unwrap();
        renderer.drain(&mut view).unwrap();
        let set = renderer.visible_set(&mut view, &path.camera(0), AREA).unwrap();
        let request = FrameRequest { visible: Some(&set), ..request };
        renderer.update(&[]).unwrap();
        renderer.render(&mut view, &request).unwrap();
        renderer.update(&[ObjectChange::Remove { object: ObjectId(3) }]).unwrap();
        let refused = renderer.render(&mut view, &request).unwrap_err().to_string();
        assert!(refused.contains("has changed"), "{refused}");
        renderer.drain(&mut view).unwrap();
    });
}
