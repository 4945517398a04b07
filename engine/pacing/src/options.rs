//! The user's options and the caller's description of the swapchain, with their checks.

use std::time::Duration;

use thiserror::Error;

use crate::time::ns;

/// The most frames that may be queued.
pub const MAX_QUEUE_LIMIT: u32 = 16;
/// The most images that a swapchain may have.
pub const MAX_IMAGES: u32 = 32;
/// The range of frame limits, in frames per second.
pub const FRAME_LIMIT_HZ: [f64; 2] = [0.1, 10_000.0];
/// The range of refresh periods: 4 kHz and 1 Hz.
pub const REFRESH_PERIOD: [Duration; 2] = [Duration::from_micros(250), Duration::from_secs(1)];
/// The range of intervals between frames in a hidden window.
pub const HIDDEN_INTERVAL: [Duration; 2] = [Duration::from_millis(10), Duration::from_secs(10)];

/// The options of the user.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PacerOptions {
    /// The most frames between their start and their present time, 1 to [`MAX_QUEUE_LIMIT`]. 1
    /// gives the lowest latency and needs CPU and GPU work together to stay within a refresh. 2
    /// lets CPU and GPU work at the same time.
    pub queue_limit: u32,
    /// The limit of frames per second, see [`FRAME_LIMIT_HZ`].
    pub frame_limit_hz: Option<f64>,
    /// The interval between the starts of frames in a hidden window, see [`HIDDEN_INTERVAL`].
    pub hidden_interval: Duration,
}

impl Default for PacerOptions {
    fn default() -> Self {
        Self { queue_limit: 2, frame_limit_hz: None, hidden_interval: Duration::from_millis(250) }
    }
}

impl PacerOptions {
    pub(crate) fn check(&self) -> Result<(), PacingError> {
        if !(1..=MAX_QUEUE_LIMIT).contains(&self.queue_limit) {
            return Err(PacingError::QueueLimit(self.queue_limit));
        }
        let [low, high] = FRAME_LIMIT_HZ;
        if let Some(hz) = self.frame_limit_hz
            && !(low..=high).contains(&hz)
        {
            return Err(PacingError::FrameLimit(hz));
        }
        let [short, long] = HIDDEN_INTERVAL;
        if !(short..=long).contains(&self.hidden_interval) {
            return Err(PacingError::HiddenInterval(self.hidden_interval));
        }
        Ok(())
    }
}

/// The order in which images reach the screen: the present modes of Vulkan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PresentationMode {
    /// Every image in order, one per refresh.
    Fifo,
    /// Every image in order, one per refresh; a late image is shown at once and tears.
    FifoRelaxed,
    /// The newest image at each refresh; older images are never shown.
    Mailbox,
    /// Every image at once, with tearing.
    Immediate,
}

/// The caller's knowledge of the display. The pacer learns the rest where possible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refresh {
    /// Nothing is known: the period is learnt from present times or acquires.
    Unknown,
    /// An approximate period, from the window system or `refreshDuration`. It may be wrong.
    About(Duration),
    /// A display with a variable refresh rate, which waits for frames. Each refresh follows the
    /// previous one after at least the shorter and at most the longer period.
    Variable {
        /// The period of the highest rate.
        min_period: Duration,
        /// The period of the lowest rate.
        max_period: Duration,
    },
}

/// The source of present times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PresentReports {
    /// Reports by [`Feedback::Shown`](crate::Feedback::Shown) (present wait, display timing).
    Times,
    /// No reports. In [`PresentationMode::Fifo`] the pacer then learns the phase of the display
    /// from acquires that had to wait. It sometimes fills the queue for that purpose, but only
    /// after it has established that acquires wait for the display and not for the GPU. This
    /// requires reports of finished GPU work. If the display does not hold frames back, its
    /// refreshes stay unknown.
    Missing,
}

/// The swapchain in use. A new one requires a new call of
/// [`Pacer::present_through`](crate::Pacer::present_through).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Presentation {
    /// The swapchain's present mode.
    pub mode: PresentationMode,
    /// The actual number of images, 1 to [`MAX_IMAGES`].
    pub images: u32,
    /// The knowledge of the display.
    pub refresh: Refresh,
    /// The reports that the caller will deliver.
    pub reports: PresentReports,
}

impl Presentation {
    pub(crate) fn check(&self) -> Result<(), PacingError> {
        if !(1..=MAX_IMAGES).contains(&self.images) {
            return Err(PacingError::Images(self.images));
        }
        let [shortest, longest] = REFRESH_PERIOD;
        let check = |period: Duration| {
            let sane = (shortest..=longest).contains(&period);
            if sane { Ok(()) } else { Err(PacingError::RefreshPeriod(period)) }
        };
        match self.refresh {
            Refresh::Unknown => Ok(()),
            Refresh::About(period) => check(period),
            Refresh::Variable { min_period, max_period } => {
                check(min_period)?;
                check(max_period)?;
                if min_period > max_period {
                    return Err(PacingError::RefreshRange { min_period, max_period });
                }
                Ok(())
            }
        }
    }

    /// Returns the shortest period of a display that waits for frames; `None` for images that tear,
    /// since they never wait.
    pub(crate) fn variable_ns(&self) -> Option<f64> {
        match self.refresh {
            Refresh::Variable { min_period, .. } if self.mode != PresentationMode::Immediate => {
                Some(ns(min_period))
            }
            _ => None,
        }
    }

    /// Returns true if images are shown at refreshes that are independent of frames.
    pub(crate) fn has_grid(&self) -> bool {
        self.mode != PresentationMode::Immediate && self.variable_ns().is_none()
    }

    pub(crate) fn hint_ns(&self) -> Option<f64> {
        if let Refresh::About(period) = self.refresh { Some(ns(period)) } else { None }
    }

    pub(crate) fn in_order(&self) -> bool {
        matches!(self.mode, PresentationMode::Fifo | PresentationMode::FifoRelaxed)
    }
}

/// An option or property that is out of range. A call that returns it has changed nothing.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PacingError {
    /// A queue limit out of range, see [`PacerOptions::queue_limit`].
    #[error("{0} queued frames: choose 1 to {MAX_QUEUE_LIMIT}")]
    QueueLimit(u32),
    /// A frame limit out of range, see [`PacerOptions::frame_limit_hz`].
    #[error("a limit of {0} frames per second: choose {low} to {high}, or none",
        low = FRAME_LIMIT_HZ[0], high = FRAME_LIMIT_HZ[1])]
    FrameLimit(f64),
    /// An interval out of range, see [`PacerOptions::hidden_interval`].
    #[error("a frame every {0:?} while hidden: choose {low:?} to {high:?}",
        low = HIDDEN_INTERVAL[0], high = HIDDEN_INTERVAL[1])]
    HiddenInterval(Duration),
    /// A number of images out of range, see [`Presentation::images`].
    #[error("a swapchain of {0} images: it must have 1 to {MAX_IMAGES}")]
    Images(u32),
    /// A refresh period out of range, see [`Refresh`].
    #[error("a refresh period of {0:?}: it must be {low:?} to {high:?}; say Unknown if unsure",
        low = REFRESH_PERIOD[0], high = REFRESH_PERIOD[1])]
    RefreshPeriod(Duration),
    /// A range of refresh periods out of range, see [`Refresh::Variable`].
    #[error("refresh periods of {min_period:?} to {max_period:?}: the first must be the shorter")]
    RefreshRange {
        /// The shorter period as given.
        min_period: Duration,
        /// The longer period as given.
        max_period: Duration,
    },
    /// A number of frames out of range, see [`FrameStatistics::new`](crate::FrameStatistics::new).
    #[error("statistics over {0} frames: choose 1 to {max}", max = crate::MAX_STATISTICS_FRAMES)]
    StatisticsFrames(usize),
}
