//! Frames of a host in C, compared with all of its draws bit for bit.

mod host;
mod images;
mod lists;
mod pipeline;

use ash::vk;
use capi::executor::lists::{ANTUMBRA_DRAWS_BY_CALLBACK, ANTUMBRA_DRAWS_BY_LISTS};
use capi::executor::quirks::{
    ANTUMBRA_ASSUMPTION_CONDITIONAL_RENDERING, ANTUMBRA_ASSUMPTION_DRAW_COUNTS,
    ANTUMBRA_ASSUMPTION_INSTANCE_COUNTS, ANTUMBRA_ASSUMPTION_QUERY_COUNTS,
};
use capi::executor::scene::{
    ANTUMBRA_PREDICATION_BEST, ANTUMBRA_PREDICATION_COUNTS, ANTUMBRA_PREDICATION_INSTANCES,
    ANTUMBRA_RESUBMISSION_ALLOWED, ANTUMBRA_RESUBMISSION_NEVER,
};
use gpu::Purpose;
use tests::host_device::Host;
use tests::host_scene::RenderingOwner;
use tests::{Driver, drivers};

use host::DrawingHost;

/// The size of the images in pixels.
const SIZE: [u32; 2] = [96, 54];
const FRAMES: u64 = 11;

/// The choices of a host.
#[derive(Clone, Copy, Debug)]
struct FrameOptions {
    depth: vk::Format,
    samples: vk::SampleCountFlags,
    renderings: RenderingOwner,
    predication: u32,
    query_budget: usize,
    draws: u32,
    resubmission: u32,
    disabled: u32,
    costs: Costs,
}

/// The costs in the options of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Costs {
    /// No costs.
    None,
    /// Costs that were measured on the device with its queue.
    Measured,
}

impl Default for FrameOptions {
    fn default() -> Self {
        Self {
            depth: vk::Format::D32_SFLOAT,
            samples: vk::SampleCountFlags::TYPE_1,
            renderings: RenderingOwner::Engine,
            predication: ANTUMBRA_PREDICATION_BEST,
            query_budget: 0,
            draws: ANTUMBRA_DRAWS_BY_CALLBACK,
            resubmission: ANTUMBRA_RESUBMISSION_ALLOWED,
            disabled: 0,
            costs: Costs::None,
        }
    }
}

/// Draws a walk in which objects are removed and change their buckets. Returns the largest number
/// of queries in a frame.
fn compare(driver: Driver, options: &FrameOptions) -> u64 {
    let host = Host::new(driver, Purpose::Executor);
    let mut drawing = DrawingHost::new(&host, options);
    for frame in 0..FRAMES {
        match frame {
            5 => drawing.remove_some(),
            8 => drawing.change_draws(),
            _ => {}
        }
        drawing.draw(frame);
    }
    let what = format!("{driver:?}, {options:?}");
    let has_lists = options.draws == ANTUMBRA_DRAWS_BY_LISTS;
    assert_eq!(drawing.revealed_lists > 0, has_lists, "{what}");
    let (fewest, most_queries) = drawing.finish(&what);
    // Objects for which no query is left are drawn.
    let most = if options.query_budget == 0 { 600 } else { u64::MAX };
    assert!(fewest.iter().all(|objects| (1..most).contains(objects)), "{what}: {fewest:?}");
    host.finish();
    most_queries
}

#[test]
fn several_draws_buckets_and_views_are_exact_in_c() {
    for driver in drivers() {
        let other = match driver {
            Driver::Lavapipe => ANTUMBRA_PREDICATION_COUNTS,
            Driver::SwiftShader => ANTUMBRA_PREDICATION_INSTANCES,
        };
        for (predication, resubmission) in [
            (ANTUMBRA_PREDICATION_BEST, ANTUMBRA_RESUBMISSION_ALLOWED),
            (other, ANTUMBRA_RESUBMISSION_NEVER),
        ] {
            compare(driver, &FrameOptions { predication, resubmission, ..FrameOptions::default() });
        }
    }
}

#[test]
fn several_samples_per_pixel_are_exact_in_c() {
    for driver in drivers() {
        let samples = vk::SampleCountFlags::TYPE_4;
        compare(driver, &FrameOptions { samples, ..FrameOptions::default() });
    }
}

#[test]
fn render_passes_of_the_host_are_exact_in_c() {
    for driver in drivers() {
        for samples in [vk::SampleCountFlags::TYPE_1, vk::SampleCountFlags::TYPE_4] {
            let renderings = RenderingOwner::Host;
            compare(driver, &FrameOptions { renderings, samples, ..FrameOptions::default() });
        }
    }
}

#[test]
fn depth_of_16_and_24_bits_and_beside_a_stencil_is_exact_in_c() {
    for driver in drivers() {
        let mut formats = vec![vk::Format::D16_UNORM, vk::Format::D32_SFLOAT_S8_UINT];
        // Google's driver does not support depths of 24 bits.
        formats.extend((driver == Driver::Lavapipe).then_some(vk::Format::D24_UNORM_S8_UINT));
        for depth in formats {
            compare(driver, &FrameOptions { depth, ..FrameOptions::default() });
        }
    }
}

#[test]
fn views_share_one_budget_of_queries_in_c() {
    for driver in drivers() {
        let apart = compare(driver, &FrameOptions::default());
        let query_budget = apart as usize / 2;
        let together = compare(driver, &FrameOptions { query_budget, ..FrameOptions::default() });
        assert!((1..=apart / 2).contains(&together), "{together} of {apart}");
    }
}

#[test]
fn draws_that_a_host_records_from_lists_are_exact_in_c() {
    for driver in drivers() {
        for samples in [vk::SampleCountFlags::TYPE_1, vk::SampleCountFlags::TYPE_4] {
            let draws = ANTUMBRA_DRAWS_BY_LISTS;
            compare(driver, &FrameOptions { draws, samples, ..FrameOptions::default() });
        }
    }
}

#[test]
fn what_is_distrusted_is_not_used_in_c() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Executor);
        let of = |disabled| {
            let options = FrameOptions { disabled, ..FrameOptions::default() };
            let mut drawing = DrawingHost::new(&host, &options);
            (0..FRAMES).for_each(|frame| drawing.draw(frame));
            let stats = drawing.stats();
            drawing.finish(&format!("{driver:?}, {options:?}"));
            stats
        };
        let skips = ANTUMBRA_ASSUMPTION_CONDITIONAL_RENDERING | ANTUMBRA_ASSUMPTION_DRAW_COUNTS;
        let stats = of(skips);
        assert_eq!(stats.predication, ANTUMBRA_PREDICATION_INSTANCES, "{driver:?}");
        assert!(stats.tests > 0 && stats.has_cost == 0, "{stats:?}");
        let stats = of(ANTUMBRA_ASSUMPTION_QUERY_COUNTS);
        assert!(stats.tests > 0 && stats.queries == 0, "{stats:?}");
        let stats = of(skips | ANTUMBRA_ASSUMPTION_INSTANCE_COUNTS);
        assert_eq!((stats.tests, stats.queries), (0, 0), "nothing can be skipped");
        host.finish();
    }
}

#[test]
fn scenes_by_measured_costs_are_exact_in_c() {
    for driver in drivers() {
        for draws in [ANTUMBRA_DRAWS_BY_CALLBACK, ANTUMBRA_DRAWS_BY_LISTS] {
            let costs = Costs::Measured;
            let host = Host::new(driver, Purpose::Renderer);
            let options = FrameOptions { costs, draws, ..FrameOptions::default() };
            let mut drawing = DrawingHost::new(&host, &options);
            (0..FRAMES).for_each(|frame| drawing.draw(frame));
            assert_eq!(drawing.stats().has_cost, 1);
            drawing.finish(&format!("{driver:?}, {options:?}"));
            host.finish();
        }
    }
}
