//! A host's own commands over the finished image: they appear in the image after everything else,
//! and not in results that were requested before.

use cull::Strategy;
use gpu::{Commands, Device, OverlayImage, Readback, SampleCount};
use render::{DebugOverlay, Error, FrameRequest, HostOverlay, Renderer, RendererOptions};
use scenes::{CameraPath, PathKind};
use tests::host_overlay::ClearedRectangle;
use tests::run_on_all;
use tests::walk::SceneKind;

const SIZE: [u32; 2] = [96, 64];
const GREEN: [u8; 4] = [0, 255, 0, 255];

fn rectangle(device: &Device) -> ClearedRectangle {
    let device = device.clone();
    ClearedRectangle { device, origin: [10, 20], size: [30, 12], colour: [0.0, 1.0, 0.0, 1.0] }
}

/// Checks that `drawn` equals `plain` except in the rectangle.
fn check(drawn: &[u8], plain: &[u8], what: &str) {
    for (place, (drawn, plain)) in drawn.chunks(4).zip(plain.chunks(4)).enumerate() {
        let x = place % SIZE[0] as usize;
        let y = place / SIZE[0] as usize;
        let is_inside = (10..40).contains(&x) && (20..32).contains(&y);
        let expected = if is_inside { &GREEN } else { plain };
        assert_eq!(drawn, expected, "{what}: {x}, {y}");
    }
}

#[test]
fn a_hosts_commands_are_in_the_image_and_not_in_the_scenes() {
    run_on_all(|device| {
        let city = SceneKind::City.build(300);
        let path = CameraPath::new(PathKind::Street, &city.routes).unwrap();
        for samples in [SampleCount::One, SampleCount::Four] {
            let options = RendererOptions { size: SIZE, samples, ..Default::default() };
            let mut renderer = Renderer::new(device, &city.scene, &options).unwrap();
            let mut view = renderer.new_view().unwrap();
            let [plain, whole, alone] = [0; 3].map(|_| Readback::new(device, SIZE).unwrap());
            let overlay = rectangle(device);
            for (frame, has_debug) in [(0, false), (1, false), (2, true)] {
                let has_wireframe = has_debug;
                let debug = DebugOverlay { has_wireframe, ..Default::default() };
                renderer.set_debug_overlay(debug).unwrap();
                let request = FrameRequest::new(Strategy::FRUSTUM, path.camera(frame));
                let bare = FrameRequest { image: Some(&plain), ..request };
                renderer.render(&mut view, bare).unwrap();
                // Without and with the image of the scene alone. Without it, the last rendering
                // resolves samples.
                for scene_image in [None, Some(&alone)] {
                    let overlay = Some(&overlay as &dyn HostOverlay);
                    let image = Some(&whole);
                    let over = FrameRequest { image, scene_image, overlay, ..request };
                    renderer.render(&mut view, over).unwrap();
                    renderer.wait_idle(&mut view).unwrap();
                    let what = format!("{samples:?}, frame {frame}");
                    check(&whole.rgba8().unwrap(), &plain.rgba8().unwrap(), &what);
                }
                if !has_debug {
                    assert!(*alone.rgba8().unwrap() == *plain.rgba8().unwrap(), "frame {frame}");
                }
            }
            renderer.set_debug_overlay(DebugOverlay::default()).unwrap();
            let camera = path.camera(1);
            let moment = renderer.snapshot(&mut view, renderer.view_of(&camera)).unwrap();
            renderer.render_snapshot(&moment, camera, Some(&plain), None).unwrap();
            renderer.render_snapshot(&moment, camera, Some(&whole), Some(&overlay)).unwrap();
            renderer.wait_idle(&mut view).unwrap();
            check(&whole.rgba8().unwrap(), &plain.rgba8().unwrap(), "a frozen moment");
        }
    });
}

/// An overlay that fails.
struct Broken;

impl HostOverlay for Broken {
    fn record(&self, _: &Commands, _: &OverlayImage) -> Result<(), Error> {
        Err(Error::Overlay("no glyphs".into()))
    }

    fn submitted(&self) {
        panic!("a frame that failed is not submitted");
    }
}

#[test]
fn a_host_that_fails_ends_its_frame_and_no_other() {
    run_on_all(|device| {
        let city = SceneKind::City.build(100);
        let path = CameraPath::new(PathKind::Street, &city.routes).unwrap();
        let options = RendererOptions { size: SIZE, ..Default::default() };
        let mut renderer = Renderer::new(device, &city.scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        let request = FrameRequest::new(Strategy::ANTUMBRA, path.camera(0));
        let request = FrameRequest { image: Some(&image), ..request };
        let broken = FrameRequest { overlay: Some(&Broken), ..request };
        let error = renderer.render(&mut view, broken).unwrap_err();
        assert_eq!(error.to_string(), "what is drawn over the image failed: no glyphs");
        let overlay = rectangle(device);
        let whole = FrameRequest { overlay: Some(&overlay), ..request };
        renderer.render(&mut view, whole).unwrap();
        renderer.wait_idle(&mut view).unwrap();
        let green = image.rgba8().unwrap().chunks(4).filter(|pixel| *pixel == GREEN).count();
        assert_eq!(green, 30 * 12);
    });
}
