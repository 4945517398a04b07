//! What can come of showing a picture in a window: each outcome has a name.

use std::time::Duration;

use crate::core::tick::Tick;

/// A picture given to the presentation engine. Numbered from 1 in the order of presents, for the
/// whole life of a swapchain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct PresentId(pub u64);

/// A picture that is on its way to the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Presented {
    /// Its number.
    pub id: PresentId,
    /// It is drawn when this tick is over; on the screen it is later.
    pub tick: Tick,
    /// The size of the window's image in pixels; a picture of another size was scaled to fit in it.
    pub size: [u32; 2],
    /// How long the CPU first waited for the GPU: for the picture that used the same slot before.
    pub slot_wait: Duration,
    /// How long it then waited for an image of the window.
    pub acquire_wait: Duration,
    /// How long the CPU was in the call that presents; some drivers wait for the screen there.
    pub present_wait: Duration,
}

/// Why a picture is not shown. Nothing is lost: go on with the next frame, as said at each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PresentSkipped {
    /// The window has no pixel: it is minimised, or was made as small. Show nothing until its size
    /// changes.
    NoArea,
    /// No image came free within [`crate::SwapchainOptions::acquire_bound`], or the picture before
    /// this one is still held back: the window is hidden, or the screen slow. Try again, not at
    /// once.
    Hidden,
    /// The window changed under the picture. The next one is made for what it is then.
    OutOfDate,
    /// The surface was lost, the window is still there and has a new one. Go on.
    SurfaceLost,
    /// The window is gone, or the connection to it. Open another one, or end.
    WindowGone,
    /// The device was lost. Make all of it anew, or end.
    DeviceLost,
}

impl PresentSkipped {
    /// Returns a sentence for the person in front of the machine.
    pub fn reason(self) -> &'static str {
        match self {
            PresentSkipped::NoArea => "the window has no pixel to show a picture in",
            PresentSkipped::Hidden => {
                "the window takes no pictures for now: it is hidden, or the screen slow"
            }
            PresentSkipped::OutOfDate => {
                "the window has changed, the next picture is made for its new size"
            }
            PresentSkipped::SurfaceLost => "the window's surface was lost and made anew",
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

/// What became of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// It is on its way to the screen.
    Presented(Presented),
    /// It is not shown.
    Not(PresentSkipped),
}

impl Shown {
    /// Returns the present, if the picture is on its way.
    pub fn presented(self) -> Option<Presented> {
        match self {
            Shown::Presented(presented) => Some(presented),
            Shown::Not(_) => None,
        }
    }
}
