//! Tests of the knowledge that is kept and forgotten when the swapchain is replaced.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::time::Duration;

use antumbra_pacing::{
    Feedback, PacedFrameId, Pacer, PacerOptions, PresentReports, Presentation, PresentationMode,
    Refresh, Step, Time, WaitReason,
};

const MILLISECOND: u64 = 1_000_000;
const PERIOD: u64 = 16 * MILLISECOND;
const CPU: u64 = MILLISECOND;

fn presentation(mode: PresentationMode, hz: f64) -> Presentation {
    let refresh = Refresh::About(Duration::from_secs_f64(1.0 / hz));
    Presentation { mode, images: 3, refresh, reports: PresentReports::Times }
}

/// A machine without any variation, in nanoseconds.
struct Machine {
    pacer: Pacer,
    now: u64,
    period: u64,
    gpu: u64,
    /// The time before a refresh by which a frame must be finished.
    latch: u64,
    /// The delay with which the loop wakes to poll the GPU.
    look_late: u64,
    gpu_free: u64,
    last_shown: u64,
    /// Frames without a report, with the end of their GPU work and their present time.
    unfinished: Vec<(PacedFrameId, u64)>,
    unseen: Vec<(PacedFrameId, u64)>,
}

impl Machine {
    fn new() -> Self {
        Self {
            pacer: Pacer::new(PacerOptions::default(), presentation(PresentationMode::Fifo, 62.5))
                .unwrap(),
            now: 1_000 * MILLISECOND,
            period: PERIOD,
            gpu: 8 * MILLISECOND,
            latch: 0,
            look_late: 0,
            gpu_free: 0,
            last_shown: 0,
            unfinished: Vec::new(),
            unseen: Vec::new(),
        }
    }

    /// Runs `frames` frames. Returns the mean latency of the last fifty, from start to present
    /// time, in milliseconds.
    fn latency_ms(&mut self, frames: usize) -> f64 {
        let latencies: Vec<u64> = (0..frames).map(|_| self.frame().1).collect();
        let last = &latencies[frames.saturating_sub(50)..];
        last.iter().sum::<u64>() as f64 / last.len() as f64 / MILLISECOND as f64
    }

    /// Sleeps, then starts and presents one frame. Returns its expected present time and its
    /// latency.
    fn frame(&mut self) -> (Option<Time>, u64) {
        loop {
            self.look();
            match self.pacer.next(Time::from_nanos(self.now)) {
                Step::Wait(wait) => {
                    let polls = matches!(wait.reason, WaitReason::Poll(_));
                    self.now = wait.until.as_nanos() + if polls { self.look_late } else { 0 };
                }
                Step::Start(plan) => return (plan.expected_present, self.present(plan.frame)),
            }
        }
    }

    fn look(&mut self) {
        let now = self.now;
        let at = Time::from_nanos(now);
        for (frame, _) in self.unfinished.extract_if(.., |(_, end)| *end <= now) {
            self.pacer.feedback(frame, Feedback::FoundFinished { at });
        }
        for (frame, shown) in self.unseen.extract_if(.., |(_, shown)| *shown <= now) {
            self.pacer.feedback(frame, Feedback::Shown { at: Time::from_nanos(shown) });
        }
    }

    fn present(&mut self, frame: PacedFrameId) -> u64 {
        let start = self.now;
        self.now += CPU;
        self.look();
        let at = Time::from_nanos(self.now);
        self.pacer.feedback(frame, Feedback::Acquired { from: at, to: at });
        self.pacer.feedback(frame, Feedback::Queued { at });
        self.gpu_free = self.gpu_free.max(self.now) + self.gpu;
        let ready = (self.gpu_free + self.latch).max(self.last_shown + self.period / 2);
        self.last_shown = ready.div_ceil(self.period) * self.period;
        self.unfinished.push((frame, self.gpu_free));
        self.unseen.push((frame, self.last_shown));
        self.last_shown - start
    }

    /// Shows all presented frames, then changes to another swapchain.
    fn present_through(&mut self, presentation: Presentation) {
        self.now = self.now.max(self.last_shown);
        self.look();
        self.pacer.present_through(presentation).unwrap();
    }
}

/// Checks that a slower GPU in the past does not spoil the estimate for a smaller image, even if
/// polls are too coarse to reveal the speed.
#[test]
fn the_gpu_may_be_faster_in_a_new_swapchain() {
    let mut machine = Machine::new();
    let before = machine.latency_ms(200);
    assert!(before > 9.0, "{before} ms are less than the work");
    machine.gpu = 2 * MILLISECOND;
    machine.look_late = 5 * MILLISECOND;
    machine.present_through(presentation(PresentationMode::Fifo, 62.5));
    let after = machine.latency_ms(200);
    assert!(after < 6.5, "{after} ms for 3 ms of work, {before} ms before");
}

/// Checks that nothing is predicted for another display, or another rate of the same display, until
/// some of its refreshes were seen.
#[test]
fn nothing_is_predicted_of_a_display_that_was_never_seen() {
    let mut machine = Machine::new();
    machine.gpu = 2 * MILLISECOND;
    machine.latency_ms(100);
    machine.present_through(presentation(PresentationMode::Fifo, 62.5));
    assert_eq!(machine.pacer.refresh_period(), Some(Duration::from_nanos(PERIOD)));
    assert!(machine.frame().0.is_some(), "it is the same display");
    machine.period = 7 * MILLISECOND;
    machine.present_through(presentation(PresentationMode::Fifo, 1_000.0 / 7.0));
    assert_eq!(machine.pacer.refresh_period(), None);
    assert_eq!(machine.frame().0, None);
    for frame in 1..40 {
        let expected = machine.frame().0.map(Time::as_nanos);
        let off = expected.map(|expected| expected.abs_diff(machine.last_shown));
        assert!(off.is_none_or(|off| off < MILLISECOND), "frame {frame}: off by {off:?} ns");
        assert!(off.is_some() || frame < 12, "frame {frame}: still unknown");
    }
}

/// Checks that the early latch of a compositor is learnt from misses, per present mode.
#[test]
fn the_margin_is_learnt_again_for_another_mode() {
    let mut machine = Machine::new();
    machine.gpu = 2 * MILLISECOND;
    machine.latch = 8 * MILLISECOND;
    let early = machine.latency_ms(300);
    assert!((11.0..20.0).contains(&early), "{early} ms");
    machine.latch = 0;
    machine.present_through(presentation(PresentationMode::Fifo, 62.5));
    let same_mode = machine.latency_ms(100);
    assert!(same_mode > 10.0, "{same_mode} ms: forgotten, {early} ms before");
    machine.present_through(presentation(PresentationMode::Mailbox, 62.5));
    let other_mode = machine.latency_ms(100);
    assert!(other_mode < 6.0, "{other_mode} ms: kept, {early} ms before");
}
