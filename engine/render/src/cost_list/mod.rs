//! The cost list of a device: times of what a frame does many of, by number, measured with
//! timestamps of the GPU. It explains a device to people; the costs that decide what is tested
//! are those of `occlusion::measure`.

mod cost_bench;
mod item;

use gpu::Device;

use crate::error::Error;
use cost_bench::CostBench;
use item::interleaved_medians;
pub use item::{BoxSize, CostItem, ItemCost, PredicateResult};

/// The extent of a cost list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostListOptions {
    /// Size of the image in pixels.
    pub size: [u32; 2],
    /// The most of an item that are measured together; numbers are powers of ten up to it.
    pub most: u32,
    /// The times that each is measured.
    pub rounds: usize,
    /// The longest time of a frame: an item is not measured in numbers that would take longer
    /// (milliseconds).
    pub longest_ms: f64,
}

impl Default for CostListOptions {
    /// Returns the extent that takes some minutes on a driver without a GPU.
    fn default() -> Self {
        Self { size: [1280, 720], most: 10_000, rounds: 5, longest_ms: 400.0 }
    }
}

/// Measures the costs of a device: every item that it has, in numbers of 1, 10, 100 and so on.
/// Waits for the device again and again.
///
/// # Errors
/// No memory, a failed call, a lost device.
pub fn cost_list(device: &Device, options: &CostListOptions) -> Result<Vec<ItemCost>, Error> {
    let mut bench = CostBench::new(device, options)?;
    let mut candidates: Vec<(CostItem, u32)> = vec![];
    for item in CostItem::all() {
        let numbers = std::iter::successors(Some(1_u32), |number| number.checked_mul(10));
        for count in numbers.take_while(|count| *count <= options.most.min(item.most())) {
            if !bench.can(item, count) {
                continue;
            }
            // The first time compiles, and says if more would take too long.
            bench.time_ns(item, count)?;
            let once_ns = bench.time_ns(item, count)?;
            candidates.push((item, count));
            if once_ns * 10.0 > options.longest_ms * 1.0e6 {
                break;
            }
        }
    }
    let nothing = candidates.iter().map(|(item, _)| (*item, 0));
    let all: Vec<(CostItem, u32)> = candidates.iter().copied().chain(nothing).collect();
    let medians = interleaved_medians(&all, options.rounds.max(1), |(item, count)| {
        bench.time_ns(item, count)
    })?;
    let (with, without) = medians.split_at(candidates.len().min(medians.len()));
    let cost = |((item, count), (with, without)): (&(CostItem, u32), (&f64, &f64))| ItemCost {
        item: *item,
        count: *count,
        total_ns: with - without,
    };
    Ok(candidates.iter().zip(with.iter().zip(without)).map(cost).collect())
}
