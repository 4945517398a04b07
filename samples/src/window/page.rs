//! What the HUD of a session says. What is not known is shown as that.

use std::time::Duration;

use pacing::Distribution;

use super::deeds::{KEYS, STEERING};
use super::screen::ScreenFacts;
use super::session::Session;
use crate::hud::HudPage;

const UNKNOWN: &str = "-";
/// Passes beyond this many are summed up.
const PASS_ROWS: usize = 8;

impl Session {
    /// Lays the HUD out anew, if there is one; `scale` pixels are a point.
    ///
    /// # Errors
    /// When the device fails.
    pub fn lay_out(
        &mut self,
        screen: Option<&ScreenFacts>,
        scale: f32,
    ) -> Result<(), crate::run::RunError> {
        let Some(mut hud) = self.hud.take() else { return Ok(()) };
        let page = self.page(screen);
        let size = self.renderer.size();
        let laid_out = hud.lay_out(&page, size, scale, self.renderer.flat_overlay()?);
        self.hud = Some(hud);
        Ok(laid_out?)
    }

    fn page(&self, screen: Option<&ScreenFacts>) -> HudPage {
        let mut facts = vec![self.what_it_takes(), self.what_draws(), self.what_is_drawn()];
        if let Some(screen) = screen {
            facts.push(what_is_shown(screen));
        }
        if self.is_timing_passes {
            facts.push(self.passes());
        }
        let own = |(key, deed): (&str, &str)| (key.to_owned(), deed.to_owned());
        let keys = KEYS.iter().map(|(key, deed, _)| (*key, *deed)).chain(STEERING);
        HudPage {
            frames_ms: self.times.newest_ms().collect(),
            budget_ms: screen.and_then(|screen| screen.refresh).map(|d| d.as_secs_f32() * 1e3),
            facts,
            keys: keys.map(own).collect(),
            notice: self.notice.at(self.clock.now()).map(str::to_owned),
        }
    }

    fn what_draws(&self) -> Vec<(String, String)> {
        let [width, height] = self.renderer.size();
        let adapter = self.renderer.device().adapter();
        let mut state = vec![self.strategy.to_string()];
        state.extend(self.frozen.as_ref().map(|_| "frozen".to_owned()));
        state.extend(self.recording.as_ref().map(|_| "recording".to_owned()));
        vec![
            fact("device", adapter.name.clone()),
            fact("picture", format!("{width} x {height}")),
            fact("strategy", state.join(", ")),
            fact("predicates", self.renderer.predication().name()),
            fact("frames in flight", self.renderer.frames_in_flight().to_string()),
        ]
    }

    fn what_is_drawn(&self) -> Vec<(String, String)> {
        let (report, outcome) = (&self.report, &self.outcome);
        let of_outcome = |number: fn(&render::FrameOutcome) -> u64| {
            outcome.as_ref().map_or(UNKNOWN.to_owned(), |outcome| grouped(number(outcome)))
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

    fn what_it_takes(&self) -> Vec<(String, String)> {
        let passes = self.renderer.pass_times();
        let gpu = (!passes.is_empty()).then(|| passes.iter().map(|pass| pass.gpu_ms).sum());
        let (_, used) = self.renderer.device().memory_bytes();
        let cpu = (self.frame > 0).then_some(self.report.cpu.as_secs_f64() * 1e3);
        vec![
            fact("CPU", ms(cpu)),
            fact("GPU", ms(gpu)),
            fact("GPU memory", format!("{} MiB", used >> 20)),
        ]
    }

    /// The GPU time by label, in the order of the frame.
    fn passes(&self) -> Vec<(String, String)> {
        let mut sums: Vec<(&str, f64)> = Vec::new();
        for pass in self.renderer.pass_times() {
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

fn fact(name: &str, value: impl Into<String>) -> (String, String) {
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
mod tests {
    use super::*;
    use gpu::PresentMode;
    use pacing::Summary;

    #[test]
    fn numbers_are_readable() {
        let cases = [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")];
        for (number, text) in cases {
            assert_eq!(grouped(number), text);
        }
        assert_eq!((ms(None), ms(Some(1.234))), ("-".to_owned(), "1.23 ms".to_owned()));
    }

    #[test]
    fn what_is_unknown_is_no_number() {
        let screen = ScreenFacts {
            mode: PresentMode::Fifo,
            fallback: Some(PresentMode::Mailbox),
            images: 3,
            refresh: None,
            summary: Summary::default(),
        };
        let facts = what_is_shown(&screen);
        let value = |name: &str| facts.iter().find(|(n, _)| n == name).unwrap().1.clone();
        assert_eq!(value("present mode"), "fifo (no mailbox)");
        for name in ["refresh", "frame, median", "latency", "missed refreshes", "hitches"] {
            assert_eq!(value(name), "-");
        }
    }
}
