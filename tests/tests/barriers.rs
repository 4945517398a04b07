//! Barriers and resets that no validation layer misses, and that images do not depend on with
//! software drivers.
#![forbid(unsafe_code)]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::collections::BTreeSet;

use cull::Strategy;
use gpu::{
    Access, Device, DeviceOptions, FlagRing, FrameRing, MemoryBarrier, OptionalFeature,
    ResultSource,
};
use render::{CostModel, FrameRequest, Renderer, RendererOptions, SpareCapacity};
use scene::PreparedMesh;
use scenes::PathKind;
use tests::fault_injection::{FaultInjection, guarded_reads};
use tests::walk::{SceneKind, cameras_along};
use tests::{Driver, instance_with, run_on_all};

#[test]
fn results_are_read_behind_barriers() {
    let scene = SceneKind::City.build(400);
    for driver in Driver::ALL {
        let faults = FaultInjection { records_barriers: true, ..FaultInjection::default() };
        let instance = instance_with(faults.entry());
        let adapter = instance.pick_adapter(Some(driver.device_name())).unwrap();
        let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        let options = RendererOptions {
            size: [128, 72],
            cost_model: CostModel::Off,
            ..RendererOptions::default()
        };
        let mut renderer = Renderer::new(&device, &scene.scene, &options).unwrap();
        guarded_reads();
        let is_conditional = device.capabilities().has(OptionalFeature::ConditionalRendering);
        for strategy in [Strategy::ANTUMBRA, Strategy::ANTUMBRA_QUERIES] {
            let mut view = renderer.new_view().unwrap();
            let mut enabled = 0;
            let mut predicates = 0;
            for camera in cameras_along(&scene, PathKind::Street, 12) {
                renderer.render(&mut view, FrameRequest::new(strategy, camera)).unwrap();
                let reads = guarded_reads();
                assert_eq!(reads.unguarded, BTreeSet::new(), "{strategy} on {driver:?}");
                assert!(reads.copies > 0, "{strategy} on {driver:?}");
                enabled += reads.enabled;
                predicates += reads.predicates;
            }
            renderer.wait_idle(&mut view).unwrap();
            assert_eq!(predicates > 0, is_conditional, "{strategy} on {driver:?}");
            assert!(enabled > 0 || strategy != Strategy::ANTUMBRA, "{driver:?}");
        }
        drop((renderer, device));
        assert_eq!(instance.validation_log().drain(), []);
    }
}

#[test]
fn streams_wait_for_the_frames_before_them() {
    let scene = SceneKind::City.build(40);
    let faults = FaultInjection { records_barriers: true, ..FaultInjection::default() };
    let instance = instance_with(faults.entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let spare =
        SpareCapacity { meshes: 1, vertices: 1 << 12, indices: 1 << 12, ..Default::default() };
    let options = RendererOptions { size: [128, 72], spare, ..RendererOptions::default() };
    let mut renderer = Renderer::new(&device, &scene.scene, &options).unwrap();
    let mut view = renderer.new_view().unwrap();
    guarded_reads();
    for camera in cameras_along(&scene, PathKind::Street, 4) {
        let mesh = PreparedMesh::new(scene.scene.meshes[0].clone()).unwrap();
        let added = renderer.add_meshes(vec![mesh]).unwrap();
        renderer.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, camera)).unwrap();
        let reads = guarded_reads();
        assert!(!reads.unguarded.iter().any(|what| what.contains("a stream")));
        assert_eq!(reads.streams, 1);
        renderer.remove_meshes(&added).unwrap();
        renderer.wait_idle(&mut view).unwrap();
    }
    drop((view, renderer, device));
    assert_eq!(instance.validation_log().drain(), []);
}

#[test]
fn flags_of_a_slot_begin_at_zero() {
    run_on_all(|device| {
        let mut ring = FrameRing::new(device, 1).unwrap();
        let mut flags = FlagRing::new(device, 1, ResultSource::Fragments, "flags of a test");
        // Every other frame writes flags, as fragments would.
        for value in [1, 0, 1, 0] {
            let frame = ring.begin().unwrap();
            flags.begin(&frame, 0..5_u32).unwrap();
            if value > 0 {
                let between = MemoryBarrier::between(&[Access::CopyWrite], &[Access::CopyWrite]);
                frame.commands().barrier(between);
                frame.commands().fill(flags.results().unwrap(), value);
            }
            flags.read_back(frame.commands());
            flags.submitted(frame.submit(None).unwrap());
            device.wait_idle().unwrap();
            let mut found = Vec::new();
            flags.collect(device.completed().unwrap(), |_, values| found.extend_from_slice(values));
            assert_eq!(found, [value; 5]);
        }
    });
}
