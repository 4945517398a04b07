//! The options of a swapchain.

use std::time::Duration;

use crate::present::present_mode::PresentMode;

/// The options of a [`Swapchain`](crate::Swapchain).
#[derive(Debug, Clone)]
pub struct SwapchainOptions {
    /// The present mode wanted. If the window lacks it, it falls back to the nearest
    /// ([`PresentMode::nearest`]), which is logged and [reported](crate::Swapchain::fallback).
    pub mode: PresentMode,
    /// The number of frames on their way to the window at once; 0 counts as 1.
    pub frames_in_flight: usize,
    /// The longest wait for an image of the window, a minute at most. A hidden window may have none
    /// for hours.
    pub acquire_bound: Duration,
}

impl Default for SwapchainOptions {
    fn default() -> Self {
        // Longer than any refresh, short enough for a loop that has keys to answer.
        let acquire_bound = Duration::from_millis(100);
        Self { mode: PresentMode::Fifo, frames_in_flight: 2, acquire_bound }
    }
}
