//! Tests of recovery from disturbances: stalls, hidden windows, new swapchains, coarse clocks.

use antumbra_pacing::{PresentReports, PresentationMode};

use crate::display::Panel;
use crate::measure::{mean, quantile};
use crate::run::{Run, run, run_for};
use crate::scenario::{Change, MILLISECOND, SECOND, Scenario, Stall, Ticks};

/// Checks that after frame `from` every refresh shows a new frame, with a latency of at most a
/// refresh above the optimum.
fn assert_steady(run: &Run, from: usize, to: usize) {
    let seed = run.scenario.seed;
    let mut short = run.clone();
    short.outcomes.truncate(to);
    let (missed, _) = short.missed_refreshes(from);
    assert_eq!(missed, 0, "seed {seed}: misses between frames {from} and {to}");
    let worst = quantile(&short.latency_excess(from), 1.0);
    assert!(worst <= 1.0, "seed {seed}: {worst} refreshes late between frames {from} and {to}");
}

#[test]
fn back_within_five_frames_of_a_stall() {
    const AT: usize = 200;
    for seed in 0..1_000 {
        let mut scenario = Scenario::random(seed, PresentationMode::Fifo);
        scenario.frames = 260;
        let duration = 10.0 * scenario.period();
        scenario.stalls = vec![if seed % 4 < 2 {
            Stall::Cpu { frame: AT, duration }
        } else {
            scenario.ticks = [Ticks::Watched, Ticks::Timestamps][seed as usize % 2];
            Stall::Gpu { frame: AT, duration }
        }];
        let run = run(&scenario);
        assert!(run.most_queued() <= scenario.options.queue_limit as usize, "seed {seed}");
        let stalled = run.outcomes[AT].shown.unwrap() - run.outcomes[AT].start;
        assert!(stalled > duration, "the stall is one");
        assert_steady(&run, AT + 5, AT + 25);
    }
}

/// Checks recovery with fewer and with more images than the queue limit. Timestamps that arrive
/// with a poll are not enough if the GPU stalls.
#[test]
fn back_within_five_frames_of_a_stall_without_reports() {
    const AT: usize = 200;
    let mut more_images_than_queued = 0;
    for seed in 0..1_000 {
        let mut scenario = Scenario::random(seed, PresentationMode::Fifo);
        scenario.reports = PresentReports::Missing;
        scenario.frames = 260;
        let duration = 10.0 * scenario.period();
        scenario.stalls = vec![if seed % 4 < 2 {
            Stall::Cpu { frame: AT, duration }
        } else {
            scenario.ticks = Ticks::Watched;
            Stall::Gpu { frame: AT, duration }
        }];
        more_images_than_queued +=
            u32::from(scenario.images > scenario.options.queue_limit as usize);
        assert_steady(&run(&scenario), AT + 5, AT + 25);
    }
    assert!((300..900).contains(&more_images_than_queued), "{more_images_than_queued} of 1,000");
}

#[test]
fn a_hidden_window_is_throttled_and_resumes_at_once() {
    for seed in 0..300 {
        let mode =
            [PresentationMode::Fifo, PresentationMode::Mailbox, PresentationMode::FifoRelaxed];
        let mut scenario = Scenario::random(seed, mode[seed as usize % 3]);
        scenario.hidden = 8.0 * SECOND..28.0 * SECOND;
        scenario.frames = 100_000;
        let run = run_for(&scenario, 24.5 * SECOND);
        assert!(run.ended > 28.5 * SECOND, "seed {seed}: never came back");
        let interval = scenario.options.hidden_interval.as_nanos() as f64;
        let while_hidden =
            |o: &&crate::run::Outcome| (8.2 * SECOND..28.0 * SECOND).contains(&o.start);
        let hidden = run.outcomes.iter().filter(while_hidden).count() as f64;
        let most = 20.0 * SECOND / interval + 10.0;
        assert!(hidden <= most, "seed {seed}: {hidden} frames while hidden");
        // It does not hang either: it keeps checking for a visible window.
        assert!(hidden >= 10.0, "seed {seed}: {hidden} frames while hidden");
        let seen = |o: &&crate::run::Outcome| {
            o.shown.is_some_and(|shown| (28.15 * SECOND..29.15 * SECOND).contains(&shown))
        };
        let after = run.outcomes.iter().filter(seen).count() as f64;
        let rate = SECOND / scenario.period();
        assert!(after >= 0.95 * rate, "seed {seed}: {after} frames in the second after, of {rate}");
        let visible = run.outcomes.iter().filter(|o| !(8.0..28.0).contains(&(o.start / SECOND)));
        let most = visible.map(|outcome| outcome.queued).max().unwrap();
        let images = scenario.images.max(scenario.options.queue_limit as usize);
        assert!(most <= images, "seed {seed}: {most} queued");
    }
}

#[test]
fn swapchains_come_and_go() {
    let mut missed_in_all = 0;
    let mut all = 0;
    for seed in 0..300 {
        let mut scenario = Scenario::random(seed, PresentationMode::Fifo);
        scenario.images = scenario.images.max(3);
        scenario.frames = 900;
        let panel = |hz: f64| Panel::Fixed { period: SECOND / hz, phase: 1.5 * MILLISECOND };
        let heavy = scenario.cpu.max(scenario.gpu);
        let hz = (0.8 * SECOND / heavy).min(144.0).floor();
        let one = scenario.options.queue_limit == 1;
        let hz = if one { (0.8 * SECOND / (scenario.cpu + scenario.gpu)).min(144.0) } else { hz };
        scenario.changes = vec![
            Change { frame: 150, mode: PresentationMode::Mailbox, panel: scenario.panel },
            Change { frame: 300, mode: PresentationMode::Immediate, panel: scenario.panel },
            Change { frame: 450, mode: PresentationMode::Fifo, panel: scenario.panel },
            Change { frame: 600, mode: PresentationMode::Fifo, panel: panel(hz) },
        ];
        let run = run(&scenario);
        assert!(run.most_queued() <= scenario.options.queue_limit as usize, "seed {seed}");
        let last = Run { scenario: Scenario { panel: panel(hz), ..scenario.clone() }, ..run };
        let (missed, refreshes) = last.missed_refreshes(600 + 120);
        missed_in_all += missed;
        all += refreshes;
        let late = mean(&last.latency_excess(600 + 120));
        assert!(late < 1.0, "seed {seed}: {late} refreshes over the optimum");
    }
    assert!(missed_in_all * 1_000 <= all, "{missed_in_all} of {all} missed");
}

/// Checks that a new rate of the display is noticed without a report of the change.
#[test]
fn another_rate_is_noticed() {
    for seed in 0..200 {
        let mut scenario = Scenario::random(seed, PresentationMode::Fifo);
        scenario.panel = Panel::Fixed { period: SECOND / 60.0, phase: 0.0 };
        let slower = seed % 2 == 0;
        let (before, after) = if slower { (120.0, 60.0) } else { (60.0, 144.0) };
        let period = SECOND / 144.0;
        scenario.panel = Panel::Fixed { period: SECOND / before, phase: 1e6 };
        (scenario.cpu, scenario.gpu) = (0.3 * period, 0.4 * period);
        scenario.hinted = false;
        scenario.frames = 700;
        let panel = Panel::Fixed { period: SECOND / after, phase: 2e6 };
        scenario.silent_change = Some((200, panel));
        let run = run(&scenario);
        let last = Run { scenario: Scenario { panel, ..scenario.clone() }, ..run };
        let (missed, refreshes) = last.missed_refreshes(450);
        assert!(missed <= 1, "seed {seed}: {missed} of {refreshes} missed");
        assert!(mean(&last.latency_excess(450)) < 1.0, "seed {seed}");
    }
}

#[test]
fn a_clock_of_one_millisecond_will_do() {
    let mut missed_in_all = 0;
    let mut all = 0;
    for seed in 0..500 {
        let mut scenario = Scenario::random(seed, PresentationMode::Fifo);
        scenario.clock_grain = MILLISECOND;
        // At 144 Hz a step of the clock is a seventh of a refresh, so the limit is lower.
        let scale = if scenario.options.queue_limit == 1 { 0.75 } else { 1.0 };
        (scenario.cpu, scenario.gpu) = (scale * scenario.cpu, scale * scenario.gpu);
        let run = run(&scenario);
        let (missed, refreshes) = run.missed_refreshes(120);
        missed_in_all += missed;
        all += refreshes;
        assert!(run.most_queued() <= scenario.options.queue_limit as usize, "seed {seed}");
        assert!(mean(&run.latency_excess(120)) < 1.0, "seed {seed}");
    }
    println!("1 ms clock: {missed_in_all} of {all} missed");
    assert!(missed_in_all * 200 <= all, "{missed_in_all} of {all}");
}

/// Checks that the loop still runs if a step of the clock is about a refresh, which reveals no
/// phase.
#[test]
fn a_clock_of_sixty_four_hertz_does_not_break_it() {
    for seed in 0..300 {
        let mode = [PresentationMode::Fifo, PresentationMode::Mailbox, PresentationMode::Immediate];
        let mut scenario = Scenario::random(seed, mode[seed as usize % 3]);
        scenario.clock_grain = 15.625 * MILLISECOND;
        scenario.frames = 400;
        let run = run(&scenario);
        assert!(run.most_queued() <= scenario.options.queue_limit as usize, "seed {seed}");
        let took = (run.ended - 5.0 * SECOND) / SECOND;
        let rate =
            run.outcomes.iter().filter(|outcome| outcome.shown.is_some()).count() as f64 / took;
        assert!(rate > 15.0, "seed {seed}: {rate} frames a second");
    }
}

/// Checks loops that wake only at the ends of their sleeps.
#[test]
fn reports_need_not_wake_the_loop() {
    let mut missed_in_all = 0;
    let mut all = 0;
    for seed in 0..500 {
        let mut scenario = Scenario::random(seed, PresentationMode::Fifo);
        scenario.woken_by_reports = false;
        scenario.options.queue_limit = scenario.options.queue_limit.max(2);
        scenario.cpu *= 0.8;
        let run = run(&scenario);
        let (missed, refreshes) = run.missed_refreshes(120);
        missed_in_all += missed;
        all += refreshes;
        assert!(run.most_queued() <= scenario.options.queue_limit as usize, "seed {seed}");
    }
    println!("not woken: {missed_in_all} of {all} missed");
    assert!(missed_in_all * 500 <= all, "{missed_in_all} of {all}");
}

/// Checks that misses teach the early latch of a compositor, which takes images long before it
/// shows them.
#[test]
fn an_early_latch_is_learnt() {
    let mut missed_in_all = 0;
    let mut all = 0;
    for seed in 0..300 {
        let mut scenario = Scenario::random(seed, PresentationMode::Fifo);
        scenario.options.queue_limit = 3;
        scenario.images = 4;
        let period = scenario.period();
        scenario.latch = (0.1 + 0.3 * (seed % 10) as f64 / 3.0) * period;
        scenario.cpu = scenario.cpu.min(0.6 * period);
        scenario.gpu = scenario.gpu.min(0.6 * period);
        scenario.frames = 1_200;
        let run = run(&scenario);
        let (missed, refreshes) = run.missed_refreshes(400);
        missed_in_all += missed;
        all += refreshes;
        let late = mean(&run.latency_excess(400));
        assert!(late < 1.0, "seed {seed}: {late} refreshes over the optimum");
        assert!(run.most_queued() <= 3, "seed {seed}");
    }
    println!("early latch: {missed_in_all} of {all} missed");
    assert!(missed_in_all * 500 <= all, "{missed_in_all} of {all}");
}

/// Checks that the number of sleeps is small.
#[test]
fn the_loop_wakes_a_few_times_a_frame() {
    for seed in 0..300 {
        let mode = [PresentationMode::Fifo, PresentationMode::Mailbox, PresentationMode::Immediate];
        let run = run(&Scenario::random(seed, mode[seed as usize % 3]));
        let wakes = run.steps as f64 / run.outcomes.len() as f64;
        assert!(wakes < 12.0, "seed {seed}: {wakes} wakes a frame");
    }
}
