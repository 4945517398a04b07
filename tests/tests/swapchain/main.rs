//! Images in windows of an X server without a screen, on both software drivers, under validation.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod changes;
mod shapes;
mod steady;
mod wayland;

use gpu::SwapchainOptions;
use tests::window_fixture::{Painter, WindowStage, await_image, show_surely};
use tests::window_matrix::{WAYS, modes};
use tests::x11_window::X11Window;
use tests::xvfb::Xvfb;

#[test]
fn an_image_in_a_window_is_what_was_drawn_bit_for_bit() {
    let server = Xvfb::start();
    for (driver, library) in WAYS {
        let size = [320, 200];
        let window = X11Window::open(&server, library, size);
        let stage = WindowStage::new(driver, window.clone());
        let offered = stage.surface.present_modes(&stage.device).unwrap();
        let expected = modes(driver);
        assert!(
            offered.len() == expected.len() && expected.iter().all(|mode| offered.contains(mode)),
            "{driver:?}, {library:?}: {offered:?}"
        );
        let mut painter = Painter::new(&stage.device, size);
        for &mode in expected {
            let options = SwapchainOptions { mode, ..Default::default() };
            let mut swapchain = stage.swapchain(&options);
            for seed in 0..8 {
                let image = painter.expected(seed);
                let presented = show_surely(&mut swapchain, &painter.target, size);
                assert_eq!((presented.size, presented.id.0), (size, u64::from(seed) + 1));
                await_image(&image, || window.pixels(size));
            }
            assert_eq!((swapchain.mode(), swapchain.fallback()), (mode, None));
            assert_eq!(swapchain.replaced(), 0, "{driver:?}, {mode}");
        }
        drop(painter);
        stage.end();
    }
}
