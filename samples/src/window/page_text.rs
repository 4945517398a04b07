//! The text of the HUD, from plain values. What is not known is shown as that.

use std::time::Duration;

use gpu::PassTime;
use pacing::Distribution;
use render::{FrameOutcome, FrameReport};

use super::screen::ScreenFacts;

const UNKNOWN: &str = "-";
/// Passes beyond this many are summed up.
const PASS_ROWS: usize = 8;

/// A group of names and values.
pub type Facts = Vec<(String, String)>;

/// All that the text of a page is about.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// The number of the next frame.
    pub frame: u32,
    /// Of the newest frame, if there is one.
    pub report: &'a FrameReport,
    /// Of the newest frame whose answers are home.
    pub outcome: Option<&'a FrameOutcome>,
    /// The passes of a frame, where they are timed.
    pub passes: &'a [PassTime],
    /// Whether they are listed one by one.
    pub lists_passes: bool,
    /// GPU memory in use.
    pub used_bytes: u64,
    /// The device's name.
    pub device: &'a str,
    /// Of the picture, in pixels.
    pub size: [u32; 2],
    /// The strategy's name.
    pub strategy: &'a str,
    /// Whether the culling stands still.
    pub is_frozen: bool,
    /// Whether the path is recorded.
    pub is_recording: bool,
    /// How draws depend on answers.
    pub predicates: &'a str,
    /// How many frames are under way at once.
    pub frames_in_flight: usize,
    /// Where pictures are shown, if they are.
    pub screen: Option<&'a ScreenFacts>,
}

impl Known<'_> {
    /// The groups of facts, the most important first.
    pub fn facts(&self) -> Vec<Facts> {
        let mut facts = vec![self.what_it_takes(), self.what_draws(), self.what_is_drawn()];
        facts.extend(self.screen.map(what_is_shown));
        facts.extend(self.lists_passes.then(|| self.pass_rows()));
        facts
    }

    fn what_draws(&self) -> Facts {
        let [width, height] = self.size;
        let states = [(self.is_frozen, "frozen"), (self.is_recording, "recording")];
        let states = states.into_iter().filter_map(|(is_so, name)| is_so.then_some(name));
        let strategy: Vec<&str> = std::iter::once(self.strategy).chain(states).collect();
        vec![
            fact("device", self.device),
            fact("picture", format!("{width} x {height}")),
            fact("strategy", strategy.join(", ")),
            fact("predicates", self.predicates),
            fact("frames in flight", self.frames_in_flight.to_string()),
        ]
    }

    fn what_is_drawn(&self) -> Facts {
        let (report, outcome) = (self.report, self.outcome);
        let of_outcome = |number: fn(&FrameOutcome) -> u64| {
            outcome.map_or(UNKNOWN.to_owned(), |outcome| grouped(number(outcome)))
        };
        // Before the first frame there is nothing to report.
        let of_report = |number: u32| match self.frame {
            0 => UNKNOWN.to_owned(),
            _ => grouped(number.into()),
        };
        let age = match (report.youngest_answer_frames, report.oldest_answer_frames) {
            (Some(1), Some(1)) => "1 frame".to_owned(),
            (Some(youngest), Some(oldest)) if youngest == oldest => format!("{oldest} frames"),
            (Some(youngest), Some(oldest)) => format!("{youngest} to {oldest} frames"),
            _ => UNKNOWN.to_owned(),
        };
        vec![
            fact("frame", self.frame.to_string()),
            fact("draws", of_outcome(|outcome| outcome.draws)),
            fact("triangles", of_outcome(|outcome| outcome.triangles)),
            fact("revealed", of_outcome(|outcome| outcome.revealed)),
            fact("tests", of_report(report.tests)),
            fact("queries", of_report(report.queries)),
            fact("waits", of_report(report.waits)),
            fact("age of results", age),
        ]
    }

    fn what_it_takes(&self) -> Facts {
        let gpu = self.passes.iter().map(|pass| pass.gpu_ms);
        let gpu = (!self.passes.is_empty()).then(|| gpu.sum());
        let cpu = (self.frame > 0).then_some(self.report.cpu.as_secs_f64() * 1e3);
        vec![
            fact("CPU", ms(cpu)),
            fact("GPU", ms(gpu)),
            fact("GPU memory", format!("{} MiB", self.used_bytes >> 20)),
        ]
    }

    /// The GPU time by label, in the order of the frame.
    fn pass_rows(&self) -> Facts {
        let mut sums: Vec<(&str, f64)> = Vec::new();
        for pass in self.passes {
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
    let summary = &screen.summary;
    let mode = match screen.fallback {
        Some(wanted) => format!("{} (no {wanted})", screen.mode),
        None => screen.mode.to_string(),
    };
    let of = |times: Option<Distribution>, pick: fn(&Distribution) -> Duration| {
        ms(times.as_ref().map(|times| pick(times).as_secs_f64() * 1e3))
    };
    let count = |number: Option<u64>| number.map_or(UNKNOWN.to_owned(), grouped);
    // What is not reported from the screen is known from the starts of frames at least.
    let intervals = summary.present_intervals.or(summary.start_intervals);
    let hitches = summary.hitches.or(summary.start_hitches);
    vec![
        fact("present mode", mode),
        fact("images", screen.images.to_string()),
        fact("refresh", ms(screen.refresh.map(|refresh| refresh.as_secs_f64() * 1e3))),
        fact("frame, median", of(intervals, |times| times.median)),
        fact("95 %, 99 %", format!("{}, {}", of(intervals, |t| t.p95), of(intervals, |t| t.p99))),
        fact("99.9 %", of(intervals, |times| times.p99_9)),
        fact("slowest 1 %", of(intervals, |times| times.slowest_percent)),
        fact("latency", of(summary.latencies, |times| times.median)),
        fact("missed refreshes", count(summary.missed_refreshes)),
        fact("hitches", count(hitches.map(u64::from))),
    ]
}

/// How evenly the newest frames came, in one line.
pub fn in_short(screen: &ScreenFacts) -> String {
    let facts = what_is_shown(screen).into_iter().skip(3);
    let facts: Vec<String> = facts.map(|(name, value)| format!("{name} {value}")).collect();
    format!("of the last {} frames: {}", screen.summary.frames, facts.join("; "))
}

/// A name and a value.
pub fn fact(name: &str, value: impl Into<String>) -> (String, String) {
    (name.to_owned(), value.into())
}

fn ms(ms: Option<f64>) -> String {
    ms.map_or(UNKNOWN.to_owned(), |ms| format!("{ms:.2} ms"))
}

/// A number with its thousands apart.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
#[path = "page_text_tests.rs"]
mod tests;
