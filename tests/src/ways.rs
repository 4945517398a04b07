//! The ways to a window that are tested, and the present modes that they have.

use crate::Driver;
use gpu::PresentMode;

use crate::x11_window::Library;

/// Each way to a window that the drivers have.
pub const WAYS: [(Driver, Library); 4] = [
    (Driver::Lavapipe, Library::Xcb),
    (Driver::Lavapipe, Library::Xlib),
    (Driver::SwiftShader, Library::Xcb),
    (Driver::SwiftShader, Library::Xlib),
];

/// Those for thousands of swapchains. Before its process ends, SwiftShader never lets go of the
/// shared memory of a swapchain that was replaced, and crashes where there is no more: a machine
/// has 4,096 pieces. So tests that make a thousand swapchains with it are in programs of their own.
pub const LASTING_WAYS: &[(Driver, Library)] = WAYS.split_at(3).0;

/// Returns the present modes that a driver has under Xvfb.
pub fn modes(driver: Driver) -> &'static [PresentMode] {
    match driver {
        Driver::Lavapipe => &PresentMode::ALL,
        Driver::SwiftShader => &[PresentMode::Fifo, PresentMode::Mailbox],
    }
}
