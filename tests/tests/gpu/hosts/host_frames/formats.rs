//! The formats, samples, render passes and projections of hosts.

use ash::vk;
use cull::{ClipY, DepthConvention, Projection, Strategy};
use glam::Vec2;
use gpu::PredicationMode;
use tests::projections::Lens;
use tests::{Driver, drivers};

use super::host::{HostOptions, Passes, Submits, compare};

#[test]
fn depth_of_16_and_24_bits_and_beside_a_stencil_is_exact() {
    for driver in drivers() {
        let mut formats = vec![vk::Format::D16_UNORM, vk::Format::D32_SFLOAT_S8_UINT];
        // Google's driver does not support depths of 24 bits.
        formats.extend((driver == Driver::Lavapipe).then_some(vk::Format::D24_UNORM_S8_UINT));
        for depth in formats {
            let options = HostOptions { depth, ..HostOptions::default() };
            let draws = compare(driver, &options, |_| Submits::Once);
            assert!(draws.culled < draws.plain / 2, "{driver:?}, {depth:?}: {draws:?}");
        }
    }
}

#[test]
fn several_samples_per_pixel_are_exact() {
    for driver in drivers() {
        let samples = vk::SampleCountFlags::TYPE_4;
        let options = HostOptions { samples, ..HostOptions::default() };
        let draws = compare(driver, &options, |_| Submits::Once);
        assert!(draws.culled < draws.plain / 2, "{driver:?}: {draws:?}");
    }
}

#[test]
fn render_pass_objects_of_the_host_are_exact() {
    for driver in drivers() {
        let options = HostOptions { passes: Passes::Host, ..HostOptions::default() };
        let draws = compare(driver, &options, |_| Submits::Once);
        assert!(draws.culled < draws.plain / 2, "{driver:?}: {draws:?}");
    }
}

#[test]
fn every_projection_and_direction_of_depth_is_exact() {
    // The drivers take turns with the testers.
    project(|driver, number, depth| {
        let ways = ways(driver, depth);
        let turn = number + usize::from(driver == Driver::SwiftShader);
        vec![ways[turn % ways.len()]]
    });
}

#[test]
#[ignore = "long walk"]
fn every_projection_and_direction_of_depth_is_exact_with_every_tester() {
    project(|driver, _, depth| ways(driver, depth));
}

/// A tester, and a way to skip draws.
type Way = (Strategy, Option<PredicationMode>);

/// Walks with every projection and direction of depth, by the ways of its number.
fn project(ways: impl Fn(Driver, usize, vk::Format) -> Vec<Way>) {
    let jittered = Lens { jitter_pixels: 0.6, ..Lens::PLAIN };
    let standard = Lens { depth: DepthConvention::Standard, ..jittered };
    let far = Lens { far: Some(30.0), off_centre: Vec2::new(-0.3, 0.5), ..jittered };
    let standard_far = Lens { depth: DepthConvention::Standard, y: ClipY::Up, ..far };
    let perspective = Projection::perspective(0.9);
    let orthographic = Projection::Orthographic { height: 9.0, far: 40.0 };
    let float = vk::Format::D32_SFLOAT;
    let integer = vk::Format::D16_UNORM;
    for driver in drivers() {
        let cases = [
            (perspective, jittered, float),
            (perspective, standard, float),
            (perspective, standard, integer),
            (perspective, far, float),
            (perspective, standard_far, float),
            (orthographic, jittered, float),
            (orthographic, jittered, integer),
            (orthographic, standard, float),
        ];
        for (number, (projection, lens, depth)) in cases.into_iter().enumerate() {
            for (strategy, predication) in ways(driver, number, depth) {
                let options = HostOptions {
                    projection,
                    lens,
                    depth,
                    strategy,
                    predication,
                    ..HostOptions::default()
                };
                let draws = compare(driver, &options, |_| Submits::Once);
                assert!(draws.culled < draws.plain, "{driver:?}, {options:?}: {draws:?}");
            }
        }
    }
}

/// Returns every tester that supports depths of this format, with different ways to skip draws if
/// the driver supports several.
fn ways(driver: Driver, depth: vk::Format) -> Vec<Way> {
    let counts = match driver {
        Driver::Lavapipe => PredicationMode::Counts,
        Driver::SwiftShader => PredicationMode::Instances,
    };
    let mut ways = vec![
        (Strategy::ANTUMBRA_FLAGS, None),
        (Strategy::ANTUMBRA_QUERIES, Some(PredicationMode::Instances)),
    ];
    if depth == vk::Format::D32_SFLOAT {
        ways.push((Strategy::ANTUMBRA_COMPUTE, Some(counts)));
    }
    ways
}
