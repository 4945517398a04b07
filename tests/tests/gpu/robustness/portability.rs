//! Devices like those of MoltenVK and of phones, on a real driver whose features are hidden.

use ash::vk;
use cull::Strategy;
use gpu::{Device, DeviceOptions, OptionalFeature};
use render::{CostModel, RendererOptions, Viewpoint};
use scenes::PathKind;
use shadows::{ShadowMethod, ShadowOptions};
use tests::fault_injection::{FaultInjection, is_portability_subset_enabled};
use tests::walk::{ComparedWalk, SceneKind, cameras_along};
use tests::{Driver, instance_with, shadow_scene};

use crate::shadows::shadow_maps::casters::walking;

/// Runs a test on both drivers without what MoltenVK 1.3 lacks: conditional rendering, geometry
/// shaders, draw counts, transform feedback; and without what many phones lack: lines, anisotropy,
/// descriptor indexing, queries that the CPU resets, more storage buffers per stage than the engine
/// requires. The extension for portability is pretended.
fn run_without_desktop_features(test: impl Fn(&Device)) {
    for driver in Driver::ALL {
        let faults = FaultInjection {
            is_portability_subset: true,
            is_unconditional: true,
            has_no_draw_counts: true,
            has_no_indexing: true,
            resets_by_commands: true,
            stage_storage_buffers: Some(7),
            hides: Some(|features| {
                features.geometry_shader = vk::FALSE;
                features.tessellation_shader = vk::FALSE;
                features.fill_mode_non_solid = vk::FALSE;
                features.sampler_anisotropy = vk::FALSE;
                features.texture_compression_bc = vk::FALSE;
            }),
            ..FaultInjection::default()
        };
        let instance = instance_with(faults.entry());
        let adapter = instance.pick_adapter(Some(driver.device_name())).unwrap();
        let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        assert!(is_portability_subset_enabled(), "VUID-VkDeviceCreateInfo-pProperties-04451");
        for hidden in [
            OptionalFeature::ConditionalRendering,
            OptionalFeature::DrawIndirectCount,
            OptionalFeature::GeometryShaders,
            OptionalFeature::TessellationCapture,
            OptionalFeature::DescriptorIndexing,
            OptionalFeature::HostQueryReset,
            OptionalFeature::SectionBuffers,
        ] {
            assert!(!device.capabilities().has(hidden), "{hidden:?}");
        }
        test(&device);
        drop(device);
        assert_eq!(instance.validation_log().drain(), []);
    }
}

fn options() -> RendererOptions {
    RendererOptions {
        methods: methods::all(),
        size: [160, 90],
        cost_model: CostModel::Off,
        ..RendererOptions::default()
    }
}

/// Returns the exact strategies of the device. The ideal is a list of what was seen, which no walk
/// of these tests makes.
fn exact_strategies<T: Copy + Into<Viewpoint>>(walk: &ComparedWalk<'_, T>) -> Vec<Strategy> {
    let mut exact = methods::strategies();
    exact.retain(|strategy| {
        strategy.is_exact() && !strategy.needs_still_scene() && walk.supports(*strategy)
    });
    assert!(exact.len() >= 8, "{exact:?}");
    exact
}

#[test]
fn every_exact_strategy_is_exact_without_the_features_of_desktops() {
    run_without_desktop_features(|device| {
        let scene = SceneKind::City.build(300);
        let cameras = cameras_along(&scene, PathKind::Cut, 6);
        let mut walk = ComparedWalk::new(device, &scene.scene, &cameras, &options());
        for strategy in exact_strategies(&walk) {
            let found = walk.with(strategy);
            assert_eq!(found.pixels_wrong, 0, "{strategy}: {found:?}");
        }
    });
}

#[test]
fn shadows_are_exact_without_the_features_of_desktops() {
    run_without_desktop_features(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let cameras: Vec<_> = (0..6).map(walking).collect();
        for method in [ShadowMethod::Maps, ShadowMethod::Volumes] {
            let shadows = ShadowOptions { method, layers_max: 16, ..ShadowOptions::default() };
            let options = RendererOptions { shadows, ..options() };
            let mut walk = ComparedWalk::new(device, &scene, &cameras, &options);
            for strategy in exact_strategies(&walk) {
                let found = walk.with(strategy);
                assert_eq!(found.pixels_wrong, 0, "{method:?} {strategy}: {found:?}");
            }
        }
    });
}
