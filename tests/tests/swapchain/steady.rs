//! A window at rest: no Vulkan object is created, no memory is allocated, and nothing waits. A
//! renderer's frame in the window equals its frame without a window.

use std::time::Duration;

use cull::Strategy;
use gpu::{PresentId, PresentResult, Readback, SwapchainOptions};
use render::{FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::walk::SceneKind;
use tests::window_fixture::{WindowStage, await_image};
use tests::window_matrix::{WAYS, modes};
use tests::x11_window::X11Window;
use tests::xvfb::Xvfb;

#[test]
fn the_renderers_image_in_a_window_is_the_one_without_it() {
    let server = Xvfb::start();
    for (driver, library) in WAYS {
        let size = [256, 144];
        let window = X11Window::open(&server, library, size);
        let stage = WindowStage::new(driver, window.clone());
        let GeneratedScene { scene, routes } = SceneKind::City.build(600);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let options = RendererOptions { methods: methods::all(), size, ..Default::default() };
        let mut renderer = Renderer::new(&stage.device, &scene, &options).unwrap();
        let mut swapchain = stage.swapchain(&SwapchainOptions::default());
        let error = renderer.present(&mut swapchain, size).expect_err("no image yet");
        assert!(error.to_string().contains("no frame that was submitted"), "{error}");

        let mut windowed = renderer.new_view().unwrap();
        let waits = stage.device.wait_counts().other;
        let camera = |frame| path.camera(frame);
        for frame in 0..12 {
            let request = FrameRequest::new(Strategy::ANTUMBRA, camera(frame));
            renderer.render(&mut windowed, request).unwrap();
            let shown = renderer.present(&mut swapchain, size).unwrap();
            assert!(shown.presented().is_some(), "{shown:?}");
        }
        assert_eq!(stage.device.wait_counts().other, waits, "nothing but slots was waited for");
        let seen = || window.pixels(size);
        // The same frame without a window, read back.
        let image = Readback::new(&stage.device, size).unwrap();
        let mut headless = renderer.new_view().unwrap();
        let request = FrameRequest {
            image: Some(&image),
            ..FrameRequest::new(Strategy::FRUSTUM, camera(11))
        };
        renderer.render(&mut headless, request).unwrap();
        renderer.wait_idle(&mut headless).unwrap();
        let pixel = |pixel: &[u8]| [pixel[0], pixel[1], pixel[2]];
        let expected: Vec<_> = image.rgba8().unwrap().chunks_exact(4).map(pixel).collect();
        await_image(&expected, seen);
        // An image that was read back can also be shown, repeatedly and enlarged.
        for _ in 0..2 {
            assert!(renderer.present(&mut swapchain, size).unwrap().presented().is_some());
        }
        await_image(&expected, seen);
        window.resize([512, 300]);
        for _ in 0..3 {
            let shown = renderer.present(&mut swapchain, [512, 300]).unwrap();
            assert!(!matches!(shown, PresentResult::Not(gpu::PresentSkipped::Hidden)));
        }
        drop((windowed, headless, image, swapchain, renderer));
        stage.end();
    }
}

#[test]
fn presents_are_numbered_and_told_of_where_the_driver_tells() {
    let server = Xvfb::start();
    for (driver, library) in WAYS {
        let size = [64, 64];
        let window = X11Window::open(&server, library, size);
        let stage = WindowStage::new(driver, window.clone());
        let mut painter = tests::window_fixture::Painter::new(&stage.device, size);
        let mut swapchain = stage.swapchain(&SwapchainOptions::default());
        assert_eq!((swapchain.newest_presented(), swapchain.size()), (None, None));
        for number in 1..=5 {
            painter.paint(number, None);
            tests::window_fixture::show_surely(&mut swapchain, &painter.target, size);
            assert_eq!(swapchain.newest_presented(), Some(PresentId(number.into())));
        }
        assert!(swapchain.format().unwrap().contains("UNORM in SRGB_NONLINEAR"));
        assert!(swapchain.image_count() >= 3);
        // Neither driver supports the report: the result is unknown immediately.
        assert_eq!(swapchain.newest_shown().unwrap(), None);
        assert!(!swapchain.wait_until_shown(PresentId(5), Duration::from_secs(9)).unwrap());
        assert_eq!(swapchain.refresh_duration().unwrap(), None);
        swapchain.timings(|timing| panic!("{timing:?}")).unwrap();
        assert!(modes(driver).contains(&swapchain.mode()));
        drop((swapchain, painter));
        stage.end();
    }
}
