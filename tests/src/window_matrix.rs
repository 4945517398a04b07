//! The tested window libraries, and their present modes.

use crate::Driver;
use gpu::PresentMode;

use crate::x11_window::Library;

/// Pairs of a driver and a window library that it supports.
pub const WAYS: [(Driver, Library); 4] = [
    (Driver::Lavapipe, Library::Xcb),
    (Driver::Lavapipe, Library::Xlib),
    (Driver::SwiftShader, Library::Xcb),
    (Driver::SwiftShader, Library::Xlib),
];

/// The pairs that can create thousands of swapchains. SwiftShader frees the shared memory of
/// replaced swapchains only when its process ends, and crashes if none is left: a machine has 4,096
/// pieces. Tests that create a thousand swapchains with SwiftShader are therefore separate
/// programs.
pub const LASTING_WAYS: &[(Driver, Library)] = WAYS.split_at(3).0;

/// Returns the present modes that a driver has under Xvfb.
pub fn modes(driver: Driver) -> &'static [PresentMode] {
    match driver {
        Driver::Lavapipe => &PresentMode::ALL,
        Driver::SwiftShader => &[PresentMode::Fifo, PresentMode::Mailbox],
    }
}
