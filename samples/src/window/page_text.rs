//! The text of the HUD, from plain values. Unknown values are marked as such.

use std::time::Duration;

use antumbra::gpu::PassTime;
use antumbra::pacing::Distribution;
use antumbra::render::{FrameReport, FrameStats};

use super::frame_times::{FrameTimeSeries, is_overlay};
use super::screen::ScreenFacts;
use crate::hud::{ExactnessVerdict, HudFigure, Overview, Split, grouped};
use bench::strategy::Strategy;
use bench::transparency::{FragmentsReport, TransparencyReport};

const UNKNOWN: &str = "-";
/// The most rows of passes; the others are summed up.
const PASS_ROWS: usize = 8;

/// A group of names and values.
pub type Facts = Vec<(String, String)>;

/// The values from which the text of a page is created.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// The number of the next frame.
    pub frame: u32,
    /// The name of the scene.
    pub scene: &'a str,
    /// The report of the newest frame, if there is one.
    pub report: &'a FrameReport,
    /// The outcome of the newest frame whose results were read back.
    pub outcome: Option<&'a FrameStats>,
    /// The objects of the scene.
    pub objects: u64,
    /// The number of objects in the frustum in the frame of the outcome.
    pub in_frustum: Option<u64>,
    /// The times of the newest frames.
    pub times: &'a FrameTimeSeries,
    /// True if all passes are listed individually.
    pub lists_passes: bool,
    /// The GPU memory in use.
    pub used_bytes: u64,
    /// The device's name.
    pub device: &'a str,
    /// The size of the image, in pixels.
    pub size: [u32; 2],
    /// The strategy that decides about draws.
    pub strategy: Strategy,
    /// True if the culling is frozen.
    pub is_frozen: bool,
    /// True if the path is being recorded.
    pub is_recording: bool,
    /// The way in which draws depend on test results.
    pub predicates: &'a str,
    pub tester: &'a str,
    /// The number of frames in flight.
    pub frames_in_flight: usize,
    /// True while frames with and without culling are compared.
    pub is_comparing: bool,
    /// The claim about the image.
    pub claim: &'a ExactnessVerdict,
    /// The facts about the window, if there is one.
    pub screen: Option<&'a ScreenFacts>,
    /// The method of transparency, if sorting by fragments was requested.
    pub transparency: Option<&'a TransparencyReport>,
}

impl Known<'_> {
    /// Returns the most important numbers.
    pub fn overview(&self, hint: &str) -> Overview {
        let mean_ms = self.times.mean_ms().map(f64::from);
        let rate = mean_ms.map_or(UNKNOWN.to_owned(), |mean_ms| match 1e3 / mean_ms.max(1e-3) {
            hz if hz < 9.95 => format!("{hz:.1}"),
            hz => format!("{hz:.0}"),
        });
        let drawn = self.outcome.map(|outcome| outcome.draws);
        let number = |number: Option<u64>| number.map_or(UNKNOWN.to_owned(), short);
        let figure = |value: String, name| HudFigure { value, name };
        // During a comparison, each moment is drawn twice.
        let [rate_name, time_name, caption] = if self.is_comparing {
            ["pairs/s", "ms/pair", "time of a pair of frames, ms"]
        } else {
            ["frames/s", "ms/frame", "frame time, ms"]
        };
        let [cpu, _] = self.times.cpu_ms();
        let [gpu, _] = self.times.gpu_ms();
        let budget = self.screen.and_then(|screen| screen.refresh);
        Overview {
            scene: self.scene.to_owned(),
            strategy: self.strategy_and_states(),
            rate: figure(rate, rate_name),
            frame_time: figure(mean_ms.map_or(UNKNOWN.to_owned(), digits), time_name),
            frames_ms: self.times.newest_ms().collect(),
            caption,
            budget_ms: budget.map(|budget| budget.as_secs_f32() * 1e3),
            objects: [
                figure(short(self.objects), "objects"),
                figure(number(self.in_frustum), "in frustum"),
                figure(number(drawn), "drawn"),
            ],
            split: self.in_frustum.zip(drawn).map(|(all, drawn)| {
                // Objects that have moved since may have left the frustum.
                Split { drawn, culled: all.saturating_sub(drawn) }
            }),
            times: [figure(in_ms(gpu), "GPU"), figure(in_ms(cpu), "CPU")],
            verdict: self.claim.clone(),
            hint: hint.to_owned(),
        }
    }

    /// Returns the groups of facts below the overview, the most important first.
    pub fn details(&self) -> Vec<Facts> {
        let mut facts = vec![self.what_is_drawn()];
        facts.extend(self.lists_passes.then(|| self.pass_rows()));
        facts.push(self.what_draws());
        facts.push(self.overlay());
        facts.extend(self.screen.map(what_is_shown));
        facts
    }

    fn strategy_and_states(&self) -> String {
        let states = [(self.is_frozen, "frozen"), (self.is_recording, "recording")];
        let states = states.into_iter().filter_map(|(is_so, name)| is_so.then_some(name));
        let all: Vec<&str> = std::iter::once(self.strategy.name()).chain(states).collect();
        all.join(", ")
    }

    fn what_draws(&self) -> Facts {
        let [width, height] = self.size;
        let mut facts = vec![
            fact("device", self.device),
            fact("size", format!("{width} x {height}")),
            fact("predicates", self.predicates),
            fact("cheapest tester", self.tester),
            fact("frames in flight", self.frames_in_flight.to_string()),
            fact("GPU memory", format!("{} MiB", self.used_bytes >> 20)),
        ];
        let order = self.transparency;
        facts.extend(order.map(|order| fact("transparent objects", order.method.as_str())));
        let reason = order.and_then(|order| order.fallback.as_deref());
        facts.extend(reason.map(|reason| fact("since", reason)));
        let fragments = FragmentsReport::most(std::iter::once(self.report.fragments));
        facts.extend(
            fragments.map(|fragment| fact("their fragments", grouped(fragment.visible.into()))),
        );
        let lost = fragments.and_then(|fragments| fragments.lost());
        facts.extend(lost.map(|lost| fact("fragments not blended", lost)));
        facts
    }

    fn what_is_drawn(&self) -> Facts {
        let report = self.report;
        let outcome = self.outcome;
        let of_outcome = |number: fn(&FrameStats) -> u64| {
            outcome.map_or(UNKNOWN.to_owned(), |outcome| grouped(number(outcome)))
        };
        // Before the first frame there is no report.
        let of_report = |number: u32| match self.frame {
            0 => UNKNOWN.to_owned(),
            _ => grouped(number.into()),
        };
        let latency = match (report.youngest_answer_frames, report.oldest_answer_frames) {
            (Some(1), Some(1)) => "1 frame".to_owned(),
            (Some(youngest), Some(oldest)) if youngest == oldest => format!("{oldest} frames"),
            (Some(youngest), Some(oldest)) => format!("{youngest} to {oldest} frames"),
            _ => UNKNOWN.to_owned(),
        };
        vec![
            fact("frame", self.frame.to_string()),
            fact("triangles drawn", of_outcome(|outcome| outcome.triangles)),
            fact("revealed in this frame", of_outcome(|outcome| outcome.revealed)),
            fact("proxy tests", of_report(report.tests)),
            fact("queries", of_report(report.queries)),
            fact("waits for the GPU", of_report(report.waits)),
            fact("latency of results", latency),
        ]
    }

    /// Returns the costs of the HUD, in addition to the engine's own numbers.
    fn overlay(&self) -> Facts {
        let [_, cpu] = self.times.cpu_ms();
        let [_, gpu] = self.times.gpu_ms();
        vec![fact("this overlay, CPU", in_ms(cpu)), fact("this overlay, GPU", in_ms(gpu))]
    }

    /// Returns the GPU time by label, in the order of the frame.
    fn pass_rows(&self) -> Facts {
        let mut sums: Vec<(&str, f64)> = Vec::new();
        let engine = self.times.passes().iter().filter(|pass: &&PassTime| !is_overlay(pass));
        for pass in engine {
            match sums.iter_mut().find(|(label, _)| *label == pass.label) {
                Some((_, sum)) => *sum += pass.gpu_ms,
                None => sums.push((pass.label, pass.gpu_ms)),
            }
        }
        let rest: f64 = sums.iter().skip(PASS_ROWS).map(|(_, sum)| sum).sum();
        let has_rest = sums.len() > PASS_ROWS;
        let rows = sums.into_iter().take(PASS_ROWS).map(|(label, sum)| fact(label, ms(Some(sum))));
        rows.chain(has_rest.then(|| fact("others", ms(Some(rest))))).collect()
    }
}

fn what_is_shown(screen: &ScreenFacts) -> Vec<(String, String)> {
    let mode = match screen.fallback {
        Some(wanted) => format!("{} (no {wanted})", screen.mode),
        None => screen.mode.to_string(),
    };
    let mut facts = vec![
        fact("present mode", mode),
        fact("images", screen.images.to_string()),
        fact("refresh", ms(screen.refresh.map(|refresh| refresh.as_secs_f64() * 1e3))),
    ];
    facts.extend(how_evenly(screen));
    facts
}

/// Returns the pacing statistics of the newest frames.
fn how_evenly(screen: &ScreenFacts) -> Facts {
    let summary = &screen.summary;
    let of = |times: Option<Distribution>, pick: fn(&Distribution) -> Duration| {
        ms(times.as_ref().map(|times| pick(times).as_secs_f64() * 1e3))
    };
    let count = |number: Option<u64>| number.map_or(UNKNOWN.to_owned(), grouped);
    // Without reports of present times, at least the starts of frames are known.
    let intervals = summary.present_intervals.or(summary.start_intervals);
    let hitches = summary.hitches.or(summary.start_hitches);
    vec![
        fact("frame, median", of(intervals, |times| times.median)),
        fact("frame, 95 %", of(intervals, |times| times.p95)),
        fact("frame, 99 %", of(intervals, |times| times.p99)),
        fact("frame, 99.9 %", of(intervals, |times| times.p99_9)),
        fact("slowest 1 %, mean", of(intervals, |times| times.slowest_percent)),
        fact("latency to the screen", of(summary.latencies, |times| times.median)),
        fact("missed refreshes", count(summary.missed_refreshes)),
        fact("hitches", count(hitches.map(u64::from))),
    ]
}

/// Returns the pacing statistics of the newest frames in one line.
pub fn in_short(screen: &ScreenFacts) -> String {
    let facts: Vec<String> =
        how_evenly(screen).into_iter().map(|(name, value)| format!("{name} {value}")).collect();
    format!("of the last {} frames: {}", screen.summary.frames, facts.join("; "))
}

/// Returns a name and a value.
pub fn fact(name: &str, value: impl Into<String>) -> (String, String) {
    (name.to_owned(), value.into())
}

fn ms(ms: Option<f64>) -> String {
    ms.map_or(UNKNOWN.to_owned(), |ms| format!("{ms:.2} ms"))
}

/// Returns a time with three significant digits and its unit.
pub(super) fn in_ms(ms: Option<f32>) -> String {
    match ms {
        None => UNKNOWN.to_owned(),
        // Too wide for its column in milliseconds.
        Some(ms) if ms >= 9_999.5 => format!("{} s", digits(f64::from(ms) * 1e-3)),
        Some(ms) => format!("{} ms", digits(ms.into())),
    }
}

/// Returns three significant digits.
fn digits(ms: f64) -> String {
    match ms {
        _ if ms < 9.995 => format!("{ms:.2}"),
        _ if ms < 99.95 => format!("{ms:.1}"),
        _ => format!("{ms:.0}"),
    }
}

/// Returns a number that fits a column: with three significant digits from a million on.
fn short(number: u64) -> String {
    match number {
        0..1_000_000 => grouped(number),
        _ => format!("{} M", digits(number as f64 / 1e6)),
    }
}

#[cfg(test)]
mod tests;
