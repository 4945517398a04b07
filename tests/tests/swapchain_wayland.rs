//! Pictures in windows of a Wayland compositor without a screen, under validation.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

#[path = "swapchain/stage.rs"]
mod stage;
#[path = "swapchain/wayland_window.rs"]
mod wayland_window;

use std::time::{Duration, Instant};

use gpu::{NotShown, PresentMode, Shown, SwapchainOptions};
use stage::{Painter, Stage};
use tests::Driver;
use tests::weston::Weston;
use wayland_window::WaylandWindow;

#[test]
fn a_window_on_wayland_takes_pictures_in_every_mode() {
    let compositor = Weston::start();
    let window = WaylandWindow::open(&compositor);
    let stage = Stage::new(Driver::Lavapipe, window.clone());
    let offered = stage.surface.present_modes(&stage.device).unwrap();
    eprintln!("{offered:?}");
    for mode in offered {
        let options = SwapchainOptions { mode, ..Default::default() };
        let mut swapchain = stage.swapchain(&options);
        let mut painter = Painter::new(&stage.device, [320, 200]);
        let began = Instant::now();
        for frame in 0..60 {
            window.answer();
            painter.paint(frame, None);
            let t = Instant::now();
            let shown = swapchain.show(&painter.target, [320, 200]).unwrap();
            eprintln!("{mode} {frame} {:?} {shown:?}", t.elapsed());
        }
        eprintln!("{mode}: {:?}", began.elapsed());
    }
    stage.end();
}
