//! The outcomes of presenting a frame, each with a name.

use std::time::Duration;

use crate::core::tick::Tick;

/// The number of a frame given to the presentation engine: from 1 in the order of presents, for
/// the whole life of a swapchain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct PresentId(pub u64);

/// A frame that is on its way to the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Presented {
    /// The number of the frame, with which its timing is reported.
    pub id: PresentId,
    /// The tick at whose end it is drawn; it is on the screen later.
    pub tick: Tick,
    /// The size of the window's image in pixels; a frame of another size was scaled to fit in it.
    pub size: [u32; 2],
    /// The time that the CPU first waited for the GPU: for the frame that used the same slot
    /// before.
    pub slot_wait: Duration,
    /// The time that it then waited for an image of the window.
    pub acquire_wait: Duration,
    /// The time that the CPU was in the call that presents; some drivers wait for the screen there.
    pub present_wait: Duration,
}

/// The reason why a frame is not shown. Nothing is lost: go on with the next frame, as each
/// variant says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PresentSkipped {
    /// A window without a pixel: it is minimised, or was made as small. Show nothing until its size
    /// changes.
    NoArea,
    /// No image was free within [`crate::SwapchainOptions::acquire_bound`], or the frame before
    /// this one is still held back: the window is hidden, or the screen slow. Try again, not at
    /// once.
    Hidden,
    /// The window changed under the frame. The next one is made for what it is then.
    OutOfDate,
    /// The surface was lost, the window is still there and has a new one. Go on.
    SurfaceLost,
    /// The window is gone, or the connection to it. Open another one, or end.
    WindowGone,
    /// The device was lost. Create all of it again, or end.
    DeviceLost,
}

impl PresentSkipped {
    /// Returns a sentence for the person in front of the machine.
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
    /// A frame on its way to the screen.
    Presented(Presented),
    /// A frame that is not shown.
    Not(PresentSkipped),
}

impl PresentResult {
    /// Returns the present, if the frame is on its way.
    pub fn presented(self) -> Option<Presented> {
        match self {
            PresentResult::Presented(presented) => Some(presented),
            PresentResult::Not(_) => None,
        }
    }
}
