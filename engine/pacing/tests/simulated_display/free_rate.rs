//! Tests without a grid of refreshes: frame limits, immediate mode, and variable refresh rates.

use antumbra_pacing::PresentationMode;

use crate::display::Panel;
use crate::measure::{mean, quantile};
use crate::random::Random;
use crate::run::run;
use crate::scenario::{MILLISECOND, SECOND, Scenario};

const MODES: [PresentationMode; 4] = [
    PresentationMode::Fifo,
    PresentationMode::FifoRelaxed,
    PresentationMode::Mailbox,
    PresentationMode::Immediate,
];

#[test]
fn a_frame_limit_is_kept_and_used() {
    for seed in 0..800 {
        let mut scenario = Scenario::random(seed, MODES[seed as usize % 4]);
        if seed % 8 >= 4 {
            let min_period = scenario.period();
            scenario.panel = Panel::Variable { min_period, max_period: 4.0 * min_period };
        }
        let rate = SECOND / scenario.period();
        let limit = Random::new(seed).between(0.15, 0.95) * rate;
        scenario.options.frame_limit_hz = Some(limit);
        scenario.frames = 400;
        let run = run(&scenario);
        let starts: Vec<f64> = run.outcomes.iter().map(|outcome| outcome.start).collect();
        // The limit holds over any window of frames.
        for (first, window) in [(0, 399), (100, 50), (200, 150), (320, 7)] {
            let span = (starts[first + window] - starts[first]) / SECOND;
            let most = span * limit + 2.01;
            assert!(window as f64 <= most, "seed {seed}: {window} frames, at most {most}");
        }
        let reached = 279.0 / ((starts[399] - starts[120]) / SECOND);
        assert!(reached > 0.95 * limit, "seed {seed}: {reached} of {limit} frames per second");
        assert!(run.most_queued() <= scenario.options.queue_limit as usize, "seed {seed}");
    }
}

#[test]
fn immediate_mode_starts_when_the_gpu_is_about_to_be_free() {
    for seed in 0..500 {
        let scenario = Scenario::random(seed, PresentationMode::Immediate);
        let run = run(&scenario);
        assert!(run.most_queued() <= scenario.options.queue_limit as usize, "seed {seed}");
        assert!(mean(&run.latency_excess(120)) < 1.0, "seed {seed}");
        // The rate is that of the slower processor.
        let took = run.outcomes[299].shown.unwrap() - run.outcomes[120].shown.unwrap();
        let serial = scenario.options.queue_limit == 1;
        let busy =
            if serial { scenario.cpu + scenario.gpu } else { scenario.cpu.max(scenario.gpu) };
        // The cost of reports and sleeps per frame.
        let overhead = scenario.report_delay + 2.0 * scenario.wake_lateness + 0.1 * MILLISECOND;
        let share = 179.0 * (busy + overhead) / took;
        assert!(share > 0.8, "seed {seed}: busy for {share} of the time");
    }
}

#[test]
fn a_display_that_waits_gets_even_frames_at_low_latency() {
    for seed in 0..600 {
        let mode = [PresentationMode::Fifo, PresentationMode::Mailbox][seed as usize % 2];
        let mut scenario = Scenario::random(seed, mode);
        scenario.images = 3;
        let min_period = scenario.period();
        scenario.panel = Panel::Variable { min_period, max_period: 3.0 * min_period };
        scenario.latch = 0.0;
        // From far below the display's rate to slightly above it.
        let load = Random::new(seed).between(0.2, 2.0);
        let serial = scenario.options.queue_limit == 1;
        let busy = |s: &Scenario| if serial { s.cpu + s.gpu } else { s.cpu.max(s.gpu) };
        let scale = load * min_period / busy(&scenario);
        (scenario.cpu, scenario.gpu) = (scale * scenario.cpu, scale * scenario.gpu);
        let run = run(&scenario);
        assert!(run.most_queued() <= scenario.options.queue_limit as usize, "seed {seed}");
        let excess = run.latency_excess(120);
        assert!(quantile(&excess, 0.99) < 1.0, "seed {seed}: {}", quantile(&excess, 0.99));
        let shown: Vec<f64> = run.outcomes[120..].iter().filter_map(|o| o.shown).collect();
        let steps: Vec<f64> = shown.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let low = quantile(&steps, 0.02);
        let high = quantile(&steps, 0.98);
        let overhead = scenario.report_delay + 2.0 * scenario.wake_lateness + 0.1 * MILLISECOND;
        let possible = busy(&scenario).max(min_period) + overhead;
        assert!(mean(&steps) < 1.15 * possible, "seed {seed}: {} {possible}", mean(&steps));
        assert!(high < 1.6 * low, "seed {seed}: uneven, {low} to {high}");
    }
}
