//! The named outcomes of presenting a frame.

use std::time::Duration;

use crate::core::tick::Tick;

/// The number of a frame passed to the presentation engine, counted from 1 in the order of presents
/// over the lifetime of a swapchain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct PresentId(pub u64);

/// A frame in flight to the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Presented {
    /// The number of the frame, which is also in its timing.
    pub id: PresentId,
    /// The tick after which the frame is drawn; it is on the screen later.
    pub tick: Tick,
    /// The size of the window's image in pixels; a frame of another size was scaled to fit in it.
    pub size: [u32; 2],
    /// The time that the CPU waited for the frame that used the same slot before.
    pub slot_wait: Duration,
    /// The time that the CPU then waited for an image of the window.
    pub acquire_wait: Duration,
    /// The time that the CPU spent in the present call, in which some drivers wait for the screen.
    pub present_wait: Duration,
}

/// The reason why a frame is not shown. No state is lost: continue with the next frame as each
/// variant says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PresentSkipped {
    /// The window has no pixels: it is minimised or has a size of 0. Show nothing until its size
    /// changes.
    NoArea,
    /// No image was free within [`crate::SwapchainOptions::acquire_bound`], or the frame before
    /// this one is still held back: the window is hidden, or the screen is slow. Try again after a
    /// while.
    Hidden,
    /// The window changed during the frame. The next frame fits the changed window.
    OutOfDate,
    /// The surface was lost, but the window still exists and has a new surface. Continue.
    SurfaceLost,
    /// The window or its connection is closed. Open another window, or end the program.
    WindowGone,
    /// The device is lost. Create all objects again, or end the program.
    DeviceLost,
}

impl PresentSkipped {
    /// Returns a sentence for the user of the machine.
    pub fn reason(self) -> &'static str {
        match self {
            PresentSkipped::NoArea => "the window has no pixel to show a frame in",
            PresentSkipped::Hidden => {
                "the window takes no frames for now: it is hidden, or the screen slow"
            }
            PresentSkipped::OutOfDate => {
                "the window has changed, the next frame is made for its new size"
            }
            PresentSkipped::SurfaceLost => "the window's surface was lost and created again",
            PresentSkipped::WindowGone => "the window is gone; open another one",
            PresentSkipped::DeviceLost => {
                "the driver gave up on the GPU; restart the program, update the driver if it comes back"
            }
        }
    }
}

impl std::fmt::Display for PresentSkipped {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.reason())
    }
}

/// The outcome of showing a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PresentResult {
    /// The frame is in flight to the screen.
    Presented(Presented),
    /// The frame is not shown.
    Not(PresentSkipped),
}

impl PresentResult {
    /// Returns the presented frame; `None` if it is not shown.
    pub fn presented(self) -> Option<Presented> {
        match self {
            PresentResult::Presented(presented) => Some(presented),
            PresentResult::Not(_) => None,
        }
    }
}
