//! Tests of the guarantees for displays of a fixed rate, over thousands of random machines and
//! loads.

use antumbra_pacing::{PresentReports, PresentationMode};

use crate::measure::{mean, quantile};
use crate::run::{Run, run};
use crate::scenario::{FrameLoop, Scenario};

/// The number of frames in which a pacer has to learn.
const LEARNT: usize = 120;

/// The number of runs per guarantee, by the kind of reports.
const FIFO_RUNS: u64 = 5_000;
const RELAXED_RUNS: u64 = 1_000;
const MAILBOX_RUNS: u64 = 2_000;
const ACQUIRES_ONLY_RUNS: u64 = 2_000;
const _: () = assert!(FIFO_RUNS + RELAXED_RUNS + MAILBOX_RUNS + ACQUIRES_ONLY_RUNS >= 10_000);

#[derive(Default)]
struct Tally {
    runs: u64,
    missed: usize,
    refreshes: usize,
    worst_missed: (usize, u64),
    worst_latency: (f64, u64),
    excess: Vec<f64>,
}

impl Tally {
    /// Adds a run, and checks the guarantees that hold for each run.
    fn add(&mut self, run: &Run, queue_limit: u32) {
        let seed = run.scenario.seed;
        assert_eq!(run.outcomes.len(), run.scenario.frames);
        assert!(run.most_queued() <= queue_limit as usize, "seed {seed}: too many queued");
        self.runs += 1;
        let (missed, refreshes) = run.missed_refreshes(LEARNT);
        self.missed += missed;
        self.refreshes += refreshes;
        self.worst_missed = self.worst_missed.max((missed, seed));
        let excess = run.latency_excess(LEARNT);
        assert!(!excess.is_empty());
        let average = mean(&excess);
        assert!(average < 1.0, "seed {seed}: latency {average} refreshes over the optimum");
        // No frame may be shown before the optimum allows; otherwise the optimum is wrong.
        assert!(excess.iter().all(|excess| *excess > -1e-6), "seed {seed}: beats the optimum");
        if average > self.worst_latency.0 {
            self.worst_latency = (average, seed);
        }
        self.excess.extend(excess);
    }

    fn check(&self, name: &str) {
        let share = self.missed as f64 / self.refreshes as f64;
        let late = quantile(&self.excess, 0.99);
        println!(
            "{name}: missed {:.4} % (worst {:?}), latency over the optimum: mean {:.3}, p99 {late:.3}, \
             worst mean {:?}",
            100.0 * share,
            self.worst_missed,
            mean(&self.excess),
            self.worst_latency
        );
        assert!(share <= 0.001, "{name}: {} of {} missed", self.missed, self.refreshes);
        assert!(late <= 1.0, "{name}: p99 {late} refreshes over the optimum");
    }
}

fn tally(name: &str, runs: u64, scenario: impl Fn(u64) -> Scenario) {
    let mut tally = Tally::default();
    for seed in 0..runs {
        let scenario = scenario(seed);
        tally.add(&run(&scenario), scenario.options.queue_limit);
    }
    assert_eq!(tally.runs, runs, "{name}");
    tally.check(name);
}

#[test]
fn fifo_with_present_times() {
    tally("fifo", FIFO_RUNS, |seed| Scenario::random(seed, PresentationMode::Fifo));
}

#[test]
fn relaxed_fifo_with_present_times() {
    tally("relaxed fifo", RELAXED_RUNS, |seed| {
        Scenario::random(seed, PresentationMode::FifoRelaxed)
    });
}

#[test]
fn mailbox_with_present_times() {
    tally("mailbox", MAILBOX_RUNS, |seed| Scenario::random(seed, PresentationMode::Mailbox));
}

/// Checks the guarantees with acquires and ticks only. Then the queue is as long as the swapchain
/// forces, so the caller creates as many images as frames may be queued.
#[test]
fn fifo_with_acquires_only() {
    tally("acquires only", ACQUIRES_ONLY_RUNS, |seed| {
        let mut scenario = Scenario::random(seed, PresentationMode::Fifo);
        scenario.reports = PresentReports::Missing;
        scenario.images = scenario.images.min(3);
        scenario.options.queue_limit = scenario.options.queue_limit.max(scenario.images as u32);
        scenario
    });
}

/// Checks that each long run keeps the guarantees that hold on average.
#[test]
fn long_runs_each_keep_the_promise() {
    for seed in 0..40 {
        let mode = [PresentationMode::Fifo, PresentationMode::Mailbox][seed as usize % 2];
        let mut scenario = Scenario::random(seed, mode);
        scenario.frames = 8_000;
        let run = run(&scenario);
        let (missed, refreshes) = run.missed_refreshes(LEARNT);
        assert!(missed * 1_000 <= refreshes, "seed {seed}: {missed} of {refreshes} missed");
        assert!(run.most_queued() <= scenario.options.queue_limit as usize, "seed {seed}");
        assert!(mean(&run.latency_excess(LEARNT)) < 1.0, "seed {seed}");
    }
}

/// Checks that the phase is searched again when the period drifts away from the one that acquires
/// revealed.
#[test]
fn long_runs_with_acquires_only() {
    for seed in 0..20 {
        let mut scenario = Scenario::random(seed, PresentationMode::Fifo);
        scenario.frames = 8_000;
        scenario.reports = PresentReports::Missing;
        scenario.images = scenario.images.min(3);
        scenario.options.queue_limit = scenario.options.queue_limit.max(scenario.images as u32);
        let run = run(&scenario);
        let (missed, refreshes) = run.missed_refreshes(LEARNT);
        assert!(missed * 1_000 <= refreshes, "seed {seed}: {missed} of {refreshes} missed");
        assert!(mean(&run.latency_excess(LEARNT)) < 1.0, "seed {seed}");
    }
}

/// Checks the measure: a loop that always starts at once shows as many frames, but much later.
#[test]
fn starting_at_once_has_worse_latency_and_longer_queues() {
    let mut worse = 0;
    let mut too_many = 0;
    for seed in 0..300 {
        let paced = Scenario::random(seed, PresentationMode::Fifo);
        let at_once = Scenario { frame_loop: FrameLoop::Unpaced, ..paced.clone() };
        let paced = run(&paced);
        let at_once = run(&at_once);
        let excess = |run: &Run| mean(&run.latency_excess(LEARNT));
        worse += u32::from(excess(&at_once) > excess(&paced) + 0.5);
        too_many +=
            u32::from(at_once.most_queued() > at_once.scenario.options.queue_limit as usize);
    }
    println!(
        "at once: {worse} of 300 are half a refresh worse, {too_many} queue more than allowed"
    );
    assert!(worse > 285, "{worse}");
    assert!(too_many > 200, "{too_many}");
}

/// Checks that the measure detects misses: 130 % load cannot reach every refresh.
#[test]
fn overload_misses_refreshes_and_stays_bounded() {
    for seed in 0..100 {
        let mut scenario = Scenario::random(seed, PresentationMode::Fifo);
        scenario.gpu = 1.3 * scenario.period();
        scenario.options.queue_limit = scenario.options.queue_limit.max(2);
        let run = run(&scenario);
        let (missed, refreshes) = run.missed_refreshes(LEARNT);
        let share = missed as f64 / refreshes as f64;
        assert!((0.15..0.55).contains(&share), "seed {seed}: {share}");
        assert!(run.most_queued() <= scenario.options.queue_limit as usize, "seed {seed}");
    }
}

/// Checks that expected present times are the actual ones.
#[test]
fn expected_presents_come_true() {
    for seed in 0..200 {
        let scenario = Scenario::random(seed, PresentationMode::Fifo);
        let run = run(&scenario);
        let later = &run.outcomes[LEARNT..];
        let right = later.iter().filter(|outcome| {
            let off = outcome.expected.zip(outcome.shown).map(|(expected, shown)| shown - expected);
            off.is_some_and(|off| off.abs() < 0.1 * scenario.period())
        });
        let right = right.count();
        let all = later.len();
        assert!(right * 100 >= all * 98, "seed {seed}: {right} of {all}");
    }
}
