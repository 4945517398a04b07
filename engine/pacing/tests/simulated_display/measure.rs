//! The measures of a run: missed refreshes, and latency relative to the optimum.

use crate::run::{Outcome, Run};
use crate::scenario::Scenario;

impl Run {
    /// Returns the number of refreshes that showed nothing new since the present time of frame
    /// `from`, and the number of all refreshes since then.
    pub fn missed_refreshes(&self, from: usize) -> (usize, usize) {
        let period = self.scenario.period();
        let shown: Vec<f64> =
            self.outcomes.iter().skip(from).filter_map(|outcome| outcome.shown).collect();
        let total: f64 =
            shown.windows(2).map(|pair| ((pair[1] - pair[0]) / period).round().max(1.0)).sum();
        let changes = shown.len().saturating_sub(1);
        (total as usize - changes, total as usize)
    }

    pub fn most_queued(&self) -> usize {
        self.outcomes.iter().map(|outcome| outcome.queued).max().unwrap_or(0)
    }

    /// Returns the latency of each frame shown from `from` on minus the optimum, in refreshes.
    pub fn latency_excess(&self, from: usize) -> Vec<f64> {
        let best = optimal_starts(&self.scenario, &self.outcomes);
        let period = self.scenario.period();
        let excess = |(outcome, best): (&Outcome, f64)| {
            outcome.shown.map(|_| (best - outcome.start) / period)
        };
        self.outcomes.iter().zip(best).skip(from).filter_map(excess).collect()
    }
}

/// Returns the latest start of each frame that would not have changed any present time. All
/// durations are known, so it is computed backwards through a flow line of one CPU and one GPU.
pub fn optimal_starts(scenario: &Scenario, outcomes: &[Outcome]) -> Vec<f64> {
    let mut next_gpu = f64::INFINITY;
    let mut next_cpu = f64::INFINITY;
    let mut starts: Vec<f64> = outcomes.iter().map(|outcome| outcome.start).collect();
    for (outcome, best) in outcomes.iter().zip(&mut starts).rev() {
        let Some(shown) = outcome.shown else { continue };
        let latest = shown - scenario.latch;
        let gpu = latest.min(next_gpu) - outcome.gpu;
        *best = gpu.min(next_cpu) - outcome.cpu;
        (next_gpu, next_cpu) = (gpu, *best);
    }
    starts
}

pub fn quantile(values: &[f64], q: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    if sorted.is_empty() { 0.0 } else { sorted[((sorted.len() - 1) as f64 * q).round() as usize] }
}

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(start: f64, cpu: f64, gpu: f64, shown: f64) -> Outcome {
        let finish = start + cpu + gpu;
        Outcome {
            start,
            cpu,
            gpu,
            finish,
            shown: Some(shown),
            dropped: false,
            queued: 1,
            expected: None,
            acquire_wait: 0.0,
        }
    }

    #[test]
    fn the_optimum_is_just_in_time_and_shares_the_units() {
        let scenario = Scenario::quiet(1);
        let alone = [outcome(0.0, 2.0, 3.0, 20.0)];
        assert_eq!(optimal_starts(&scenario, &alone), [15.0]);
        // The second frame keeps the GPU busy for 9 before 20, so the first must be finished by 11.
        let two = [outcome(0.0, 2.0, 3.0, 12.0), outcome(1.0, 1.0, 9.0, 20.0)];
        assert_eq!(optimal_starts(&scenario, &two), [6.0, 10.0]);
    }
}
