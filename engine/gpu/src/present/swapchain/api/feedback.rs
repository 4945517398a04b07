//! The feedback of the presentation engine on presented frames. It affects no decision.

use std::time::Duration;

use ash::vk;

use super::super::Swapchain;
use super::super::outcome::PresentId;
use crate::core::error::{Called, Error};

/// The times of one presented frame, on the clock of the display (`CLOCK_MONOTONIC` on Linux).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PresentTiming {
    /// The number of the presented frame.
    pub id: PresentId,
    /// The time at which the frame was first on the screen, in nanoseconds.
    pub shown_ns: u64,
    /// The earliest time at which the frame could have been shown, in nanoseconds.
    pub earliest_ns: u64,
    /// The time between the frame being ready and the earliest time, in nanoseconds.
    pub margin_ns: u64,
}

/// The number of timings requested at once; further ones come with the next call.
const TIMINGS: usize = 16;

impl Swapchain {
    /// Returns the newest frame known to be, or to have been, on the screen. Never waits. Returns
    /// `None` if no frame of the present swapchain has been seen yet, or if the device lacks
    /// [`crate::OptionalFeature::PresentWait`]. Called at least once per frame, it steps from id to
    /// id; it skips frames that are never shown.
    ///
    /// # Errors
    /// A failed call.
    pub fn newest_shown(&mut self) -> Result<Option<PresentId>, Error> {
        while self.screen.shown_until < self.screen.newest {
            let next = PresentId(self.screen.shown_until.max(self.screen.before_chain).0 + 1);
            if !self.wait_until_shown(next, Duration::ZERO)? {
                break;
            }
        }
        Ok(Some(self.screen.shown_until).filter(|shown| *shown > self.screen.before_chain))
    }

    /// Waits until the frame `id` is on the screen, for at most `bound` (and at most a minute), and
    /// returns true if it is. Returns false at once for an id that was never presented, for an id
    /// of a swapchain that was replaced since, and without [`crate::OptionalFeature::PresentWait`].
    ///
    /// # Errors
    /// A failed call.
    pub fn wait_until_shown(&mut self, id: PresentId, bound: Duration) -> Result<bool, Error> {
        let screen = &mut self.screen;
        let (Some(functions), Some(chain)) =
            (&screen.device.extensions().present_wait, screen.idle_chain())
        else {
            return Ok(false);
        };
        if id <= screen.before_chain || id > screen.newest {
            return Ok(false);
        }
        const MOST_NS: u64 = 60_000_000_000;
        let bound_ns = u64::try_from(bound.as_nanos()).unwrap_or(MOST_NS).min(MOST_NS);
        // SAFETY: an id that was presented to this chain, which is not used concurrently.
        match unsafe { functions.wait_for_present(chain.raw, id.0, bound_ns) } {
            Ok(()) => {
                screen.shown_until = screen.shown_until.max(id);
                Ok(true)
            }
            // A changed window shows no frame that was presented before.
            Err(
                vk::Result::TIMEOUT
                | vk::Result::ERROR_OUT_OF_DATE_KHR
                | vk::Result::ERROR_SURFACE_LOST_KHR,
            ) => Ok(false),
            Err(code) => {
                let failed = Err(code).called("vkWaitForPresentKHR");
                failed.inspect_err(|error| screen.device.note_loss(error))
            }
        }
    }

    /// Passes the timings that arrived since the last call to `each`, oldest first. There are never
    /// any without [`crate::OptionalFeature::DisplayTiming`].
    ///
    /// # Errors
    /// A failed call.
    pub fn timings(&mut self, mut each: impl FnMut(PresentTiming)) -> Result<(), Error> {
        let screen = &self.screen;
        let (Some(functions), Some(chain)) =
            (&screen.device.extensions().display_timing, screen.idle_chain())
        else {
            return Ok(());
        };
        let mut timings = [vk::PastPresentationTimingGOOGLE::default(); TIMINGS];
        let mut count = TIMINGS as u32;
        // SAFETY: room for `count` timings of a live chain.
        let code = unsafe {
            (functions.fp().get_past_presentation_timing_google)(
                functions.device(),
                chain.raw,
                &raw mut count,
                timings.as_mut_ptr(),
            )
        };
        match code {
            vk::Result::SUCCESS | vk::Result::INCOMPLETE => {}
            vk::Result::ERROR_OUT_OF_DATE_KHR | vk::Result::ERROR_SURFACE_LOST_KHR => return Ok(()),
            code => return Err(code).called("vkGetPastPresentationTimingGOOGLE"),
        }
        for timing in timings.iter().take(count as usize) {
            each(PresentTiming {
                id: widened(timing.present_id, screen.newest),
                shown_ns: timing.actual_present_time,
                earliest_ns: timing.earliest_present_time,
                margin_ns: timing.present_margin,
            });
        }
        Ok(())
    }

    /// Returns the duration of a refresh of the screen; `None` if it is unknown, for example
    /// without [`crate::OptionalFeature::DisplayTiming`].
    ///
    /// # Errors
    /// A failed call.
    pub fn refresh_duration(&self) -> Result<Option<Duration>, Error> {
        let screen = &self.screen;
        let (Some(functions), Some(chain)) =
            (&screen.device.extensions().display_timing, screen.idle_chain())
        else {
            return Ok(None);
        };
        // SAFETY: a live chain.
        match unsafe { functions.get_refresh_cycle_duration(chain.raw) } {
            Ok(cycle) => {
                Ok(Some(Duration::from_nanos(cycle.refresh_duration)).filter(|d| !d.is_zero()))
            }
            Err(vk::Result::ERROR_SURFACE_LOST_KHR) => Ok(None),
            Err(code) => Err(code).called("vkGetRefreshCycleDurationGOOGLE"),
        }
    }
}

/// Returns the full id for the 32 bits that the extension keeps: the newest id up to `newest` with
/// these low bits.
fn widened(low: u32, newest: PresentId) -> PresentId {
    let behind = (newest.0 as u32).wrapping_sub(low);
    PresentId(newest.0.saturating_sub(u64::from(behind)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_come_back_whole() {
        for newest in [1, 17, u64::from(u32::MAX), (1 << 32) + 2, (5 << 32) + 7] {
            for behind in 0..newest.min(20) {
                let id = PresentId(newest - behind);
                assert_eq!(widened(id.0 as u32, PresentId(newest)), id);
            }
        }
    }
}
