//! What a user may choose, and what a caller knows of the swapchain; both are checked.

use std::time::Duration;

use thiserror::Error;

use crate::time::ns;

/// Most frames that may be queued.
pub const MAX_QUEUE_LIMIT: u32 = 16;
/// Most images a swapchain may be said to have.
pub const MAX_IMAGES: u32 = 32;
/// Frame limits in frames per second lie between these.
pub const FRAME_LIMIT_HZ: [f64; 2] = [0.1, 10_000.0];
/// Refresh periods lie between these: 4 kHz and 1 Hz.
pub const REFRESH_PERIOD: [Duration; 2] = [Duration::from_micros(250), Duration::from_secs(1)];
/// Intervals of frames in a hidden window lie between these.
pub const HIDDEN_INTERVAL: [Duration; 2] = [Duration::from_millis(10), Duration::from_secs(10)];

/// What a user chooses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PacerOptions {
    /// At most this many frames are between their start and their showing, 1 to
    /// [`MAX_QUEUE_LIMIT`]. 1 is for the lowest latency and needs CPU and GPU together to stay
    /// within a refresh; 2 lets them work at the same time.
    pub queue_limit: u32,
    /// Frames per second, see [`FRAME_LIMIT_HZ`].
    pub frame_limit_hz: Option<f64>,
    /// Between the starts of frames that nobody seems to see, see [`HIDDEN_INTERVAL`].
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

/// How images get to the screen: the present modes of Vulkan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PresentationMode {
    /// In order, one a refresh.
    Fifo,
    /// In order, one a refresh; one that is late is shown at once and tears.
    FifoRelaxed,
    /// At each refresh the newest; older ones are never shown.
    Mailbox,
    /// At once; tears.
    Immediate,
}

/// What is known of the display beforehand. What is not known is learnt where it can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refresh {
    /// Nothing.
    Unknown,
    /// About this period, as the window system or `refreshDuration` tells. It may be wrong.
    About(Duration),
    /// The display waits for a frame: it refreshes no sooner than the shorter and no later than
    /// the longer period after the refresh before.
    Variable {
        /// Of the highest rate.
        min_period: Duration,
        /// Of the lowest rate.
        max_period: Duration,
    },
}

/// What tells when an image was shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PresentReports {
    /// [`Feedback::Shown`](crate::Feedback::Shown) will come (present wait, display timing).
    Times,
    /// Nothing does. In [`PresentationMode::Fifo`] the phase of the display is then learnt from
    /// acquires that had to wait, for which the pacer fills the queue now and then; but only after
    /// waits have shown that they are the display's and not the GPU's, which takes knowing when the
    /// GPU was finished. Where there is no display that holds frames back, all about it stays
    /// unknown.
    Missing,
}

/// The swapchain in use. A new one means a new
/// [`Pacer::present_through`](crate::Pacer::present_through).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Presentation {
    /// Its present mode.
    pub mode: PresentationMode,
    /// How many images it really has, 1 to [`MAX_IMAGES`].
    pub images: u32,
    /// What is known of the display.
    pub refresh: Refresh,
    /// What will be reported.
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

    /// Returns the shortest period of a display that waits for frames; an image that tears waits
    /// for none.
    pub(crate) fn variable_ns(&self) -> Option<f64> {
        match self.refresh {
            Refresh::Variable { min_period, .. } if self.mode != PresentationMode::Immediate => {
                Some(ns(min_period))
            }
            _ => None,
        }
    }

    /// Returns true if images are shown at refreshes that come whatever we do.
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

/// Choices that make no sense. Nothing changed where one is returned.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PacingError {
    /// See [`PacerOptions::queue_limit`].
    #[error("{0} queued frames: choose 1 to {MAX_QUEUE_LIMIT}")]
    QueueLimit(u32),
    /// See [`PacerOptions::frame_limit_hz`].
    #[error("a limit of {0} frames per second: choose {low} to {high}, or none",
        low = FRAME_LIMIT_HZ[0], high = FRAME_LIMIT_HZ[1])]
    FrameLimit(f64),
    /// See [`PacerOptions::hidden_interval`].
    #[error("a frame every {0:?} while hidden: choose {low:?} to {high:?}",
        low = HIDDEN_INTERVAL[0], high = HIDDEN_INTERVAL[1])]
    HiddenInterval(Duration),
    /// See [`Presentation::images`].
    #[error("a swapchain of {0} images: it must have 1 to {MAX_IMAGES}")]
    Images(u32),
    /// See [`Refresh`].
    #[error("a refresh period of {0:?}: it must be {low:?} to {high:?}; say Unknown if unsure",
        low = REFRESH_PERIOD[0], high = REFRESH_PERIOD[1])]
    RefreshPeriod(Duration),
    /// See [`Refresh::Variable`].
    #[error("refresh periods of {min_period:?} to {max_period:?}: the first must be the shorter")]
    RefreshRange {
        /// As given.
        min_period: Duration,
        /// As given.
        max_period: Duration,
    },
    /// See [`FrameStatistics::new`](crate::FrameStatistics::new).
    #[error("statistics over {0} frames: choose 1 to {max}", max = crate::MAX_STATISTICS_FRAMES)]
    StatisticsFrames(usize),
}
