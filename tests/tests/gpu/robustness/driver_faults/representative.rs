//! Representative fragments: used for flags if the device supports them, and never if fragments are
//! counted.

use cull::Strategy;
use gpu::{Device, DeviceOptions, OptionalFeature, Readback};
use render::{CostItem, CostListOptions, FrameRequest, ItemCost, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::fault_injection::{FaultInjection, OTHER_PIPELINES, REPRESENTATIVE_PIPELINES, calls};
use tests::{Driver, instance_with};

/// Draws a few frames. Returns the image, and the numbers of pipelines for representative fragments
/// and for all fragments.
fn drawn(faults: FaultInjection) -> (Vec<u8>, [usize; 2]) {
    let has_them = faults.is_representative;
    let GeneratedScene { scene, routes } = city(200, 1).unwrap();
    let path = CameraPath::new(PathKind::Street, &routes).unwrap();
    let instance = instance_with(faults.entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    assert_eq!(adapter.capabilities.has(OptionalFeature::RepresentativeFragments), has_them);
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let options = RendererOptions { methods: methods::all(), size: [64, 48], ..Default::default() };
    let mut renderer = Renderer::new(&device, &scene, &options).unwrap();
    let image = Readback::new(&device, renderer.size()).unwrap();
    for strategy in [Strategy::ANTUMBRA_FLAGS, Strategy::ANTUMBRA_QUERIES, methods::CHC] {
        let mut view = renderer.new_view().unwrap();
        for frame in 0..3 {
            let request = FrameRequest {
                image: Some(&image),
                ..FrameRequest::new(strategy, path.camera(frame))
            };
            renderer.render(&mut view, request).unwrap();
        }
        renderer.wait_idle(&mut view).unwrap();
    }
    let pipelines = [REPRESENTATIVE_PIPELINES, OTHER_PIPELINES].map(calls);
    let options = CostListOptions { size: [32, 16], most: 10, rounds: 1, longest_ms: 100.0 };
    let costs = render::cost_list(&device, &options).unwrap();
    let is_of_all = |cost: &&ItemCost| matches!(cost.item, CostItem::BoxesOfAllFragments(_));
    // 1 and 10 boxes of each of two sizes.
    assert_eq!(costs.iter().filter(is_of_all).count(), if has_them { 4 } else { 0 });
    let pixels = image.rgba8().unwrap().to_vec();
    drop((image, renderer, device));
    assert_eq!(instance.validation_log().drain(), []);
    (pixels, pipelines)
}

#[test]
fn representative_fragments_are_for_flags_and_not_for_counts() {
    let instance = instance_with(FaultInjection::default().entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    if adapter.capabilities.has(OptionalFeature::RepresentativeFragments) {
        eprintln!("not tested: {} has representative fragments itself", adapter.name);
        return;
    }
    drop((adapter, instance));
    let (with, [flags, others]) =
        drawn(FaultInjection { is_representative: true, ..FaultInjection::default() });
    let (without, [none, all]) = drawn(FaultInjection::default());
    assert!(with == without);
    // Pipelines for proxies of nodes, of leaves with one draw, and of leaves with lists of draws.
    assert_eq!((flags, none), (3, 0));
    assert_eq!(flags + others, all);
}
