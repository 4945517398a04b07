//! Tests that the pacer's frame timings are true, and that timings without a report are unknown.

use std::time::Duration;

use antumbra_pacing::{FrameStatistics, HitchRule, PresentReports, PresentationMode};

use crate::run::{Outcome, Run, run};
use crate::scenario::{SECOND, Scenario, Stall};

fn exact(seed: u64) -> Scenario {
    let mut scenario = Scenario::random(seed, PresentationMode::Fifo);
    scenario.report_noise = 0.0;
    scenario
}

fn near(reported: Duration, truth: f64) -> bool {
    // Times are reported in whole nanoseconds.
    (reported.as_nanos() as f64 - truth).abs() < 3.0
}

#[test]
fn exact_reports_give_exact_timings() {
    for seed in 0..300 {
        let run = run(&exact(seed));
        assert!(run.timings.len() > 280, "seed {seed}: {}", run.timings.len());
        for (position, (frame, timing)) in run.timings.iter().enumerate() {
            assert_eq!(frame.0, position as u64, "in order, none left out");
            let outcome = &run.outcomes[position];
            let shown = outcome.shown.unwrap();
            assert!(near(timing.latency.unwrap(), shown - outcome.start), "seed {seed}");
            let Some(before) = position.checked_sub(1).map(|before| &run.outcomes[before]) else {
                assert_eq!((timing.present_interval, timing.start_interval), (None, None));
                continue;
            };
            let interval = shown - before.shown.unwrap();
            assert!(near(timing.present_interval.unwrap(), interval), "seed {seed}");
            assert!(near(timing.start_interval.unwrap(), outcome.start - before.start));
            if position > 120 {
                let refreshes = (interval / run.scenario.period()).round() as u32;
                assert_eq!(timing.refreshes, Some(refreshes), "seed {seed}");
                assert_eq!(timing.missed, Some(refreshes - 1), "seed {seed}");
            }
        }
    }
}

/// Checks the whole chain from the display to the numbers that a user reads.
#[test]
fn statistics_of_a_run_count_its_stall() {
    for seed in 0..100 {
        let mut scenario = exact(seed);
        let duration = 10.0 * scenario.period();
        scenario.stalls = vec![Stall::Cpu { frame: 250, duration }];
        scenario.frames = 400;
        let run = run(&scenario);
        let mut statistics = FrameStatistics::new(200, HitchRule::default()).unwrap();
        run.timings.iter().for_each(|(_, timing)| statistics.record(*timing));
        let summary = statistics.summary();
        let last = run.timings.last().unwrap().0.0 as usize;
        let truth = missed(&run, last - 199, last);
        assert_eq!(summary.missed_refreshes, Some(truth), "seed {seed}");
        assert!(truth >= 9, "seed {seed}: {truth}");
        assert!(summary.hitches >= Some(1), "seed {seed}");
        assert_eq!(summary.refreshes.unknown, 0);
        let shown = |outcome: &Outcome| outcome.shown.unwrap();
        let from = shown(&run.outcomes[last - 200]);
        let mean = (shown(&run.outcomes[last]) - from) / 200.0;
        assert!(near(summary.present_intervals.unwrap().mean, mean), "seed {seed}");
    }
}

/// Returns the number of refreshes that showed nothing new before these frames.
fn missed(run: &Run, first: usize, last: usize) -> u64 {
    let shown = |frame: usize| run.outcomes[frame].shown.unwrap();
    let steps =
        (first..=last).map(|frame| (shown(frame) - shown(frame - 1)) / run.scenario.period());
    steps.map(|step| step.round() as u64 - 1).sum()
}

#[test]
fn what_nobody_reports_is_unknown() {
    let mut known = 0;
    let mut unknown = 0;
    for seed in 0..100 {
        let mut scenario = exact(seed);
        scenario.reports = PresentReports::Missing;
        scenario.images = 3;
        scenario.options.queue_limit = 3;
        // Long enough for two phase searches.
        scenario.frames = 1_200;
        let run = run(&scenario);
        assert!(run.timings.len() > 1_180, "seed {seed}");
        for (frame, timing) in &run.timings {
            let outcome = &run.outcomes[frame.0 as usize];
            match timing.latency {
                // An acquire that had to wait revealed it, with the precision of its thread's
                // wake-up.
                Some(latency) => {
                    known += 1;
                    let truth = outcome.shown.unwrap() - outcome.start;
                    let off = latency.as_nanos() as f64 - truth;
                    assert!((-3.0..0.0001 * SECOND).contains(&off), "seed {seed}: {off}");
                }
                None => unknown += 1,
            }
            assert!(timing.start_interval.is_some() || frame.0 == 0);
            if let Some(interval) = timing.present_interval {
                // From the previous frame, never across a frame with an unknown present time.
                let before = run.outcomes[frame.0 as usize - 1].shown.unwrap();
                let off = interval.as_nanos() as f64 - (outcome.shown.unwrap() - before);
                assert!(off.abs() < 0.0001 * SECOND, "seed {seed}: {off}");
            }
        }
    }
    assert!(known > 1_000 && unknown > 10_000, "{known} known, {unknown} unknown");
}
