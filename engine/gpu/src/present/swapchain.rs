//! Frames in a window, in every state of the window. The caller decides when to show a frame.
//!
//! The waits in [`Swapchain::acquire`] and [`WindowImage::show`]:
//!
//! - The CPU waits for the tick of the present that used this slot N frames ago, then for an image.
//!   Both waits have the bound [`SwapchainOptions::acquire_bound`] and end as
//!   [`PresentSkipped::Hidden`].
//! - The GPU's copy to the image waits for the *acquire semaphore*, which means that the screen no
//!   longer reads the image. There is one per frame in flight: when its slot is used again, the
//!   submit that waited for the semaphore is over, and it may be used by another acquire.
//! - The presentation engine waits for the image's *drawn semaphore*. There is one per image: when
//!   the image is acquired again, the present that waited for the semaphore is over.
//! - If a driver waits inside the present itself, as for a hidden window, another thread makes this
//!   call ([`presenter`]).
//!
//! A frame is rendered and submitted before its image is acquired, so the GPU draws while the CPU
//! waits for the screen. So a frame in a window is recorded in the same way as a frame without one.
//!
//! A swapchain that no longer fits is replaced with `oldSwapchain`. The old one is passed to
//! [`retired::RetiredSwapchains`], which never waits. `SUBOPTIMAL` alone does not replace a
//! swapchain, because some drivers return it forever. It only makes the engine compare sizes.

mod api;
mod images;
mod options;
mod outcome;
mod plan;
mod presenter;
mod retired;
mod state;
mod teardown;

use std::time::{Duration, Instant};

use crate::core::device::Device;
use crate::core::error::Error;
use crate::present::present_mode::{Fallback, PresentMode};
use crate::present::surface::Surface;
use crate::record::frames::{Frame, FrameRing};
use crate::record::target::Target;

pub use api::feedback::PresentTiming;
pub use options::SwapchainOptions;
pub use outcome::{PresentId, PresentResult, PresentSkipped, Presented};
use state::SwapchainState;

/// A window that shows frames.
pub struct Swapchain {
    ring: FrameRing,
    screen: SwapchainState,
}

/// The outcome of acquiring an image of the window.
pub enum Acquired<'a> {
    /// An image, to be shown. If it is dropped, the next call returns it.
    Image(WindowImage<'a>),
    /// No image, with the reason.
    Not(PresentSkipped),
}

/// An acquired image of the window that waits for a frame.
pub struct WindowImage<'a> {
    frame: Frame<'a>,
    screen: &'a mut SwapchainState,
    slot_wait: Duration,
    acquire_wait: Duration,
}

impl Swapchain {
    /// Creates a swapchain that shows frames of `device` in the window of `surface`. The first
    /// image is acquired later, so a window without a pixel is not an error.
    ///
    /// # Errors
    /// [`Error::Foreign`] for a surface of another instance; [`Error::CannotPresent`] for a device
    /// that cannot show frames in this window; a failed call.
    pub fn new(
        device: &Device,
        surface: &Surface,
        options: &SwapchainOptions,
    ) -> Result<Self, Error> {
        let ring = FrameRing::new(device, options.frames_in_flight)?;
        let screen = SwapchainState::new(device, surface, options)?;
        Ok(Self { ring, screen })
    }

    /// Returns true if a frame may begin. Call this before each frame: a hidden window may hold
    /// back the present of the last frame and with it the queue, so that nothing can be submitted.
    /// Waits for at most [`SwapchainOptions::acquire_bound`].
    ///
    /// # Errors
    /// Errors that are not a [`PresentSkipped`]; the others are returned by the next frame.
    pub fn is_ready(&mut self) -> Result<bool, Error> {
        match self.screen.is_ready() {
            Ok(is_ready) => Ok(is_ready),
            Err(error) => self.screen.settle(error).map(|_| true),
        }
    }

    /// Acquires an image of the window. `window_size` is the size of the window in pixels as the
    /// caller knows it. Call this after the frame is submitted, because it waits for the screen.
    ///
    /// # Errors
    /// Errors that are not a [`PresentSkipped`]: out of memory, a failed call.
    pub fn acquire(&mut self, window_size: [u32; 2]) -> Result<Acquired<'_>, Error> {
        let began = Instant::now();
        match self.is_slot_ready() {
            Ok(true) => {}
            Ok(false) => return Ok(Acquired::Not(PresentSkipped::Hidden)),
            Err(error) => return Ok(Acquired::Not(self.screen.settle(error)?)),
        }
        let slot_wait = began.elapsed();
        match self.screen.acquire(self.ring.next_slot(), window_size) {
            Ok(None) => {}
            Ok(Some(not_shown)) => return Ok(Acquired::Not(not_shown)),
            Err(error) => return Ok(Acquired::Not(self.screen.settle(error)?)),
        }
        let acquire_wait = began.elapsed().saturating_sub(slot_wait);
        match self.ring.begin() {
            Ok(frame) => {
                let screen = &mut self.screen;
                Ok(Acquired::Image(WindowImage { frame, screen, slot_wait, acquire_wait }))
            }
            Err(error) => Ok(Acquired::Not(self.screen.settle(error)?)),
        }
    }

    /// Shows the frame of `target` in a window of `window_size` pixels, with [`Swapchain::acquire`]
    /// and [`WindowImage::show`]. The frame is scaled if its size differs, and gets black borders
    /// if its shape differs.
    ///
    /// # Errors
    /// The errors of [`Swapchain::acquire`] and [`WindowImage::show`].
    pub fn show(&mut self, target: &Target, window_size: [u32; 2]) -> Result<PresentResult, Error> {
        // Checked before the wait for an image.
        self.screen.device.check(target, "a window (`Swapchain`)")?;
        match self.acquire(window_size)? {
            Acquired::Image(image) => image.show(target),
            Acquired::Not(not_shown) => Ok(PresentResult::Not(not_shown)),
        }
    }

    /// Returns true if the call of the last present returned, and the frame that used the slot
    /// before is over.
    fn is_slot_ready(&mut self) -> Result<bool, Error> {
        let bound = self.screen.options.acquire_bound;
        Ok(self.screen.is_ready()? && self.ring.is_ready_within(bound)?)
    }

    /// Changes the present mode from the next frame on.
    pub fn set_mode(&mut self, mode: PresentMode) {
        self.screen.set_mode(mode);
    }

    /// Changes the number of frames in flight to the window.
    ///
    /// # Errors
    /// A failed call; nothing is changed then.
    pub fn set_frames_in_flight(&mut self, frames_in_flight: usize) -> Result<(), Error> {
        if frames_in_flight.max(1) != self.ring.frames_in_flight() {
            let ring = FrameRing::new(&self.screen.device, frames_in_flight)?;
            self.screen.set_slots(ring.frames_in_flight())?;
            self.ring = ring;
        }
        Ok(())
    }

    /// Returns the number of frames in flight to the window.
    pub fn frames_in_flight(&self) -> usize {
        self.ring.frames_in_flight()
    }

    /// Returns the present mode in use; before the first image, the requested mode.
    pub fn mode(&self) -> PresentMode {
        self.screen.chain.as_ref().map_or(self.screen.options.mode, |chain| chain.mode)
    }

    /// Returns the requested present mode and its replacement, if the window does not support the
    /// requested mode.
    pub fn fallback(&self) -> Option<Fallback> {
        self.screen.fallback
    }

    /// Returns the size of the window's images in pixels; `None` before the first image.
    pub fn size(&self) -> Option<[u32; 2]> {
        self.screen.chain.as_ref().map(|chain| chain.size)
    }

    /// Returns the format and the colour space of the window's images as text; `None` before the
    /// first image.
    pub fn format(&self) -> Option<String> {
        let chain = self.screen.chain.as_ref()?;
        Some(format!("{:?} in {:?}", chain.format, plan::COLOUR_SPACE))
    }

    /// Returns the number of images of the window.
    pub fn image_count(&self) -> usize {
        self.screen.chain.as_ref().map_or(0, |chain| chain.images.len())
    }

    /// Returns the number of times that the window's images were replaced.
    pub fn replaced(&self) -> u64 {
        self.screen.number.0.saturating_sub(1)
    }

    /// Returns the number of replaced swapchains that the presentation engine may still use. The
    /// number is bounded.
    pub fn retiring(&self) -> usize {
        self.screen.old.len()
    }

    /// Returns the newest frame passed to the presentation engine.
    pub fn newest_presented(&self) -> Option<PresentId> {
        Some(self.screen.newest).filter(|id| *id > PresentId::default())
    }
}

impl WindowImage<'_> {
    /// Returns the size of the image in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.screen.chain.as_ref().map_or([0, 0], |chain| chain.size)
    }

    /// Copies the frame of `target` to the image, byte for byte if their sizes are equal, and
    /// presents it. A frame of another shape keeps its proportions and gets black borders. A frame
    /// that waits for a [`crate::Timeline`] must be presented after the signal
    /// (VUID-vkQueuePresentKHR-pWaitSemaphores-03268).
    ///
    /// # Errors
    /// [`Error::Foreign`] for a target of another device; [`Error::WrongCommands`] for a target
    /// whose frame was not [submitted](Target::submitted); errors that are not a
    /// [`PresentSkipped`].
    pub fn show(self, target: &Target) -> Result<PresentResult, Error> {
        let Self { frame, screen, slot_wait, acquire_wait } = self;
        match screen.show(frame, target, slot_wait, acquire_wait) {
            Ok(presented) => Ok(presented),
            Err(error) => Ok(PresentResult::Not(screen.settle(error)?)),
        }
    }
}
