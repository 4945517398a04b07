//! The options of a swapchain.

use std::time::Duration;

use crate::present::present_mode::PresentMode;

/// The options of a [`Swapchain`](crate::Swapchain).
#[derive(Debug, Clone)]
pub struct SwapchainOptions {
    /// The requested present mode. If the window does not support it, the nearest mode is used
    /// ([`PresentMode::nearest`]), which is logged and [reported](crate::Swapchain::fallback).
    pub mode: PresentMode,
    /// The number of frames in flight to the window; 0 counts as 1.
    pub frames_in_flight: usize,
    /// The longest wait for an image of the window, at most a minute. A hidden window may have no
    /// image for hours.
    pub acquire_bound: Duration,
}

impl Default for SwapchainOptions {
    fn default() -> Self {
        // Longer than any refresh, but short enough for a loop that must react to keys.
        let acquire_bound = Duration::from_millis(100);
        Self { mode: PresentMode::Fifo, frames_in_flight: 2, acquire_bound }
    }
}
