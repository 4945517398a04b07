//! The cost list of a device: the times of actions that a frame performs many times, by their
//! number, measured with GPU timestamps. It describes a device to people. The costs that decide
//! about tests are measured by `occlusion::measure`.

mod item;

use gpu::{Device, PredicationMode};
use occlusion::{BoxBench, CalibrationScene, CostModel, ShaderSet};

use crate::calibration_scene::{self, CalibrationObjects};
use crate::error::Error;
use crate::renderer::{Renderer, RendererOptions};
use item::interleaved_medians;
pub use item::{BoxSize, CostItem, ItemCost, PredicateResult};

/// The extent of a cost list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostListOptions {
    /// Size of the image in pixels.
    pub size: [u32; 2],
    /// The highest number of an item to measure together. Numbers are powers of ten up to it.
    pub most: u32,
    /// The number of times that each item is measured.
    pub rounds: usize,
    /// The longest time of a frame (milliseconds). Numbers of an item that would take longer are
    /// not measured.
    pub longest_ms: f64,
}

impl Default for CostListOptions {
    /// Returns an extent that takes some minutes on a software driver.
    fn default() -> Self {
        Self { size: [1280, 720], most: 10_000, rounds: 5, longest_ms: 400.0 }
    }
}

/// Measures the costs of every item that a device supports, in numbers of 1, 10, 100 and so on.
/// Waits for the device many times.
///
/// # Errors
/// No memory, a failed call, a lost device.
pub fn cost_list(device: &Device, options: &CostListOptions) -> Result<Vec<ItemCost>, Error> {
    let CostListOptions { size, most, .. } = *options;
    let plain = RendererOptions { size, cost_model: CostModel::Off, ..RendererOptions::default() };
    let mut renderer = Renderer::new(device, &calibration_scene::scene(), &plain)?;
    let has = |predication: &PredicationMode| {
        PredicationMode::choose(device, Some(*predication), most.into(), 0).is_ok()
    };
    let executors: Vec<PredicationMode> = PredicationMode::ALL.into_iter().filter(has).collect();
    let shaders = ShaderSet::embedded()?;
    let mut objects = CalibrationObjects::new(&mut renderer.passes)?;
    let scene = CalibrationScene {
        device,
        shaders: &shaders,
        passes: renderer.scene.passes(),
        executors: &executors,
        draws: objects.draws,
        objects: &mut objects,
        cancellation: &plain.cancellation,
    };
    let mut bench = BoxBench::new(scene, most)?;
    bench.compare_all_fragments(&shaders)?;
    let mut candidates: Vec<(CostItem, u32)> = vec![];
    for item in CostItem::all() {
        if !bench.can(item.benched()) {
            continue;
        }
        let numbers = std::iter::successors(Some(1_u32), |number| number.checked_mul(10));
        let numbers = numbers.skip_while(|count| *count < item.least());
        for count in numbers.take_while(|count| *count <= most.min(item.most())) {
            // The first run compiles shaders, and tells if a higher number would take too long.
            bench.time_ns(item.benched(), count)?;
            let once_ns = bench.time_ns(item.benched(), count)?;
            candidates.push((item, count));
            if once_ns * 10.0 > options.longest_ms * 1.0e6 {
                break;
            }
        }
    }
    let nothing = candidates.iter().map(|(item, _)| (*item, 0));
    let all: Vec<(CostItem, u32)> = candidates.iter().copied().chain(nothing).collect();
    let medians = interleaved_medians(&all, options.rounds.max(1), |(item, count)| {
        bench.time_ns(item.benched(), count)
    })?;
    let (with, without) = medians.split_at(candidates.len().min(medians.len()));
    let cost = |((item, count), (with, without)): (&(CostItem, u32), (&f64, &f64))| ItemCost {
        item: *item,
        count: *count,
        total_ns: with - without,
    };
    Ok(candidates.iter().zip(with.iter().zip(without)).map(cost).collect())
}
