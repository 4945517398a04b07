//! Measures the costs of tests and draws on this device, before the first frame.
//!
//! Each cost is a difference: the time of a batch with twice the number of items, less the time of
//! the batch, so that their common costs cancel. Each batch is timed several times, and the
//! shortest time counts. GPU timestamps are used where the device has them, otherwise the CPU time
//! from submit to completion. The outcome affects only speed: an impossible cost is replaced by the
//! default. On devices with timestamps, cost models correct the outcome by the times of frames
//! (`cull::Corrections`).

mod batch;
mod overlap;

use std::time::{Duration, Instant};

use cull::{CostTable, MeasuredSkip, SkipTimes};
use gpu::{Device, OptionalFeature, PredicationMode};

use crate::costs::box_bench::{BoxBench, CalibrationScene, PATCH_TRIANGLES};
use crate::costs::device_costs::{DeviceCosts, QueryResetCosts};
use crate::error::Error;
use batch::Batch;

/// The time after which no further round of measurements begins, once [`LEAST_ROUNDS`] are done.
const BUDGET: Duration = Duration::from_millis(60);

/// The highest number of rounds: further rounds hardly shorten the shortest time.
const ROUNDS: usize = 5;

/// The lowest number of rounds: with fewer, executors cannot be told apart.
const LEAST_ROUNDS: usize = 4;

fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The times of each batch, a time per round (ns).
struct Times(Vec<(Batch, Vec<f64>)>);

impl Times {
    /// Returns the times of a batch; empty for a batch that was not measured.
    fn of(&self, batch: Batch) -> &[f64] {
        self.0.iter().find(|(timed, _)| *timed == batch).map_or(&[], |(_, times)| times)
    }

    /// Returns the shortest time of a batch (ns), since disturbances only make times longer.
    /// Returns NaN for a batch that was not measured.
    fn shortest_ns(&self, batch: Batch) -> f64 {
        self.of(batch).iter().copied().fold(f64::NAN, f64::min)
    }

    /// Returns the cost of one item (ns), from the difference between the doubled batch and the
    /// batch.
    fn each_ns(&self, batch: Batch) -> f64 {
        let [double, single] = [batch.doubled(), batch].map(|timed| self.shortest_ns(timed));
        (double - single) / f64::from(batch.count.max(1))
    }

    /// Returns the costs of skipping by an executor.
    fn predication_costs(&self, executor: PredicationMode) -> MeasuredSkip {
        let costs = |ns_of: &dyn Fn(Batch) -> f64| {
            let [few_ns, many_ns, wide_ns] = Batch::of_ranges(executor).map(ns_of);
            let nothing_ns = ns_of(Batch::NOTHING);
            SkipTimes { nothing_ns, few_ns, many_ns, wide_ns }.costs()
        };
        let of_round =
            |round: usize| costs(&|batch| self.of(batch).get(round).copied().unwrap_or(f64::NAN));
        MeasuredSkip {
            costs: costs(&|batch| self.shortest_ns(batch)),
            rounds: (0..self.of(Batch::NOTHING).len()).map(of_round).collect(),
        }
    }
}

/// Measures every cost.
///
/// # Errors
/// No memory, a failed call, [`gpu::Error::Cancelled`].
pub fn measure(scene: CalibrationScene<'_>) -> Result<DeviceCosts, Error> {
    let began = Instant::now();
    let device = scene.device;
    let executors = scene.executors;
    let cancellation = scene.cancellation;
    let mut bench = BoxBench::new(scene, Batch::MOST)?;
    let of_things = Batch::ALL.into_iter().flat_map(|batch| [batch, batch.doubled()]);
    let of_ranges = executors.iter().flat_map(|executor| Batch::of_ranges(*executor));
    let all = std::iter::once(Batch::NOTHING).chain(of_things).chain(of_ranges);
    let able = all.filter(|batch| bench.can(batch.item)).map(|batch| (batch, Vec::new()));
    let mut times = Times(able.collect());
    // Drivers compile shaders at the first draw.
    for (batch, _) in &times.0 {
        cancellation.check()?;
        bench.time_ns(batch.item, batch.count)?;
    }
    let started = Instant::now();
    for round in 0..ROUNDS {
        if round >= LEAST_ROUNDS && started.elapsed() > BUDGET {
            break;
        }
        for (batch, times) in &mut times.0 {
            cancellation.check()?;
            let ns = bench.time_ns(batch.item, batch.count)?;
            tracing::debug!("{batch:?}: {ns:.0} ns");
            times.push(ns);
        }
    }
    tracing::debug!("prepared in {:?}, measured in {:?}", started - began, started.elapsed());
    let reset_ns = bench.reset_costs()?;
    let measured = table(&mut |batch| times.each_ns(batch), bench.recorder.large_box_pixels());
    let measured = with_resets(measured, device, &reset_ns);
    let mut share =
        overlap::break_wait_share(device, &mut bench.recorder, f64::from(measured.break_ns))?;
    if device.adapter().is_software() {
        // A software rasteriser shares the CPU cores with everything else. A batch that runs alone
        // loses less time at a break than a frame among other frames.
        share = share.max(CostTable::default().break_wait_share.into());
    }
    let table = sensible(CostTable { break_wait_share: share as f32, ..measured });
    let executors =
        executors.iter().map(|executor| (*executor, times.predication_costs(*executor))).collect();
    let device_costs = DeviceCosts { table, executors, reset_ns };
    tracing::info!("costs measured in {:?}: {device_costs:?}", began.elapsed());
    Ok(device_costs)
}

/// Adds the cost of a reset to the cost of a query, where a command resets queries.
fn with_resets(table: CostTable, device: &Device, reset_ns: &QueryResetCosts) -> CostTable {
    if device.capabilities().has(OptionalFeature::HostQueryReset) {
        table
    } else {
        CostTable { query_ns: table.query_ns + reset_ns.command_ns.max(0.0), ..table }
    }
}

/// Returns the costs that follow from the cost per item of each batch.
fn table(each: &mut impl FnMut(Batch) -> f64, large_box_pixels: f64) -> CostTable {
    let draw = each(Batch::DRAWS);
    let call = each(Batch::CALLS);
    let query = each(Batch::QUERIES) - draw - call;
    let flag_box = each(Batch::FLAGS);
    let pixel = |box_ns: f64| ((box_ns - flag_box) / large_box_pixels) as f32;
    let patch = each(Batch::PATCHES);
    CostTable {
        query_ns: query as f32,
        query_box_ns: (each(Batch::QUERIED_BOXES) - query) as f32,
        flag_box_ns: flag_box as f32,
        hidden_pixel_ns: pixel(each(Batch::HIDDEN_PIXELS)),
        flagged_pixel_ns: pixel(each(Batch::FLAGGED_PIXELS)),
        call_ns: call as f32,
        draw_ns: draw as f32,
        triangle_ns: ((patch - draw) / f64::from(PATCH_TRIANGLES)) as f32,
        break_ns: each(Batch::BREAKS) as f32,
        break_wait_share: 0.0,
        compute_round_ns: each(Batch::GRIDS) as f32,
        compute_box_ns: each(Batch::COMPUTED_BOXES) as f32,
        // The costs of an executor are filled in when it is chosen.
        ..CostTable::default()
    }
}

/// Replaces impossible costs by the default. A negative cost of noise counts as 0.
fn sensible(measured: CostTable) -> CostTable {
    let usual = CostTable::default();
    let mut doubtful = Vec::new();
    let mut kept = |(name, value): (&'static str, f32), usual: f32| {
        // A result below zero by less than the usual cost is noise; one far above it is a broken
        // clock.
        let is_sound = value.is_finite() && value > -usual && value < usual.max(1.0) * 1.0e4;
        if !is_sound {
            doubtful.push(format!("{name} = {value}"));
        }
        if is_sound { value.max(0.0) } else { usual }
    };
    let measured = measured.entries();
    let usual = usual.entries();
    let values: Vec<f32> =
        measured.into_iter().zip(usual).map(|(entry, (_, usual))| kept(entry, usual)).collect();
    // The share is always bounded, and the costs of executors are measured separately.
    if doubtful.len() + 3 >= measured.len() {
        tracing::warn!("no cost could be measured: all count as usual");
    } else if !doubtful.is_empty() {
        // A single cost may drown in the noise of a busy machine.
        let doubtful = doubtful.join(", ");
        tracing::debug!("these costs came out impossible and count as usual: {doubtful}");
    }
    CostTable::from_values(|place| values.get(place).copied().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_broken_clock_measures_counts_as_usual() {
        let usual = CostTable::default();
        assert_eq!(sensible(usual), usual);
        for value in [f32::NAN, f32::INFINITY, -1.0e9, f32::MAX] {
            let broken = CostTable::from_values(|_| value);
            assert_eq!(sensible(broken), usual);
            let one = CostTable { draw_ns: value, query_ns: 3.0, ..usual };
            assert_eq!(sensible(one), CostTable { query_ns: 3.0, ..usual });
        }
        let noise = CostTable { call_ns: -2.0, ..usual };
        assert_eq!(sensible(noise), CostTable { call_ns: 0.0, ..usual });
    }

    #[test]
    fn costs_are_differences_of_batches() {
        let mut each = |batch: Batch| match batch {
            Batch::DRAWS => 10.0,
            Batch::CALLS => 3.0,
            Batch::QUERIES => 20.0,
            Batch::QUERIED_BOXES => 12.0,
            Batch::FLAGS => 3.0,
            Batch::HIDDEN_PIXELS => 103.0,
            Batch::FLAGGED_PIXELS => 203.0,
            Batch::PATCHES => 10.0 + 2.0 * f64::from(PATCH_TRIANGLES),
            _ => 5.0,
        };
        let table = table(&mut each, 100.0);
        assert_eq!(table.call_ns, 3.0);
        assert_eq!((table.draw_ns, table.query_ns, table.query_box_ns), (10.0, 7.0, 5.0));
        assert_eq!((table.hidden_pixel_ns, table.flagged_pixel_ns), (1.0, 2.0));
        assert_eq!((table.triangle_ns, table.break_ns), (2.0, 5.0));
    }

    #[test]
    fn a_median_is_in_the_middle() {
        assert_eq!(median(&mut [9.0, 1.0, 2.0]), 2.0);
        assert!(median(&mut []).is_nan());
    }
}
