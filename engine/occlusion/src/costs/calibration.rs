//! Measures the prices of tests and draws on this device, before the first frame.
//!
//! Each price is a difference: the time of a batch with twice as many of a thing less the time of
//! one with half of them, so that their common costs cancel. Of several times the shortest counts.
//! GPU timestamps are used where the device has them, else the CPU's time from submit to end. Only
//! speed depends on the outcome: a price that makes no sense is replaced by the default. Where
//! there are timestamps, cost models correct the outcome by the times of frames
//! (`cull::Corrections`).

mod batch;
mod overlap;

use std::fmt::Display;
use std::time::{Duration, Instant};

use cull::CostTable;
use gpu::{Device, FrameRing, IndirectDraw, Optional, Predication};

use crate::error::Error;
use crate::object_renderer::ObjectRenderer;
use crate::passes::OcclusionPasses;
use crate::shader_set::ShaderSet;
pub use batch::PATCH_TRIANGLES;
use batch::{Batch, Bench};

/// The time after which no round of measurements begins.
const BUDGET: Duration = Duration::from_millis(60);

/// The most rounds: more hardly make the shortest time shorter.
const ROUNDS: usize = 5;

/// The source of prices.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Costs {
    /// No prices: everything that may be hidden is tested.
    Ignored,
    /// The given table.
    Table(CostTable),
    /// Prices that are measured when the renderer is made: a quarter of a second on a software
    /// driver.
    #[default]
    Measured,
}

/// The objects that prices are measured with.
pub struct CalibrationScene<'a> {
    /// The device whose prices are measured.
    pub device: &'a Device,
    /// The shaders that the passes were made of.
    pub shaders: &'a ShaderSet,
    /// The passes that test boxes.
    pub passes: &'a OcclusionPasses,
    /// The way that hidden draws are skipped.
    pub predication: Predication,
    /// The renderer that draws hidden objects in place of the scene's.
    pub objects: &'a mut dyn ObjectRenderer,
    /// An object of a triangle, and one of [`PATCH_TRIANGLES`] of which half face away.
    pub draws: [IndirectDraw; 2],
}

/// Returns the table for a scene; `None` where costs are ignored. Calls `measure` only to measure.
pub fn cost_table<E: Display>(
    costs: Costs,
    measure: impl FnOnce() -> Result<CostTable, E>,
) -> Option<CostTable> {
    match costs {
        Costs::Ignored => None,
        Costs::Table(table) => Some(table.checked().unwrap_or_else(|error| {
            tracing::warn!("{error}");
            CostTable::default()
        })),
        Costs::Measured => Some(measure().unwrap_or_else(|error| {
            tracing::warn!("the costs of this device could not be measured: {error}");
            CostTable::default()
        })),
    }
}

/// The clock that times batches.
struct Clock {
    device: Device,
    frames: FrameRing,
    has_timestamps: bool,
}

impl Clock {
    fn new(device: &Device) -> Result<Self, Error> {
        let mut frames = FrameRing::new(device, 1)?;
        let has_timestamps = device.capabilities().has(Optional::Timestamps);
        if has_timestamps {
            frames.time_passes()?;
        }
        Ok(Self { device: device.clone(), frames, has_timestamps })
    }

    /// Returns the time of a batch (ns), alone on the GPU.
    fn time_ns(&mut self, bench: &mut Bench<'_>, batch: Batch) -> Result<f64, Error> {
        let mut frame = self.frames.begin()?;
        bench.prepare(&mut frame, batch)?;
        frame.commands().pass("calibration", |commands| bench.record(commands, batch));
        let began = Instant::now();
        frame.submit(None)?;
        self.device.drain()?;
        let elapsed = began.elapsed();
        if self.has_timestamps
            && let Some(time) = self.frames.begin()?.pass_times().first()
        {
            return Ok(time.gpu_ms * 1.0e6);
        }
        Ok(elapsed.as_secs_f64() * 1.0e9)
    }
}

/// The times of one batch with a number of things and with twice as many.
struct Pair {
    single_ns: f64,
    double_ns: f64,
}

impl Default for Pair {
    fn default() -> Self {
        Self { single_ns: f64::NAN, double_ns: f64::NAN }
    }
}

impl Pair {
    /// Keeps the shortest times: disturbances make them longer, never shorter.
    fn add(&mut self, single_ns: f64, double_ns: f64) {
        self.single_ns = self.single_ns.min(single_ns);
        self.double_ns = self.double_ns.min(double_ns);
    }

    /// Returns the price of one thing (ns), or NaN if nothing was measured.
    fn each_ns(&self, count: u32) -> f64 {
        (self.double_ns - self.single_ns) / f64::from(count.max(1))
    }
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Measures every price.
///
/// # Errors
/// No memory, a failed call.
pub fn measure(scene: CalibrationScene<'_>) -> Result<CostTable, Error> {
    let began = Instant::now();
    let (device, predication) = (scene.device, scene.predication);
    let mut bench = Bench::new(scene)?;
    let batches: Vec<Batch> = Batch::ALL.into_iter().filter(|it| bench.can(*it)).collect();
    let mut pairs: Vec<Pair> = batches.iter().map(|_| Pair::default()).collect();
    let mut clock = Clock::new(device)?;
    // Drivers compile shaders at the first draw.
    for batch in &batches {
        clock.time_ns(&mut bench, *batch)?;
    }
    let started = Instant::now();
    for round in 0..ROUNDS {
        if round > 0 && started.elapsed() > BUDGET {
            break;
        }
        for (batch, pair) in batches.iter().zip(&mut pairs) {
            let single = clock.time_ns(&mut bench, *batch)?;
            let double = clock.time_ns(&mut bench, batch.doubled())?;
            tracing::debug!("{batch:?}: {single:.0} ns, twice as many {double:.0} ns");
            pair.add(single, double);
        }
    }
    tracing::debug!("prepared in {:?}, measured in {:?}", started - began, started.elapsed());
    drop(clock);
    let mut each = |wanted: Batch| {
        let place = batches.iter().position(|batch| *batch == wanted);
        place.and_then(|place| pairs.get(place)).map_or(f64::NAN, |it| it.each_ns(wanted.count()))
    };
    let measured = table(&mut each, bench.large_box_pixels());
    let mut share = overlap::break_wait_share(device, &mut bench, f64::from(measured.break_ns))?;
    if device.adapter().is_software() {
        // The threads of a rasteriser share the cores with everything else: a batch that is alone
        // loses less at a break than a frame among frames does.
        share = share.max(CostTable::default().break_wait_share.into());
    }
    let table = sensible(CostTable { break_wait_share: share as f32, ..measured }, predication);
    tracing::info!("costs measured in {:?}: {table:?}", began.elapsed());
    Ok(table)
}

/// Returns the prices that follow from the price per thing of each batch.
fn table(each: &mut impl FnMut(Batch) -> f64, large_box_pixels: f64) -> CostTable {
    let draw = each(Batch::DRAWS);
    let query = each(Batch::QUERIES) - draw;
    let flag_box = each(Batch::FLAGS);
    let pixel = |box_ns: f64| ((box_ns - flag_box) / large_box_pixels) as f32;
    let patch = each(Batch::PATCHES);
    CostTable {
        query_ns: query as f32,
        query_box_ns: (each(Batch::QUERIED_BOXES) - query) as f32,
        flag_box_ns: flag_box as f32,
        hidden_pixel_ns: pixel(each(Batch::HIDDEN_PIXELS)),
        flagged_pixel_ns: pixel(each(Batch::FLAGGED_PIXELS)),
        predicate_ns: each(Batch::PREDICATES) as f32,
        draw_ns: draw as f32,
        triangle_ns: ((patch - draw) / f64::from(batch::PATCH_TRIANGLES)) as f32,
        break_ns: each(Batch::BREAKS) as f32,
        break_wait_share: 0.0,
        compute_round_ns: each(Batch::GRIDS) as f32,
        compute_box_ns: each(Batch::COMPUTED_BOXES) as f32,
    }
}

/// Replaces impossible prices by the default. A small price may come out negative: then it is too
/// small to be distinguished from noise, and counts as nothing.
fn sensible(measured: CostTable, predication: Predication) -> CostTable {
    let usual = CostTable::default();
    let mut doubtful = Vec::new();
    let mut kept = |(name, value): (&'static str, f32), usual: f32| {
        // A hundredth of the usual below zero is noise; a hundred times as much is a broken clock.
        let is_sound = value.is_finite() && value > -usual && value < usual.max(1.0) * 1.0e4;
        if !is_sound {
            doubtful.push(format!("{name} = {value}"));
        }
        if is_sound { value.max(0.0) } else { usual }
    };
    let [measured, usual] = [measured.entries(), usual.entries()];
    let values: Vec<f32> =
        measured.into_iter().zip(usual).map(|(entry, (_, usual))| kept(entry, usual)).collect();
    let by = predication.name();
    // The share is bounded in any case.
    if doubtful.len() + 1 >= measured.len() {
        tracing::warn!("no cost could be measured with {by}: all count as usual");
    } else if !doubtful.is_empty() {
        // Any one of them may drown in the noise of a busy machine.
        let doubtful = doubtful.join(", ");
        tracing::debug!("these costs came out impossible with {by} and count as usual: {doubtful}");
    }
    CostTable::from_values(|place| values.get(place).copied().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_broken_clock_measures_counts_as_usual() {
        let usual = CostTable::default();
        let predication = Predication::Conditional;
        assert_eq!(sensible(usual, predication), usual);
        for value in [f32::NAN, f32::INFINITY, -1.0e9, f32::MAX] {
            let broken = CostTable::from_values(|_| value);
            assert_eq!(sensible(broken, predication), usual);
            let one = CostTable { draw_ns: value, query_ns: 3.0, ..usual };
            assert_eq!(sensible(one, predication), CostTable { query_ns: 3.0, ..usual });
        }
        let noise = CostTable { predicate_ns: -2.0, ..usual };
        assert_eq!(sensible(noise, predication), CostTable { predicate_ns: 0.0, ..usual });
    }

    #[test]
    fn prices_are_differences_of_batches() {
        let mut each = |batch: Batch| match batch {
            Batch::DRAWS => 10.0,
            Batch::QUERIES => 17.0,
            Batch::QUERIED_BOXES => 12.0,
            Batch::FLAGS => 3.0,
            Batch::HIDDEN_PIXELS => 103.0,
            Batch::FLAGGED_PIXELS => 203.0,
            Batch::PATCHES => 10.0 + 2.0 * f64::from(batch::PATCH_TRIANGLES),
            _ => 5.0,
        };
        let table = table(&mut each, 100.0);
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
