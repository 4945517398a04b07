//! The feedback of frames, from which the pacer learns. Implausible feedback is ignored.

use std::time::Duration;

use super::super::{Pacer, RateSearch};
use crate::frame::{Feedback, PacedFrameId};
use crate::margin::Margin;
use crate::options::{PresentReports, PresentationMode};
use crate::time::{MICROSECOND_NS, SECOND_NS, Time, ns};

/// The distance beyond which a time in the future must come from another clock.
const FUTURE_NS: f64 = 10.0 * SECOND_NS;
/// The duration above which an acquire is taken to have waited for a refresh: absolute, and in
/// periods.
const WAITED_NS: f64 = 250.0 * MICROSECOND_NS;
const WAITED_PERIODS: f64 = 0.02;

/// The share of the estimated GPU time that is tried next.
const HOPE: f64 = 0.9;

/// The number of consecutive late frames after which the learnt refreshes are doubted.
const DOUBTFUL: u32 = 8;
/// The rate per frame at which the effect of a miss fades.
const FORGET: f64 = 1e-4;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Exactness {
    Exact,
    AtMost,
}

impl Pacer {
    /// Accepts a fact about a frame. Facts about unknown or old frames are ignored, and so are
    /// times before the frame's start.
    pub fn feedback(&mut self, frame: PacedFrameId, feedback: Feedback) {
        let Some(start) = self.frames.record(frame.0).map(|record| record.start) else { return };
        let sane = |time: Time| {
            let time = time.to_ns();
            let latest = self.now.unwrap_or(time) + FUTURE_NS;
            (start..=latest).contains(&time).then_some(time)
        };
        match feedback {
            Feedback::Acquired { from, to } => {
                if let (Some(from), Some(to)) = (sane(from), sane(to)) {
                    self.last_from = Some(from);
                    self.frames.note_unfinished(from);
                    self.acquired(frame.0, to, (to - from).max(0.0));
                }
            }
            Feedback::Queued { at } => {
                let at = sane(at);
                self.queued(frame.0, at);
            }
            Feedback::Finished { at } => {
                if let Some(at) = sane(at) {
                    self.finished(frame.0, at, Exactness::Exact);
                }
            }
            Feedback::FoundFinished { at } => {
                if let Some(at) = sane(at) {
                    self.finished(frame.0, at, Exactness::AtMost);
                }
            }
            Feedback::GpuTime(duration) => self.gpu_timed(frame.0, duration),
            Feedback::Shown { at } => {
                let at = sane(at);
                self.shown(frame.0, at);
            }
            Feedback::Dropped => self.drop_frame(frame.0),
        }
    }

    /// Notes the return of an acquire. With n images, an acquire returns the image of the frame n
    /// presents ago, which the next frame has replaced on the screen: that next frame is shown. If
    /// the acquire had to wait, the frame has just been shown.
    fn acquired(&mut self, frame: u64, to: f64, waited: f64) {
        if let Some(record) = self.frames.record_mut(frame).filter(|record| record.open()) {
            record.waited = waited;
        }
        if !self.presentation.in_order() {
            return;
        }
        self.sees_acquires = true;
        let before = self.trial.returned(frame, to);
        let Some(ordinal) = self.ordinal_in_the_way() else { return };
        let shown = self.frames.of_ordinal(ordinal).map(|(frame, record)| (frame, !record.left));
        let Some((shown, newly)) = shown else { return };
        self.frames.leave_through(shown);
        if newly {
            self.shown_at(shown, self.last_refresh(to));
            self.heard();
        }
        let long = WAITED_NS.max(WAITED_PERIODS * self.some_period_ns());
        if waited > long && self.learns_from_acquires() && self.tells_of_refresh(shown, to, before)
        {
            self.clock.observe(to);
            self.shown_at(shown, to);
            if let Some(record) = self.frames.record_mut(shown) {
                record.shown = record.shown.or(Some(to));
            }
        }
    }

    /// Returns the latest possible present time of a frame that is known to be shown at `by`.
    fn last_refresh(&self, by: f64) -> f64 {
        let period = self.clock.period().filter(|_| self.presentation.has_grid());
        period.and_then(|period| self.clock.at_or_after(by - period)).unwrap_or(by).min(by)
    }

    fn queued(&mut self, frame: u64, at: Option<f64>) {
        let ordinal = self.presented;
        let Some(record) = self.frames.record_mut(frame).filter(|record| record.open()) else {
            return;
        };
        // Without a usable time, the frame still counts as queued.
        let queued = at.unwrap_or(record.start);
        record.queued = Some(queued);
        record.ordinal = Some(ordinal);
        let busy = queued - record.start - record.waited;
        self.presented += 1;
        self.dropped_in_a_row = 0;
        if at.is_some() {
            self.cpu.observe(busy.max(0.0));
        }
    }

    fn finished(&mut self, frame: u64, at: f64, exactness: Exactness) {
        // Unless the previous frame is known to be finished, the beginning of this one is unknown.
        let older = frame.checked_sub(1).and_then(|older| self.frames.record(older));
        let before =
            older.map_or(Some(0.0), |older| older.finished.or(older.dropped.then_some(0.0)));
        let Some(record) = self.frames.record_mut(frame) else { return };
        if record.finished.is_some() || record.dropped {
            return;
        }
        record.seen_finished = Some(at);
        // A shown frame is finished, whatever polls found.
        let at = record.shown.map_or(at, |shown| at.min(shown));
        let timed = record.gpu_timed;
        let begin = record.queued.zip(before).map(|(queued, before)| queued.max(before));
        let at_least = record.unfinished.min(at);
        self.sees_finishes = true;
        let Some(begin) = begin else {
            record.finished = Some(at);
            return;
        };
        let took = (at - begin).max(0.0);
        record.found = exactness == Exactness::AtMost;
        if exactness == Exactness::Exact || !self.gpu.known() {
            record.finished = Some(at);
            if !timed {
                self.gpu.observe(took);
            }
            return;
        }
        // The end is somewhere between two polls.
        let at_least = (at_least - begin).clamp(0.0, took);
        record.finished = Some((begin + self.gpu.expected().clamp(at_least, took)).min(at));
        if !timed {
            self.gpu_took(at_least, took);
        }
    }

    /// Notes a GPU time that lies between two bounds.
    fn gpu_took(&mut self, at_least: f64, at_most: f64) {
        // The GPU was seen at work for longer. Without the limit, several such samples would be
        // outliers.
        self.gpu.raise_to(at_least.min(1.25 * self.gpu.expected()));
        self.gpu.lower_to(at_most);
        let expected = self.gpu.expected();
        // The work was seen to take that long, so later guesses are not lower. This matters most if
        // misses are not reported.
        self.gpu_floor = self.gpu_floor.max(at_least.min(1.03 * expected));
        if (at_least..at_most).contains(&expected) {
            // If the estimate is possible, assume a little less: a later start leaves time for
            // better polls.
            self.gpu.drift_to((HOPE * expected).max(expected.min(self.gpu_floor)).max(at_least));
        } else {
            self.gpu.observe(expected.clamp(at_least, at_most));
        }
    }

    fn gpu_timed(&mut self, frame: u64, duration: Duration) {
        if let Some(record) = self.frames.record_mut(frame).filter(|record| !record.gpu_timed) {
            record.gpu_timed = true;
            self.gpu.observe(ns(duration));
        }
    }

    fn shown(&mut self, frame: u64, at: Option<f64>) {
        let Some(record) = self.frames.record_mut(frame) else { return };
        if record.shown.is_some() || record.dropped {
            return;
        }
        record.shown = at;
        let record = *record;
        self.frames.leave_through(frame);
        self.heard();
        let Some(at) = at else { return };
        self.shown_at(frame, at);
        self.newest_report = Some(self.newest_report.map_or(at, |newest: f64| newest.max(at)));
        if self.presentation.reports == PresentReports::Missing || !self.presentation.has_grid() {
            return;
        }
        let generation = self.clock.generation();
        let newest_wins = self.presentation.mode == PresentationMode::Mailbox;
        let late = |period: f64| record.target.is_some_and(|target| at > target + 0.5 * period);
        let predicted = record.generation == generation;
        let was_late = predicted && self.clock.period().is_some_and(late);
        self.clock.observe(at);
        self.late_in_a_row = if was_late { self.late_in_a_row.saturating_add(1) } else { 0 };
        if self.late_in_a_row >= DOUBTFUL {
            self.late_in_a_row = 0;
            self.clock.doubt();
        }
        let replaced = frame.checked_sub(1).filter(|_| newest_wins).filter(|before| {
            // The previous frame came too late for its refresh, and this frame replaced it.
            // Replacements are not reported.
            self.frames.record(*before).is_some_and(|before| {
                let passed = before.target.zip(self.clock.period());
                before.shown.is_none()
                    && !before.dropped
                    && before.generation == generation
                    && passed.is_some_and(|(target, period)| target < at - 0.5 * period)
            })
        });
        if self.clock.generation() != generation {
            // The margin was learnt on a wrong grid.
            self.margin = Margin::new(self.presentation.reports);
            self.gpu_floor = 0.0;
            self.rate_search = RateSearch::new();
            return;
        }
        for (frame, late) in [(replaced, true), (predicted.then_some(frame), was_late)] {
            if let Some(frame) = frame {
                self.learn_margin(frame, late);
            }
        }
    }

    fn learn_margin(&mut self, frame: u64, late: bool) {
        let record = self.frames.record(frame).copied();
        let Some((record, target)) = record.and_then(|record| record.target.map(|t| (record, t)))
        else {
            return;
        };
        if !late {
            self.gpu_floor *= 1.0 - FORGET;
            self.margin.in_time();
            return;
        }
        let before = frame.checked_sub(1).and_then(|before| self.frames.record(before));
        let pushed = before.and_then(|before| before.shown).is_some_and(|shown| {
            // The previous frame took this frame's refresh: that is one miss, not two.
            shown > target - 0.5 * self.some_period_ns()
        });
        if record.compromised || pushed || record.margin != self.margin.version() {
            return;
        }
        self.margin.missed();
        if record.found {
            // The end of its GPU work was not seen, so assuming less would be wrong.
            self.gpu_floor = self.gpu_floor.max(1.03 * self.gpu.expected());
        }
    }
}
