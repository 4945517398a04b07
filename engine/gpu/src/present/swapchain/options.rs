//! What a window is asked for.

use std::time::Duration;

use crate::present::present_mode::PresentMode;

/// How to make a [`Swapchain`](crate::Swapchain).
#[derive(Debug, Clone)]
pub struct SwapchainOptions {
    /// How pictures follow each other. What the window has not falls back to what comes nearest
    /// ([`PresentMode::nearest`]), which is logged and [told](crate::Swapchain::fallback).
    pub mode: PresentMode,
    /// Pictures on their way to the window at once; 0 counts as 1.
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
