//! The formats, samples and render passes of hosts.

use ash::vk;
use tests::Driver;

use super::host::{HostOptions, Passes, Submits, compare};

#[test]
fn depth_of_16_and_24_bits_and_beside_a_stencil_is_exact() {
    for driver in Driver::ALL {
        for depth in [
            vk::Format::D16_UNORM,
            vk::Format::D32_SFLOAT_S8_UINT,
            match driver {
                Driver::Lavapipe => vk::Format::D24_UNORM_S8_UINT,
                Driver::SwiftShader => vk::Format::D16_UNORM,
            },
        ] {
            let options = HostOptions { depth, ..HostOptions::default() };
            let draws = compare(driver, &options, |_| Submits::Once);
            assert!(draws.culled < draws.plain / 2, "{driver:?}, {depth:?}: {draws:?}");
        }
    }
}

#[test]
fn several_samples_per_pixel_are_exact() {
    for driver in Driver::ALL {
        let samples = vk::SampleCountFlags::TYPE_4;
        let options = HostOptions { samples, ..HostOptions::default() };
        let draws = compare(driver, &options, |_| Submits::Once);
        assert!(draws.culled < draws.plain / 2, "{driver:?}: {draws:?}");
    }
}

#[test]
fn render_pass_objects_of_the_host_are_exact() {
    for driver in Driver::ALL {
        let options = HostOptions { passes: Passes::Host, ..HostOptions::default() };
        let draws = compare(driver, &options, |_| Submits::Once);
        assert!(draws.culled < draws.plain / 2, "{driver:?}: {draws:?}");
    }
}
