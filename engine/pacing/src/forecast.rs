//! What will become of the frames that are queued: when the GPU is free, when each is shown.
//!
//! It is worked out anew from all that is known whenever it is needed, so that a stall leaves
//! nothing behind but its facts.

use crate::estimate::Estimate;
use crate::frames::{Frames, Record};
use crate::options::{PresentReports, Presentation};
use crate::refresh_clock::RefreshClock;

/// So many refreshes a frame that is not reported keeps the next ones back.
const PATIENCE_REFRESHES: f64 = 4.0;

/// What forecasts rest on.
pub(crate) struct Knowledge<'a> {
    pub(crate) presentation: &'a Presentation,
    pub(crate) clock: &'a RefreshClock,
    pub(crate) gpu: &'a Estimate,
    /// From a showing to our knowing of it.
    pub(crate) report: &'a Estimate,
    /// Whether ticks come at all.
    pub(crate) sees_finishes: bool,
    /// When the last frame that has left was shown, as far as anyone knows.
    pub(crate) last_left: f64,
    pub(crate) now: f64,
}

/// Expected times in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Forecast {
    /// The GPU has done all that was submitted.
    pub(crate) gpu_free: f64,
    /// The newest frame is shown.
    pub(crate) last_shown: f64,
    /// The oldest queued frame is shown.
    pub(crate) first_leaves: f64,
    /// An image can be had for the next frame.
    pub(crate) image_free: f64,
}

impl Knowledge<'_> {
    /// `blocking` is the one that must be shown before an image can be had, by its position.
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

    /// Returns when the GPU is done with a frame, if it is free for it then.
    pub(crate) fn finish(&self, record: &Record, gpu_free: f64) -> f64 {
        if let Some(finished) = record.finished {
            return finished;
        }
        let begin = record.queued.unwrap_or(self.now).max(gpu_free);
        let finish = begin + self.gpu.expected();
        // Not seen finished, so it is not, where anyone looks.
        if self.sees_finishes { finish.max(self.now) } else { finish }
    }

    /// Returns when a frame is shown that is finished then, after another.
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
            // Had it been shown that long ago we would know. After some refreshes without a word we
            // no longer wait for it: who never knows must not stand still.
            let knowing = self.report.expected() + 3.0 * self.report.spread() + 0.5 * period;
            let overdue = (self.now - knowing).min(earliest + PATIENCE_REFRESHES * period);
            earliest = earliest.max(overdue);
        }
        self.clock.at_or_after(earliest).unwrap_or(earliest)
    }
}
