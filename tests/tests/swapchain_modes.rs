//! A window with a thousand changes of its present mode and frames in flight.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use gpu::PresentMode;
use tests::display::Show;
use tests::window_fixture::{Random, WindowStage};
use tests::window_matrix::{LASTING_WAYS, modes};
use tests::x11_window::X11Window;
use tests::xvfb::Xvfb;

#[test]
fn modes_and_frames_in_flight_change_a_thousand_times() {
    let server = Xvfb::start();
    for &(driver, library) in LASTING_WAYS {
        let size = [160, 120];
        let window = X11Window::open(&server, library, size);
        let stage = WindowStage::new(driver, window.clone());
        let mut random = Random::new(11);
        let mut show = Show::new(&stage, &window, PresentMode::Fifo, size);
        for step in 0..1_000 {
            let mode = PresentMode::ALL[random.below(4) as usize];
            show.swapchain.set_mode(mode);
            show.swapchain.set_frames_in_flight(random.below(5) as usize).unwrap();
            if random.below(8) == 0 {
                // An image that is acquired and not shown is not lost.
                drop(show.swapchain.acquire(size).unwrap());
            }
            show.frame(step, size);
            let taken = mode.nearest(modes(driver));
            assert_eq!(show.swapchain.mode(), taken);
            assert_eq!(show.swapchain.fallback().is_some(), taken != mode);
            if step % 100 == 99 {
                show.check(step);
            }
        }
        assert!(show.presented > 900, "{}", show.presented);
        drop(show);
        stage.end();
    }
}
