//! The forecast for queued frames: the times at which the GPU is free and each frame is shown.
//!
//! It is computed anew from all known facts each time, so that a stall leaves no state behind.

use crate::estimate::Estimate;
use crate::frames::{Frames, Record};
use crate::options::{PresentReports, Presentation};
use crate::refresh_clock::RefreshClock;

/// The number of refreshes for which a frame without a report delays the next frames.
const PATIENCE_REFRESHES: f64 = 4.0;

/// The inputs of a forecast.
pub(crate) struct Knowledge<'a> {
    pub(crate) presentation: &'a Presentation,
    pub(crate) clock: &'a RefreshClock,
    pub(crate) gpu: &'a Estimate,
    /// The delay from the present time of a frame to its report.
    pub(crate) report: &'a Estimate,
    /// True if the caller reports finished ticks.
    pub(crate) sees_finishes: bool,
    /// The best known present time of the last frame that left the queue.
    pub(crate) last_left: f64,
    pub(crate) now: f64,
}

/// Expected times in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Forecast {
    /// The time at which the GPU has finished all submitted work.
    pub(crate) gpu_free: f64,
    /// The time at which the newest frame is shown.
    pub(crate) last_shown: f64,
    /// The time at which the oldest queued frame is shown.
    pub(crate) first_leaves: f64,
    /// The time at which an image is available for the next frame.
    pub(crate) image_free: f64,
}

impl Knowledge<'_> {
    /// Returns the forecast. `blocking` is the ordinal of the frame that must be shown before an
    /// image is available.
    pub(crate) fn forecast(&self, frames: &Frames, blocking: Option<u64>) -> Forecast {
        let mut forecast = Forecast {
            gpu_free: frames.newest_first().find_map(|(_, r)| r.finished).unwrap_or(0.0),
            last_shown: self.last_left,
            first_leaves: f64::INFINITY,
            image_free: 0.0,
        };
        for (_, record) in frames.queued() {
            let finish = self.finish(record, forecast.gpu_free);
            forecast.gpu_free = forecast.gpu_free.max(finish);
            forecast.last_shown = self.shown(record, finish, forecast.last_shown);
            forecast.first_leaves = forecast.first_leaves.min(forecast.last_shown);
            let blocks = record.ordinal.is_some() && record.ordinal == blocking;
            if blocks && self.presentation.in_order() {
                forecast.image_free = forecast.last_shown;
            }
        }
        forecast
    }

    /// Returns the time at which the GPU finishes a frame if it is free from `gpu_free` on.
    pub(crate) fn finish(&self, record: &Record, gpu_free: f64) -> f64 {
        if let Some(finished) = record.finished {
            return finished;
        }
        let begin = record.queued.unwrap_or(self.now).max(gpu_free);
        let finish = begin + self.gpu.expected();
        // If ticks are reported, a frame without a report is not finished.
        if self.sees_finishes { finish.max(self.now) } else { finish }
    }

    /// Returns the time at which a frame is shown if it finishes at `finish` and the previous frame
    /// is shown at `previous`.
    pub(crate) fn shown(&self, record: &Record, finish: f64, previous: f64) -> f64 {
        if let Some(shown) = record.shown {
            return shown;
        }
        if let Some(min_period) = self.presentation.variable_ns() {
            return finish.max(previous + min_period);
        }
        let Some(period) = self.clock.period().filter(|_| self.presentation.has_grid()) else {
            return finish.max(previous);
        };
        let mut earliest = finish.max(previous + 0.5 * period);
        if self.presentation.reports == PresentReports::Times {
            // If the frame had been shown that long ago, it would have been reported. After some
            // refreshes the report is given up, since a loop without reports must not stop.
            let knowing = self.report.expected() + 3.0 * self.report.spread() + 0.5 * period;
            let overdue = (self.now - knowing).min(earliest + PATIENCE_REFRESHES * period);
            earliest = earliest.max(overdue);
        }
        self.clock.at_or_after(earliest).unwrap_or(earliest)
    }
}
