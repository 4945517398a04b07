//! A window at rest: its frame loop creates no Vulkan object and allocates no memory.

use gpu::{PresentMode, SwapchainOptions};
use tests::Driver;
use tests::counting::allocations;
use tests::fault_injection::{CALLS_THAT_MAKE, CALLS_THAT_SHOW, FaultInjection, calls};
use tests::window_fixture::{Painter, WindowStage};
use tests::x11_window::{Library, X11Window};
use tests::xvfb::Xvfb;

#[test]
fn a_window_at_rest_makes_nothing_and_allocates_nothing() {
    let server = Xvfb::start();
    for (driver, modes) in [
        (Driver::Lavapipe, &PresentMode::ALL[..]),
        (Driver::SwiftShader, &[PresentMode::Fifo, PresentMode::Mailbox]),
    ] {
        for &mode in modes {
            let size = [200, 100];
            let window = X11Window::open(&server, Library::Xcb, size);
            let stage = WindowStage::with_entry(FaultInjection::default().entry(), driver, window);
            let mut painter = Painter::new(&stage.device, size);
            let mut swapchain = stage.swapchain(&SwapchainOptions { mode, ..Default::default() });
            let made = || CALLS_THAT_MAKE.iter().chain(CALLS_THAT_SHOW).map(|c| calls(c)).sum();
            // The list includes begin, end and reset of command buffers, which every frame calls.
            let every_frame: [&std::ffi::CStr; 3] =
                [c"vkBeginCommandBuffer", c"vkEndCommandBuffer", c"vkResetCommandPool"];
            let made = || -> usize {
                let all: usize = made();
                all - every_frame.iter().map(|c| calls(c)).sum::<usize>()
            };
            let mut allocated = Vec::with_capacity(100);
            let mut after_a_while = 0;
            for frame in 0..100 {
                painter.paint(frame, None);
                let before = allocations();
                let shown = swapchain.show(&painter.target, size).unwrap();
                allocated.push(allocations() - before);
                assert!(shown.presented().is_some());
                if frame == 20 {
                    after_a_while = made();
                }
            }
            assert_eq!(made(), after_a_while, "{driver:?} {mode}: objects were made");
            let late: u64 = allocated[20..].iter().sum();
            assert_eq!(late, 0, "{driver:?} {mode}: {allocated:?}");
            drop((swapchain, painter));
            stage.end();
        }
    }
}
