//! The loop of a program with the simulated display: it sleeps, records, acquires, presents,
//! reports.

use std::time::Duration;

use antumbra_pacing::{Feedback, FrameTiming, PacedFrameId, Pacer, PresentReports, Step, Time};

use crate::display::{Display, Panel, Work};
use crate::random::Random;
use crate::scenario::{FrameLoop, MILLISECOND, SECOND, Scenario, Stall, Ticks};

/// The timeout of an acquire.
const ACQUIRE_TIMEOUT: f64 = 100.0 * MILLISECOND;

/// The true outcome of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    pub start: f64,
    pub cpu: f64,
    pub gpu: f64,
    pub finish: f64,
    pub shown: Option<f64>,
    pub dropped: bool,
    /// The number of frames between start and present time when it started, including itself.
    pub queued: usize,
    pub expected: Option<f64>,
    pub acquire_wait: f64,
}

#[derive(Clone, Debug)]
pub struct Run {
    pub scenario: Scenario,
    pub outcomes: Vec<Outcome>,
    /// The timings reported by the pacer.
    pub timings: Vec<(PacedFrameId, FrameTiming)>,
    /// The number of calls for the next step.
    pub steps: usize,
    pub ended: f64,
}

struct Delivery {
    at: f64,
    frame: PacedFrameId,
    feedback: Feedback,
    /// True if the loop must poll to see it.
    polled: bool,
}

struct Simulation {
    scenario: Scenario,
    random: Random,
    display: Display,
    pacer: Pacer,
    now: f64,
    gpu_free: f64,
    outcomes: Vec<Outcome>,
    timings: Vec<(PacedFrameId, FrameTiming)>,
    deliveries: Vec<Delivery>,
    steps: usize,
}

/// Runs a scenario to its end, or until `limit` in nanoseconds.
pub fn run_for(scenario: &Scenario, limit: f64) -> Run {
    let mut display = Display::new(scenario.panel, scenario.mode, scenario.images);
    display.latch = scenario.latch;
    display.hidden = scenario.hidden.clone();
    let mut simulation = Simulation {
        random: Random::new(scenario.seed ^ 0x5eed),
        display,
        pacer: Pacer::new(scenario.options, scenario.presentation()).expect("sane options"),
        now: 5.0 * SECOND,
        gpu_free: 0.0,
        outcomes: Vec::with_capacity(scenario.frames),
        timings: Vec::with_capacity(scenario.frames),
        deliveries: Vec::new(),
        steps: 0,
        scenario: scenario.clone(),
    };
    while simulation.outcomes.len() < scenario.frames && simulation.now < 5.0 * SECOND + limit {
        simulation.step();
    }
    Run {
        scenario: scenario.clone(),
        outcomes: simulation.outcomes,
        timings: simulation.timings,
        steps: simulation.steps,
        ended: simulation.now,
    }
}

pub fn run(scenario: &Scenario) -> Run {
    run_for(scenario, f64::INFINITY)
}

impl Simulation {
    fn step(&mut self) {
        self.steps += 1;
        assert!(self.steps < 200 * self.scenario.frames + 100_000, "the loop spins");
        self.deliver();
        let step = match self.scenario.frame_loop {
            FrameLoop::Paced => self.pacer.next(self.clock(self.now)),
            FrameLoop::Unpaced => {
                self.frame(PacedFrameId(self.outcomes.len() as u64), None);
                return;
            }
        };
        match step {
            Step::Start(plan) => {
                assert_eq!(plan.frame.0, self.outcomes.len() as u64);
                self.frame(plan.frame, plan.expected_present);
            }
            Step::Wait(wait) => {
                let asked = self.clock(self.now);
                assert!(wait.until > asked, "waits for the past");
                assert!(wait.until.since(asked) <= Duration::from_secs(1));
                let late = self.random.between(0.0, self.scenario.wake_lateness);
                let grain = self.scenario.clock_grain;
                // A coarse clock shows a time only after it has passed.
                let wake = (wait.until.as_nanos() as f64 / grain).ceil() * grain + late;
                let report = self.deliveries.iter().filter(|delivery| !delivery.polled);
                let report = report.map(|delivery| delivery.at).fold(f64::INFINITY, f64::min);
                let woken = if self.scenario.woken_by_reports { report } else { f64::INFINITY };
                self.now = wake.min(woken).max(self.now + 1_000.0);
            }
        }
        while let Some(timing) = self.pacer.completed() {
            self.timings.push(timing);
        }
    }

    fn clock(&self, time: f64) -> Time {
        let grain = self.scenario.clock_grain;
        Time::from_nanos(((time / grain).floor() * grain) as u64)
    }

    fn deliver(&mut self) {
        let now = self.now;
        let read = self.clock(now);
        // In the order in which they become known.
        self.deliveries.sort_by(|a, b| a.at.total_cmp(&b.at));
        let due = self.deliveries.iter().take_while(|delivery| delivery.at <= now).count();
        for delivery in self.deliveries.drain(..due) {
            let feedback = match delivery.feedback {
                Feedback::FoundFinished { .. } => Feedback::FoundFinished { at: read },
                other => other,
            };
            self.pacer.feedback(delivery.frame, feedback);
        }
    }

    fn frame(&mut self, frame: PacedFrameId, expected: Option<Time>) {
        let number = self.outcomes.len();
        self.change(number);
        let start = self.now;
        let [cpu, gpu] = self.durations(number);
        let queued = |o: &&Outcome| !o.dropped && o.shown.is_none_or(|shown| shown > start);
        let queued = 1 + self.outcomes.iter().rev().take(40).filter(queued).count();
        let expected = expected.map(|time| time.as_nanos() as f64);
        let dropped = true;
        let nothing = Outcome {
            start,
            cpu,
            gpu,
            finish: start,
            shown: None,
            dropped,
            queued,
            expected,
            acquire_wait: 0.0,
        };
        self.outcomes.push(nothing);
        self.now += cpu;
        self.deliver();
        let from = self.clock(self.now);
        let submitted = self.now;
        let mut free = self.display.image_free(submitted);
        let draws_first =
            matches!(self.display.panel, Panel::Unthrottled { waits_for: Work::All, .. });
        if draws_first {
            free = free.max(submitted.max(self.gpu_free) + gpu);
        }
        if free > self.now + ACQUIRE_TIMEOUT {
            self.now += ACQUIRE_TIMEOUT;
            self.pacer.feedback(frame, Feedback::Dropped);
            return;
        }
        if free > self.now {
            self.outcomes[number].acquire_wait = free - self.now;
            // The thread that waits for it wakes a little later.
            self.now = free + self.random.between(0.0, 0.03 * MILLISECOND);
        }
        let at = self.clock(self.now);
        self.pacer.feedback(frame, Feedback::Acquired { from, to: at });
        self.pacer.feedback(frame, Feedback::Queued { at });
        let begin = if draws_first { submitted } else { self.now };
        let finish = begin.max(self.gpu_free) + gpu;
        self.gpu_free = finish;
        let (shown, replaced) = self.display.present(number, finish);
        let outcome = &mut self.outcomes[number];
        (outcome.finish, outcome.shown, outcome.dropped) = (finish, Some(shown), false);
        if let Some(replaced) = replaced {
            self.unshow(replaced);
        }
        self.report(frame, finish, gpu, shown);
    }

    /// Removes a frame that will never be shown from the queue, as if it were dropped.
    fn unshow(&mut self, number: usize) {
        self.outcomes[number].shown = None;
        self.outcomes[number].dropped = true;
        let frame = PacedFrameId(number as u64);
        let is_report = |d: &Delivery| matches!(d.feedback, Feedback::Shown { .. });
        self.deliveries.retain(|delivery| delivery.frame != frame || !is_report(delivery));
    }

    fn durations(&mut self, number: usize) -> [f64; 2] {
        let spread = self.scenario.jitter;
        let mut vary = |mean: f64| mean * (1.0 + spread * self.random.bell()).max(0.0);
        let mut cpu = vary(self.scenario.cpu);
        let mut gpu = vary(self.scenario.gpu);
        for stall in &self.scenario.stalls {
            match *stall {
                Stall::Cpu { frame, duration } if frame == number => cpu += duration,
                Stall::Gpu { frame, duration } if frame == number => gpu += duration,
                _ => {}
            }
        }
        [cpu, gpu]
    }

    fn report(&mut self, frame: PacedFrameId, finish: f64, gpu: f64, shown: f64) {
        let ticks = self.scenario.ticks;
        if ticks != Ticks::Unknown {
            let seen = finish + self.random.between(0.0, 0.03 * MILLISECOND);
            let at = self.clock(seen);
            let polled = ticks != Ticks::Watched;
            let feedback =
                if polled { Feedback::FoundFinished { at } } else { Feedback::Finished { at } };
            self.deliveries.push(Delivery { at: seen, frame, feedback, polled });
        }
        if ticks == Ticks::Timestamps {
            let feedback = Feedback::GpuTime(Duration::from_nanos(gpu as u64));
            self.deliveries.push(Delivery { at: finish, frame, feedback, polled: true });
        }
        if self.scenario.reports == PresentReports::Times {
            let noisy = shown + self.scenario.report_noise * self.random.bell();
            let at = shown + self.random.between(0.0, self.scenario.report_delay);
            let feedback = Feedback::Shown { at: self.clock(noisy.max(0.0)) };
            self.deliveries.push(Delivery { at: at.max(shown), frame, feedback, polled: false });
        }
    }

    fn change(&mut self, number: usize) {
        if let Some((_, panel)) = self.scenario.silent_change.filter(|(frame, _)| *frame == number)
        {
            self.display.panel = panel;
        }
        let Some(change) = self.scenario.changes.iter().find(|c| c.frame == number).copied() else {
            return;
        };
        (self.scenario.mode, self.scenario.panel) = (change.mode, change.panel);
        self.display.panel = change.panel;
        for lost in self.display.recreate(change.mode, self.scenario.images, self.now) {
            self.unshow(lost);
        }
        self.pacer.present_through(self.scenario.presentation()).expect("sane");
    }
}
