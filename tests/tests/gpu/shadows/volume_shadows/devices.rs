//! Devices with fewer features: without geometry shaders, compute shaders extrude volumes. Devices
//! that cannot count volumes are refused with a message.

use ash::vk;
use cull::Strategy;
use gpu::{Device, DeviceOptions, OptionalFeature, SampleCount};
use render::{Error, Renderer, RendererOptions};
use shadows::ShadowOptions;
use tests::fault_injection::FaultInjection;
use tests::walk::pixels_that_differ;
use tests::{Driver, instance_with, run, shadow_scene};

use super::{VOLUMES, fresh, image, renderer, volumes};
use crate::shadows::shadow_maps::casters::walking;

/// Removes features.
type Hiding = fn(&mut vk::PhysicalDeviceFeatures);

/// Runs a test on lavapipe without some features.
fn without(hides: Hiding, test: impl FnOnce(&Device)) {
    let faults = FaultInjection { hides: Some(hides), ..FaultInjection::default() };
    let instance = instance_with(faults.entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    test(&device);
    drop(device);
    assert_eq!(instance.validation_log().drain(), []);
}

#[test]
fn both_ways_of_extruding_have_the_same_image() {
    let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
    let draw = |device: &Device| {
        let mut renderer = renderer(device, &scene, volumes());
        let mut view = renderer.new_view().unwrap();
        [0, 3, 6, 9]
            .map(|frame| image(&mut renderer, &mut view, Strategy::ANTUMBRA, walking(frame)))
    };
    let mut by_geometry = None;
    run(Driver::Lavapipe, |device| {
        assert!(device.capabilities().has(OptionalFeature::GeometryShaders));
        by_geometry = Some(draw(device));
    });
    without(
        |features| features.geometry_shader = vk::FALSE,
        |device| {
            assert!(!device.capabilities().has(OptionalFeature::GeometryShaders));
            for (expected, found) in by_geometry.unwrap().iter().zip(draw(device)) {
                assert_eq!(pixels_that_differ(expected, &found), 0);
            }
        },
    );
}

#[test]
fn several_samples_per_pixel_have_no_volumes_and_that_is_said() {
    run(Driver::Lavapipe, |device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let four = RendererOptions { samples: SampleCount::Four, ..RendererOptions::default() };
        let options = RendererOptions { shadows: volumes(), ..four.clone() };
        let error = Renderer::new(device, &scene, &options).map(drop).unwrap_err();
        assert!(error.to_string().contains("one depth per pixel"), "{error}");
        let mut renderer = Renderer::new(device, &scene, &four).unwrap();
        assert!(matches!(renderer.set_shadows(volumes()), Err(Error::MultisampledVolumes)));
        assert_ne!(renderer.shadows().method, VOLUMES);
    });
}

#[test]
fn a_device_that_cannot_count_volumes_says_so_and_goes_on() {
    let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
    let lacks: [(Hiding, OptionalFeature); 2] = [
        (|features| features.depth_clamp = vk::FALSE, OptionalFeature::DepthClamp),
        (
            |features| features.fragment_stores_and_atomics = vk::FALSE,
            OptionalFeature::FragmentStores,
        ),
    ];
    for (hides, missing) in lacks {
        without(hides, |device| {
            let options = RendererOptions { shadows: volumes(), ..RendererOptions::default() };
            let error = Renderer::new(device, &scene, &options).map(drop).unwrap_err().to_string();
            assert!(error.contains(missing.name()), "{error}");
            let before = fresh(device, &scene, ShadowOptions::default(), shadow_scene::camera());
            let mut renderer = renderer(device, &scene, ShadowOptions::default());
            let mut view = renderer.new_view().unwrap();
            let error = renderer.set_shadows(volumes()).unwrap_err().to_string();
            assert!(error.contains(missing.name()), "{error}");
            assert_ne!(renderer.shadows().method, VOLUMES);
            let after = image(&mut renderer, &mut view, Strategy::FRUSTUM, shadow_scene::camera());
            assert!(before == after, "the renderer draws as before");
        });
    }
}
