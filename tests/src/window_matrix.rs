//! The tested window libraries, and their present modes.

use crate::Driver;
use gpu::PresentMode;

use crate::x11_window::Library;

/// Each driver with each window library that it supports.
pub const WAYS: [(Driver, Library); 4] = [
    (Driver::Lavapipe, Library::Xcb),
    (Driver::Lavapipe, Library::Xlib),
    (Driver::SwiftShader, Library::Xcb),
    (Driver::SwiftShader, Library::Xlib),
];

/// The ways that can have thousands of swapchains. Before its process ends, SwiftShader never frees
/// the shared memory of a replaced swapchain, and crashes if there is no more: a machine has 4,096
/// pieces. So tests that make a thousand swapchains with it are in programs of their own.
pub const LASTING_WAYS: &[(Driver, Library)] = WAYS.split_at(3).0;

/// Returns the present modes that a driver has under Xvfb.
pub fn modes(driver: Driver) -> &'static [PresentMode] {
    match driver {
        Driver::Lavapipe => &PresentMode::ALL,
        Driver::SwiftShader => &[PresentMode::Fifo, PresentMode::Mailbox],
    }
}
