//! Tests with a slow software rasteriser and no display: acquires wait, but no wait reveals a
//! refresh.

use antumbra_pacing::{FrameStatistics, HitchRule, PresentReports, PresentationMode};

use crate::display::{Panel, Work};
use crate::random::Random;
use crate::run::{Run, run};
use crate::scenario::{MILLISECOND, Scenario, Stall, Ticks};

/// Returns a scenario of an X server without a screen. The GPU time per frame ranges from constant
/// to completely random.
fn rasteriser(seed: u64) -> Scenario {
    let mut random = Random::new(seed ^ 0xcafe);
    let mode = random.pick(&[
        PresentationMode::Fifo,
        PresentationMode::Fifo,
        PresentationMode::FifoRelaxed,
    ]);
    let mut scenario = Scenario::random(seed, mode);
    scenario.reports = PresentReports::Missing;
    scenario.gpu = random.pick(&[3.0, 8.0, 16.667, 33.333, 62.0]) * random.between(0.8, 1.25);
    scenario.gpu *= MILLISECOND;
    scenario.cpu = random.between(0.02, 1.2) * scenario.gpu;
    scenario.panel = Panel::Unthrottled {
        copy: random.between(0.0, 0.35) * scenario.gpu,
        waits_for: random.pick(&[Work::Replacing, Work::All]),
    };
    scenario.images = random.pick(&[2, 3, 4, 5]);
    scenario.options.queue_limit = random.pick(&[1, 2, 3, 4]);
    scenario.jitter = random.pick(&[0.0, 0.005, 0.02, 0.1]);
    scenario.ticks = random.pick(&[Ticks::Watched, Ticks::Polled, Ticks::Timestamps]);
    scenario.frames = 1_500;
    // The load also rises and falls.
    let heavier = |frame| Stall::Gpu { frame, duration: random.between(0.0, 2.0) * scenario.gpu };
    scenario.stalls = (0..1_500).step_by(97).map(heavier).collect();
    scenario
}

fn waited(run: &Run) -> usize {
    let long = |o: &&crate::run::Outcome| o.acquire_wait > 0.25 * MILLISECOND;
    run.outcomes.iter().filter(long).count()
}

#[test]
fn waits_for_a_rasteriser_are_no_refreshes() {
    let mut waits = 0;
    for seed in 0..1_000 {
        let run = run(&rasteriser(seed));
        waits += waited(&run);
        let predicted = run.outcomes.iter().filter(|outcome| outcome.expected.is_some()).count();
        assert_eq!(predicted, 0, "seed {seed}: {predicted} frames have a refresh to be shown at");
        let mut statistics = FrameStatistics::new(2_000, HitchRule::default()).unwrap();
        run.timings.iter().for_each(|(_, timing)| statistics.record(*timing));
        let summary = statistics.summary();
        assert!(summary.frames > 1_400, "seed {seed}: {} frames", summary.frames);
        assert!(summary.start_intervals.is_some(), "seed {seed}");
        assert_eq!((summary.latencies, summary.present_intervals), (None, None), "seed {seed}");
        assert_eq!((summary.missed_refreshes, summary.hitches), (None, None), "seed {seed}");
        assert_eq!(summary.refreshes.unknown as usize, summary.frames, "seed {seed}");
    }
    println!("{waits} acquires waited");
    assert!(
        waits > 100_000,
        "{waits} acquires had to wait: there was nothing to be mistaken about"
    );
}

/// Checks that the search for a display does not slow a rasteriser down: the GPU is as busy as
/// without a pacer.
#[test]
fn a_rasteriser_is_kept_busy() {
    for seed in 0..200 {
        let mut scenario = rasteriser(seed);
        scenario.options.queue_limit = scenario.options.queue_limit.max(2);
        scenario.cpu = scenario.cpu.min(0.6 * scenario.gpu);
        scenario.stalls.clear();
        scenario.panel =
            Panel::Unthrottled { copy: 0.1 * scenario.gpu, waits_for: Work::Replacing };
        let run = run(&scenario);
        let took = run.outcomes[1_499].finish - run.outcomes[0].finish;
        let share = 1_499.0 * scenario.gpu / took;
        // With two images, the GPU works on one frame while the other is copied.
        let least = if scenario.images == 2 { 0.7 } else { 0.85 };
        assert!(share > least, "seed {seed}: busy for {share} of the time");
    }
}
