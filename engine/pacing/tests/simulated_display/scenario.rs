//! The scenario of a simulated run: the display, the machine, the load, and the reports.

use std::ops::Range;
use std::time::Duration;

use antumbra_pacing::{PacerOptions, PresentReports, Presentation, PresentationMode, Refresh};

use crate::display::Panel;
use crate::random::Random;

pub const MILLISECOND: f64 = 1e6;
pub const SECOND: f64 = 1e9;

/// The way in which the loop learns the end of GPU work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ticks {
    /// A thread waits for ticks.
    Watched,
    /// The loop polls ticks when it wakes.
    Polled,
    /// The loop polls ticks and reads timestamps of the work.
    Timestamps,
    Unknown,
}

/// The loop that starts frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameLoop {
    Paced,
    /// A start as soon as the last frame was presented: a loop without pacing.
    Unpaced,
}

/// A stall in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stall {
    Cpu { frame: usize, duration: f64 },
    Gpu { frame: usize, duration: f64 },
}

/// A change to another swapchain before a frame.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    pub frame: usize,
    pub mode: PresentationMode,
    pub panel: Panel,
}

#[derive(Clone, Debug)]
pub struct Scenario {
    pub seed: u64,
    pub frames: usize,
    pub frame_loop: FrameLoop,
    pub options: PacerOptions,
    pub panel: Panel,
    pub mode: PresentationMode,
    pub images: usize,
    pub latch: f64,
    /// True if the period is given to the pacer in advance.
    pub hinted: bool,
    pub reports: PresentReports,
    pub ticks: Ticks,
    /// The mean CPU time, in nanoseconds.
    pub cpu: f64,
    pub gpu: f64,
    /// The relative standard deviation of both times.
    pub jitter: f64,
    /// The greatest lateness of a wake-up.
    pub wake_lateness: f64,
    /// The standard deviation of reported times.
    pub report_noise: f64,
    /// The greatest delay of a report.
    pub report_delay: f64,
    /// True if reports wake the loop.
    pub woken_by_reports: bool,
    /// The step of the clock.
    pub clock_grain: f64,
    pub stalls: Vec<Stall>,
    pub hidden: Range<f64>,
    pub changes: Vec<Change>,
    /// A change of the display before a frame, which is not reported.
    pub silent_change: Option<(usize, Panel)>,
}

impl Scenario {
    /// Returns a quiet machine at 60 Hz with all reports.
    pub fn quiet(seed: u64) -> Self {
        let period = SECOND / 60.0;
        Self {
            seed,
            frames: 300,
            frame_loop: FrameLoop::Paced,
            options: PacerOptions::default(),
            panel: Panel::Fixed { period, phase: 3e6 },
            mode: PresentationMode::Fifo,
            images: 3,
            latch: 0.0,
            hinted: false,
            reports: PresentReports::Times,
            ticks: Ticks::Watched,
            cpu: 0.3 * period,
            gpu: 0.4 * period,
            jitter: 0.02,
            wake_lateness: 0.05 * MILLISECOND,
            report_noise: 0.02 * MILLISECOND,
            report_delay: 0.3 * MILLISECOND,
            woken_by_reports: true,
            clock_grain: 1.0,
            stalls: Vec::new(),
            hidden: 0.0..0.0,
            changes: Vec::new(),
            silent_change: None,
        }
    }

    /// Returns a random display of a fixed rate, a load of up to 80 %, and a machine without
    /// pathological properties.
    pub fn random(seed: u64, mode: PresentationMode) -> Self {
        let mut random = Random::new(seed);
        let hz = random.pick(&[60.0, 90.0, 120.0, 144.0]) * random.between(0.998, 1.002);
        let period = SECOND / hz;
        let mut scenario = Self::quiet(seed);
        scenario.panel = Panel::Fixed { period, phase: random.between(0.0, period) };
        scenario.mode = mode;
        scenario.options.queue_limit = random.pick(&[1, 2, 2, 3]);
        scenario.images = random.pick(&[2, 3, 3, 4]);
        if mode == PresentationMode::Mailbox {
            scenario.images = scenario.images.max(3);
        }
        // With one frame at a time, its CPU and GPU work must both fit into the refresh.
        let (cpu, gpu) = if scenario.options.queue_limit == 1 {
            let load = random.between(0.1, 0.8);
            let share = random.between(0.1, 0.9);
            (load * share, load * (1.0 - share))
        } else {
            (random.between(0.05, 0.8), random.between(0.05, 0.8))
        };
        (scenario.cpu, scenario.gpu) = (cpu * period, gpu * period);
        scenario.jitter = random.between(0.0, 0.04);
        scenario.latch = random.between(0.0, 0.05) * period;
        scenario.hinted = random.unit() < 0.5;
        scenario.ticks = random.pick(&[Ticks::Watched, Ticks::Polled, Ticks::Timestamps]);
        scenario.wake_lateness = random.between(0.0, 0.15 * MILLISECOND);
        scenario.report_noise = random.between(0.0, 0.1 * MILLISECOND);
        scenario.report_delay = random.between(0.0, 0.3 * MILLISECOND);
        scenario
    }

    pub fn period(&self) -> f64 {
        match self.panel {
            Panel::Fixed { period, .. } => period,
            Panel::Variable { min_period, .. } => min_period,
            Panel::Unthrottled { .. } => SECOND / 60.0,
        }
    }

    pub fn presentation(&self) -> Presentation {
        let span = |ns: f64| Duration::from_nanos(ns as u64);
        let refresh = match self.panel {
            Panel::Variable { min_period, max_period } => {
                Refresh::Variable { min_period: span(min_period), max_period: span(max_period) }
            }
            // Rounded, as by window systems.
            _ if self.hinted => Refresh::About(span(SECOND / (SECOND / self.period()).round())),
            _ => Refresh::Unknown,
        };
        let images = self.images as u32;
        Presentation { mode: self.mode, images, refresh, reports: self.reports }
    }
}
