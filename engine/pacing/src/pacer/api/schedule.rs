//! The start of the next frame: as late as its refresh allows, and for the first refresh that it
//! can reach.

use super::super::{Pacer, PhaseSearch, RATE_SEARCH_FRAMES, RATE_SEARCH_PAUSES};
use crate::forecast::Forecast;
use crate::frame::{PacedFrameId, WaitReason};
use crate::time::{MICROSECOND_NS, SECOND_NS};

/// The number of standard deviations that are kept free before a refresh.
const SAFE: f64 = 4.0;
/// The share of a period above which the work of one processor cannot reach every refresh. Then the
/// GPU must not wait for the CPU.
const OVERLOAD: f64 = 0.95;
/// The uncertainty of the phase, as a share of a period, above which the phase is searched again.
const WORST_PHASE: f64 = 1.0 / 24.0;
/// The number of refreshes that a phase search looks ahead, the length of the longest search, and
/// the pause between searches, in frames.
const SEARCH_AHEAD: f64 = 512.0;
const LONGEST_SEARCH: u32 = 64;
const SEARCH_REST: u32 = 512;
/// The longest search while acquires are on trial, in frames.
const LONGEST_TRIAL: u32 = 112;

/// The schedule of the next frame from current knowledge, with times in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(in crate::pacer) struct Schedule {
    /// The start, not before now.
    pub(in crate::pacer) start: f64,
    /// The ideal start, which may be in the past.
    pub(in crate::pacer) wanted: f64,
    /// The time at which the frame should be shown.
    pub(in crate::pacer) target: Option<f64>,
    pub(in crate::pacer) reason: WaitReason,
}

impl Pacer {
    pub(in crate::pacer) fn schedule(&self, now: f64) -> Schedule {
        let forecast = self.knowledge(now).forecast(&self.frames, self.ordinal_in_the_way());
        let limited = self.limit_due > now;
        let earliest = now.max(self.limit_due);
        let cpu = self.cpu.expected();
        let gpu = self.gpu.expected();
        // A frame that started earlier would only wait for the GPU.
        let gpu_ready = forecast.gpu_free - cpu - SAFE * self.cpu.spread();
        let mut target = None;
        let wanted = if self.searches_phase() {
            self.start_in_search(now)
        } else if let Some(min_period) = self.presentation.variable_ns() {
            let ready = self.ready(earliest, &forecast);
            let shown = ready.max(forecast.last_shown + min_period);
            target = Some(shown);
            // A late frame costs only its lateness, so it needs no margin.
            (shown - gpu - cpu).max(gpu_ready)
        } else if let Some((shown, period)) = self.reachable_refresh(earliest, &forecast) {
            target = Some(shown);
            let late = shown - self.lead_ns(now);
            let overloaded = cpu.max(gpu) > OVERLOAD * period;
            let early = if self.rate_search.remaining > 0 { 0.5 * period } else { 0.0 };
            (if overloaded { late.min(gpu_ready) } else { late }) - early
        } else {
            gpu_ready
        };
        let start = wanted.max(earliest);
        let by_limit = limited && wanted <= self.limit_due;
        let reason = if by_limit { WaitReason::FrameLimit } else { WaitReason::Deadline };
        Schedule { start, wanted, target, reason }
    }

    /// Returns the time at which the GPU is expected to finish a frame that starts at `start`.
    fn ready(&self, start: f64, forecast: &Forecast) -> f64 {
        let submitted = (start + self.cpu.expected()).max(forecast.image_free);
        submitted.max(forecast.gpu_free) + self.gpu.expected()
    }

    /// Returns the first refresh that a frame started at `start` can reach, and the period. A
    /// refresh is chosen if the frame is more likely to reach it than not: margins make frames
    /// start earlier, but do not skip refreshes.
    fn reachable_refresh(&self, start: f64, forecast: &Forecast) -> Option<(f64, f64)> {
        if !self.presentation.has_grid() {
            return None;
        }
        let period = self.clock.period()?;
        let hope = self.cpu.spread().hypot(self.gpu.spread());
        let ready = self.ready(start, forecast) - hope;
        let shown = self.clock.at_or_after(ready.max(forecast.last_shown + 0.5 * period))?;
        Some((shown, period))
    }

    /// Returns the time from a frame's start to its refresh.
    fn lead_ns(&self, now: f64) -> f64 {
        let estimates = [&self.wake, &self.cpu, &self.gpu];
        let expected: f64 = estimates.iter().map(|estimate| estimate.expected()).sum();
        let variance: f64 = estimates.iter().map(|estimate| estimate.spread().powi(2)).sum();
        let phase = self.clock.uncertainty(now).unwrap_or(0.0);
        expected + SAFE * (variance.sqrt() + phase) + self.margin_ns()
    }

    /// Returns the time at which to poll the GPU for the newest frame, if a poll is informative.
    pub(in crate::pacer) fn poll_due(&self, now: f64) -> Option<(f64, PacedFrameId)> {
        if !self.sees_finishes {
            return None;
        }
        let (frame, record) = self.frames.newest_first().next()?;
        if record.finished.is_some()
            || record.gpu_timed
            || record.queued.is_none()
            || record.dropped
        {
            return None;
        }
        let before = self.frames.newest_first().skip(1).find_map(|(_, record)| record.finished);
        let begin = record.queued.unwrap_or(now).max(before.unwrap_or(0.0));
        // Poll a little early; otherwise a faster GPU would never be noticed.
        let hoped = begin + 0.95 * self.gpu.expected();
        // The longer the GPU has been at work, the rarer the polls: a GPU that hangs must not make
        // the loop spin.
        let again =
            (self.some_period_ns() / 32.0).max(100.0 * MICROSECOND_NS).max(0.25 * (now - hoped));
        Some((hoped.max(now + again), PacedFrameId(frame)))
    }

    /// Accounts a start to the frame limit, which holds on average. A frame may be early by the
    /// lateness of the previous frames, up to an interval, as happens to frames that wait for
    /// refreshes.
    pub(in crate::pacer) fn account_limit(&mut self, start: f64) {
        let Some(hz) = self.options.frame_limit_hz else { return };
        let interval = SECOND_NS / hz;
        self.limit_due = self.limit_due.max(start - interval) + interval;
    }

    pub(in crate::pacer) fn searches_phase(&self) -> bool {
        self.learns_from_acquires() && self.phase_search.active
    }

    /// Begins and ends the phase search, if only acquires reveal the phase.
    pub(in crate::pacer) fn search(&mut self, now: f64) {
        if !self.learns_from_acquires() || self.options.queue_limit == 0 {
            return;
        }
        let search = self.phase_search;
        let period = self.some_period_ns();
        let uncertainty =
            |time| self.clock.uncertainty(time).map_or(f64::INFINITY, |deviation| 3.0 * deviation);
        let toggle = if search.active {
            let sure = uncertainty(now + SEARCH_AHEAD * period) < WORST_PHASE * period;
            let longest = if self.trial.is_won() { LONGEST_SEARCH } else { LONGEST_TRIAL };
            sure || search.frames >= longest
        } else {
            uncertainty(now) > WORST_PHASE * period && search.frames >= SEARCH_REST
        };
        if toggle {
            self.phase_search = PhaseSearch { active: !search.active, frames: 0 };
            if self.phase_search.active {
                self.trial.restart(self.presentation.hint_ns());
            }
        }
    }

    /// Counts a frame towards the next search for a higher rate, or within the search.
    pub(in crate::pacer) fn advance_rate_search(&mut self) {
        let Some(period) = self.clock.period() else { return };
        if !self.presentation.has_grid() || self.clock.agrees_with_hint() {
            return;
        }
        if self.rate_search.remaining > 0 {
            self.rate_search.remaining -= 1;
        } else if self.rate_search.pause > 0 {
            self.rate_search.pause -= 1;
        } else if self.cpu.expected().max(self.gpu.expected()) < 0.45 * period {
            let pause = self.rate_search.next_pause;
            self.rate_search.remaining = RATE_SEARCH_FRAMES;
            self.rate_search.pause = pause;
            self.rate_search.next_pause = (4 * pause).min(RATE_SEARCH_PAUSES[1]);
        }
    }
}
