//! The pacer: asked again and again what to do now, told what became known, never looking itself.

mod api;
mod books;
mod trial;

use std::time::Duration;

use crate::estimate::Estimate;
use crate::forecast::Knowledge;
use crate::frame::{Plan, Step, Wait, WaitReason};
use crate::frames::{Frames, Record};
use crate::margin::Margin;
use crate::options::{PacerOptions, PacingError, Presentation};
use crate::refresh_clock::RefreshClock;
use crate::time::{MILLISECOND_NS, SECOND_NS, Time};
use books::{Ledger, Silence};
use trial::Trial;

/// Never told to sleep longer, so that a caller can look after its window.
const LONGEST_WAIT_NS: f64 = SECOND_NS;
/// A sleep that is not worth it.
const SHORTEST_WAIT_NS: f64 = 1e4;
/// A frame is aimed at another refresh so often.
const MOST_OVERSLEPT: u32 = 2;
/// Times that go back further than that are of another clock.
const BACKWARDS_NS: f64 = 100.0 * MILLISECOND_NS;

/// Says when to start frames, so that each is shown at the next refresh it can reach, is started as
/// late as that allows, and no more than so many are queued. See the crate's page for the loop.
///
/// A pure state machine: equal calls give equal answers; it allocates nothing after creation.
#[derive(Clone, Debug)]
pub struct Pacer {
    options: PacerOptions,
    presentation: Presentation,
    clock: RefreshClock,
    /// How much later than asked a sleep ends.
    wake: Estimate,
    /// From start to submission, without the wait for an image.
    cpu: Estimate,
    gpu: Estimate,
    /// From a showing to our knowing of it.
    report: Estimate,
    margin: Margin,
    frames: Frames,
    /// Frames handed to this swapchain.
    presented: u64,
    now: Option<f64>,
    /// When the last frame started.
    last_start: Option<f64>,
    /// The newest frame that has left, and when it was shown as far as anyone knows.
    last_left: (u64, f64),
    /// Until when the last answer was to sleep for a deadline.
    slept_until: Option<f64>,
    /// How often the sleep for this frame ended too late for the refresh it was for.
    overslept: u32,
    /// The earliest start that keeps the limit.
    limit_due: f64,
    dropped_in_a_row: u32,
    silence: Silence,
    phase_search: PhaseSearch,
    trial: Trial,
    /// When the last acquire was called.
    last_from: Option<f64>,
    rate_search: RateSearch,
    /// What the caller has been seen to report.
    sees_finishes: bool,
    sees_acquires: bool,
    newest_report: Option<f64>,
    /// Frames shown after their refresh.
    late_in_a_row: u32,
    /// The GPU is not hoped to be faster than that: frames that relied on it were late.
    gpu_floor: f64,
    ledger: Ledger,
}

/// Filling the queue so that acquires wait, the only sign of refreshes where nothing is reported.
#[derive(Clone, Copy, Debug, Default)]
struct PhaseSearch {
    active: bool,
    /// Frames since it began, or since it ended.
    frames: u32,
}

/// Starting half a period earlier for some frames, to see whether the display is really that slow:
/// frames that were too heavy when the period was learnt make it look like a multiple.
#[derive(Clone, Copy, Debug)]
struct RateSearch {
    remaining: u32,
    /// Frames until the next, and how many that will be then.
    pause: u32,
    next_pause: u32,
}

const RATE_SEARCH_FRAMES: u32 = 4;
const RATE_SEARCH_PAUSES: [u32; 2] = [8, 8_192];

impl RateSearch {
    const fn new() -> Self {
        Self { remaining: 0, pause: RATE_SEARCH_PAUSES[0], next_pause: RATE_SEARCH_PAUSES[0] * 4 }
    }
}

impl Pacer {
    /// Creates a pacer that knows nothing yet.
    ///
    /// # Errors
    /// Where an option or a property of the swapchain makes no sense.
    pub fn new(options: PacerOptions, presentation: Presentation) -> Result<Self, PacingError> {
        options.check()?;
        presentation.check()?;
        Ok(Self {
            options,
            presentation,
            clock: RefreshClock::new(presentation.hint_ns()),
            wake: Estimate::default(),
            cpu: Estimate::default(),
            gpu: Estimate::default(),
            report: Estimate::default(),
            margin: Margin::new(presentation.reports),
            frames: Frames::new(),
            presented: 0,
            now: None,
            last_start: None,
            last_left: (0, 0.0),
            slept_until: None,
            overslept: 0,
            limit_due: 0.0,
            dropped_in_a_row: 0,
            silence: Silence::default(),
            phase_search: PhaseSearch { active: true, frames: 0 },
            trial: Trial::new(presentation.hint_ns()),
            last_from: None,
            rate_search: RateSearch::new(),
            sees_finishes: false,
            sees_acquires: false,
            newest_report: None,
            late_in_a_row: 0,
            gpu_floor: 0.0,
            ledger: Ledger::default(),
        })
    }

    /// Changes what the user chose, from the next frame on.
    ///
    /// # Errors
    /// Where an option makes no sense; then nothing changes.
    pub fn choose(&mut self, options: PacerOptions) -> Result<(), PacingError> {
        options.check()?;
        if options.frame_limit_hz != self.options.frame_limit_hz {
            self.limit_due = 0.0;
        }
        self.options = options;
        Ok(())
    }

    /// There is a new swapchain, or more is known of the display. Frames queued in the old one
    /// count no more; what was learnt of CPU, GPU and display is kept where it can still be true.
    ///
    /// # Errors
    /// Where a property makes no sense; then nothing changes.
    pub fn present_through(&mut self, presentation: Presentation) -> Result<(), PacingError> {
        presentation.check()?;
        self.frames.begin_anew();
        self.presented = 0;
        self.gpu_floor = 0.0;
        self.sees_acquires = false;
        self.silence = Silence::default();
        self.dropped_in_a_row = 0;
        self.phase_search = PhaseSearch { active: true, frames: 0 };
        self.rate_search = RateSearch::new();
        self.ledger.interrupt();
        if presentation.refresh != self.presentation.refresh {
            self.clock.forget(presentation.hint_ns());
            self.trial = Trial::new(presentation.hint_ns());
        }
        if presentation.reports != self.presentation.reports
            || presentation.mode != self.presentation.mode
        {
            self.margin = Margin::new(presentation.reports);
        }
        self.presentation = presentation;
        Ok(())
    }

    /// Returns what was chosen.
    #[must_use]
    pub const fn options(&self) -> &PacerOptions {
        &self.options
    }

    /// Returns what frames are presented through.
    #[must_use]
    pub const fn presentation(&self) -> &Presentation {
        &self.presentation
    }

    /// Returns the display's refresh period, once it is known; of a display that waits for frames,
    /// its shortest.
    #[must_use]
    pub fn refresh_period(&self) -> Option<Duration> {
        self.period_ns().map(|period| Duration::from_nanos(period.round() as u64))
    }

    /// Frames that were started and are not known to have been shown or dropped.
    #[must_use]
    pub fn queued_frames(&self) -> usize {
        self.frames.queued().count()
    }

    /// Returns what to do at `now`: to sleep, or to start a frame. Cheap, and right to be asked at
    /// any time.
    ///
    /// A frame that was started before and neither [queued](crate::Feedback::Queued) nor
    /// [dropped](crate::Feedback::Dropped) since counts as dropped.
    pub fn next(&mut self, now: Time) -> Step {
        let now = self.advance(now.to_ns());
        if let Some(newest) = self.frames.next().checked_sub(1)
            && self.frames.record(newest).is_some_and(Record::open)
        {
            self.drop_frame(newest);
        }
        self.frames.note_unfinished(now);
        self.settle(now);
        self.search(now);
        match self.held_back(now) {
            Some((until, reason)) => self.look_then_sleep(now, until, reason),
            None => self.decide(now),
        }
    }

    fn decide(&mut self, now: f64) -> Step {
        let schedule = self.schedule(now);
        if schedule.start > now + SHORTEST_WAIT_NS && !self.gives_up_aiming(now) {
            return self.look_then_sleep(now, schedule.start, schedule.reason);
        }
        let woken = self.slept_until.take();
        if let Some(until) = woken {
            self.wake.observe(now - until);
        }
        let excuse = self.margin_ns() + self.wake.expected() + 4.0 * self.wake.spread();
        let frame = self.frames.begin(Record {
            start: now,
            target: schedule.target,
            generation: self.clock.generation(),
            margin: self.margin.version(),
            compromised: now - schedule.wanted > excuse,
            ..Record::default()
        });
        self.account_limit(now);
        self.overslept = 0;
        self.last_start = Some(now);
        self.phase_search.frames = self.phase_search.frames.saturating_add(1);
        self.advance_rate_search();
        Step::Start(Plan {
            frame,
            start: Time::from_ns(now),
            expected_present: schedule.target.map(Time::from_ns),
        })
    }

    /// Returns true if to start although the frame would now be for a later refresh than it was to
    /// be: after a few such sleeps the clock is too coarse to aim with, and a frame at some time is
    /// better than none.
    fn gives_up_aiming(&mut self, now: f64) -> bool {
        if self.slept_until.is_none_or(|until| now < until) {
            return false;
        }
        self.slept_until = None;
        // Those ahead that are late themselves are a reason to wait on.
        let waits_for_gpu = self.sees_finishes
            && self.frames.newest_first().next().is_some_and(|(_, r)| r.finished.is_none());
        self.overslept += u32::from(!waits_for_gpu);
        self.overslept > MOST_OVERSLEPT && self.limit_due <= now
    }

    /// Returns a sleep, or first one until the GPU should be done.
    fn look_then_sleep(&mut self, now: f64, until: f64, reason: WaitReason) -> Step {
        match self.poll_due(now) {
            Some((at, frame)) if at < until && reason != WaitReason::Hidden => {
                self.sleep(now, at, WaitReason::Poll(frame))
            }
            _ => self.sleep(now, until, reason),
        }
    }

    fn sleep(&mut self, now: f64, until: f64, reason: WaitReason) -> Step {
        let until = until.clamp(now + SHORTEST_WAIT_NS, now + LONGEST_WAIT_NS);
        self.slept_until = (reason == WaitReason::Deadline).then_some(until);
        // Far from the origin, nanoseconds are finer than predictions: always some time ahead.
        let until = Time::from_ns(until).max(Time::from_ns(now).after(Duration::from_micros(1)));
        Step::Wait(Wait { until, reason })
    }

    /// Returns the time it is: never before the last one, unless the clock was evidently set.
    fn advance(&mut self, now: f64) -> f64 {
        let last = self.now.unwrap_or(now);
        if now < last - BACKWARDS_NS {
            self.frames.forget_all();
            self.clock.forget(None);
            self.silence = Silence::default();
            self.ledger.interrupt();
            (self.last_start, self.slept_until, self.newest_report) = (None, None, None);
            (self.last_left, self.limit_due) = ((0, 0.0), 0.0);
            self.presented = 0;
            self.now = Some(now);
            return now;
        }
        let now = now.max(last);
        self.now = Some(now);
        if let Some(shown) = self.newest_report.take() {
            self.report.observe(now - shown);
        }
        now
    }

    fn knowledge(&self, now: f64) -> Knowledge<'_> {
        Knowledge {
            presentation: &self.presentation,
            clock: &self.clock,
            gpu: &self.gpu,
            report: &self.report,
            sees_finishes: self.sees_finishes,
            last_left: self.last_left.1,
            now,
        }
    }

    fn period_ns(&self) -> Option<f64> {
        match self.presentation.variable_ns() {
            Some(shortest) => Some(shortest),
            None => self.clock.period().filter(|_| self.presentation.has_grid()),
        }
    }

    /// For what needs some period and does not care which.
    fn some_period_ns(&self) -> f64 {
        self.period_ns().or(self.presentation.hint_ns()).unwrap_or(SECOND_NS / 60.0)
    }

    fn margin_ns(&self) -> f64 {
        self.margin.ns(self.some_period_ns())
    }

    fn drop_frame(&mut self, frame: u64) {
        let Some(record) = self.frames.record_mut(frame) else { return };
        if record.dropped || record.shown.is_some() {
            return;
        }
        record.dropped = true;
        // A frame that was handed over and came to nothing is no reason to hold back.
        if record.queued.is_none() {
            self.dropped_in_a_row = self.dropped_in_a_row.saturating_add(1);
        }
        self.frames.leave(frame);
    }
}
