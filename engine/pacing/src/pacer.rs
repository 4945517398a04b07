//! The pacer: a state machine that returns the next action and receives feedback.

mod api;
mod presented;
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
use presented::{Silence, TimingCursor};
use trial::Trial;

/// The longest sleep, so that the caller can handle events of its window.
const LONGEST_WAIT_NS: f64 = SECOND_NS;
/// The shortest useful sleep.
const SHORTEST_WAIT_NS: f64 = 1e4;
/// The number of times that a frame is rescheduled to another refresh.
const MOST_OVERSLEPT: u32 = 2;
/// The step backwards in time from which on the clock must have been set.
const BACKWARDS_NS: f64 = 100.0 * MILLISECOND_NS;

/// A frame pacer: it starts each frame as late as possible for the next refresh that the frame can
/// reach, with a bounded number of queued frames. The crate's page shows the loop.
///
/// The pacer is a pure state machine: equal calls give equal answers. It does not allocate after
/// creation.
#[derive(Clone, Debug)]
pub struct Pacer {
    options: PacerOptions,
    presentation: Presentation,
    clock: RefreshClock,
    /// The lateness of wake-ups after a sleep.
    wake: Estimate,
    /// The time from start to submission, without the wait for an image.
    cpu: Estimate,
    gpu: Estimate,
    /// The delay from the present time of a frame to its report.
    report: Estimate,
    margin: Margin,
    frames: Frames,
    /// The number of frames presented to this swapchain.
    presented: u64,
    now: Option<f64>,
    /// The start of the last frame.
    last_start: Option<f64>,
    /// The newest frame that has left the queue, and its best known present time.
    last_left: (u64, f64),
    /// The end of the last sleep for a deadline.
    slept_until: Option<f64>,
    /// The number of sleeps for this frame that ended too late for its refresh.
    overslept: u32,
    /// The earliest start that the frame limit allows.
    limit_due: f64,
    dropped_in_a_row: u32,
    silence: Silence,
    phase_search: PhaseSearch,
    trial: Trial,
    /// The time of the last call of acquire.
    last_from: Option<f64>,
    rate_search: RateSearch,
    /// True once the caller has reported finished work.
    sees_finishes: bool,
    sees_acquires: bool,
    newest_report: Option<f64>,
    /// The number of consecutive frames that were shown after their refresh.
    late_in_a_row: u32,
    /// The least GPU time that is assumed: frames planned with less were late.
    gpu_floor: f64,
    timing_cursor: TimingCursor,
}

/// The state of the phase search, which fills the queue so that acquires have to wait. Without
/// reports, these waits are the only sign of refreshes.
#[derive(Clone, Copy, Debug, Default)]
struct PhaseSearch {
    active: bool,
    /// The number of frames since the search began, or since it ended.
    frames: u32,
}

/// The state of the rate search. It starts some frames half a period earlier to check that the
/// display is really as slow as it seems. If frames were too heavy for the display while the period
/// was learnt, the learnt period may be a multiple of the true one.
#[derive(Clone, Copy, Debug)]
struct RateSearch {
    remaining: u32,
    /// The number of frames until the next search, and the number until the following one.
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
    /// Creates a pacer that has not learnt anything yet.
    ///
    /// # Errors
    /// An option or a property of the swapchain that is out of range.
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
            timing_cursor: TimingCursor::default(),
        })
    }

    /// Changes the user's options from the next frame on.
    ///
    /// # Errors
    /// An option that is out of range; then nothing changes.
    pub fn choose(&mut self, options: PacerOptions) -> Result<(), PacingError> {
        options.check()?;
        if options.frame_limit_hz != self.options.frame_limit_hz {
            self.limit_due = 0.0;
        }
        self.options = options;
        Ok(())
    }

    /// Changes to a new swapchain, or to new knowledge of the display. Frames queued to the old
    /// swapchain no longer count. Learnt times of CPU, GPU and display are kept where they can
    /// still be valid.
    ///
    /// # Errors
    /// A property that is out of range; then nothing changes.
    pub fn present_through(&mut self, presentation: Presentation) -> Result<(), PacingError> {
        presentation.check()?;
        self.frames.restart();
        self.presented = 0;
        self.gpu_floor = 0.0;
        self.sees_acquires = false;
        self.silence = Silence::default();
        self.dropped_in_a_row = 0;
        self.phase_search = PhaseSearch { active: true, frames: 0 };
        self.rate_search = RateSearch::new();
        self.timing_cursor.interrupt();
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

    /// Returns the user's options.
    #[must_use]
    pub const fn options(&self) -> &PacerOptions {
        &self.options
    }

    /// Returns the presentation in use.
    #[must_use]
    pub const fn presentation(&self) -> &Presentation {
        &self.presentation
    }

    /// Returns the display's refresh period once it is known; the shortest period for a display
    /// that waits for frames.
    #[must_use]
    pub fn refresh_period(&self) -> Option<Duration> {
        self.period_ns().map(|period| Duration::from_nanos(period.round() as u64))
    }

    /// Returns the number of frames that were started and are not known to be shown or dropped.
    #[must_use]
    pub fn queued_frames(&self) -> usize {
        self.frames.queued().count()
    }

    /// Returns the action at `now`: to sleep, or to start a frame. The call is cheap and allowed at
    /// any time.
    ///
    /// The last started frame counts as dropped if it was neither [queued](crate::Feedback::Queued)
    /// nor [dropped](crate::Feedback::Dropped) since.
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

    /// Returns true if the frame should start although it can now only reach a later refresh than
    /// planned. After a few sleeps that ended too late, the clock is too coarse to aim for a
    /// refresh, and a frame at any time is better than none.
    fn gives_up_aiming(&mut self, now: f64) -> bool {
        if self.slept_until.is_none_or(|until| now < until) {
            return false;
        }
        self.slept_until = None;
        // If the GPU is still at work on earlier frames, waiting longer is right.
        let waits_for_gpu = self.sees_finishes
            && self.frames.newest_first().next().is_some_and(|(_, r)| r.finished.is_none());
        self.overslept += u32::from(!waits_for_gpu);
        self.overslept > MOST_OVERSLEPT && self.limit_due <= now
    }

    /// Returns a sleep, or a shorter sleep that ends when the GPU should be finished.
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
        // Far from the origin, times are coarser than a nanosecond: always sleep some time.
        let until = Time::from_ns(until).max(Time::from_ns(now).after(Duration::from_micros(1)));
        Step::Wait(Wait { until, reason })
    }

    /// Returns the current time, which is never earlier than the last one unless the clock was set.
    fn advance(&mut self, now: f64) -> f64 {
        let last = self.now.unwrap_or(now);
        if now < last - BACKWARDS_NS {
            self.frames.forget_all();
            self.clock.forget(None);
            self.silence = Silence::default();
            self.timing_cursor.interrupt();
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

    /// Returns a period for uses that accept any plausible value.
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
        // A frame that was presented and then dropped does not hold the next frames back.
        if record.queued.is_none() {
            self.dropped_in_a_row = self.dropped_in_a_row.saturating_add(1);
        }
        self.frames.leave(frame);
    }
}
