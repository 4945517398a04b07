//! The draws of rounds as Vulkan calls: one call per range, or one per bucket and rendering.

use cull::Strategy;
use gpu::{Device, DeviceOptions, PredicationMode, Readback};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::fault_injection::{CALL_THAT_COUNTS_DRAWS, FaultInjection, calls};
use tests::{Driver, instance_with};

const FRAMES: u32 = 30;

/// The calls with draw counts in a walk, the ranges that its tests decided about, and its last
/// image.
struct Walked {
    calls: u64,
    ranges: u64,
    image: Vec<u8>,
}

/// Walks through a city. Each frame knows the results of the previous frame.
fn walk(predication: PredicationMode) -> Walked {
    let GeneratedScene { scene, routes } = city(1500, 1).unwrap();
    let path = CameraPath::new(PathKind::Cut, &routes).unwrap();
    let instance = instance_with(FaultInjection::default().entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let options = RendererOptions {
        size: [160, 90],
        frames_in_flight: 1,
        predication: Some(predication),
        cost_model: CostModel::Off,
        ..Default::default()
    };
    let mut renderer = Renderer::new(&device, &scene, &options).unwrap();
    let image = Readback::new(&device, renderer.size()).unwrap();
    let mut view = renderer.new_view().unwrap();
    let mut ranges = 0;
    FaultInjection::default().install();
    for frame in 0..FRAMES {
        let request = FrameRequest {
            image: Some(&image),
            ..FrameRequest::new(Strategy::ANTUMBRA, path.camera(frame))
        };
        let report = renderer.render(&mut view, request).unwrap();
        ranges += u64::from(report.predicated_draws);
        renderer.wait_idle(&mut view).unwrap();
    }
    let calls = calls(CALL_THAT_COUNTS_DRAWS) as u64;
    let walked = Walked { calls, ranges, image: image.rgba8().unwrap().to_vec() };
    drop((view, renderer, image, device));
    assert_eq!(instance.validation_log().drain(), []);
    walked
}

#[test]
fn compacted_rounds_are_drawn_by_one_call_each() {
    const RENDERINGS_MAX: u64 = 6;
    let [counted, compacted] = [PredicationMode::Counts, PredicationMode::Compacted].map(walk);
    assert!(counted.image == compacted.image);
    assert_eq!(counted.ranges, compacted.ranges);
    // Both draw the visible objects by the same number of calls.
    let of_visible = counted.calls - counted.ranges;
    let of_lists = compacted.calls - of_visible;
    let most = RENDERINGS_MAX * u64::from(FRAMES);
    assert!(of_lists > 0 && of_lists <= most, "{of_lists} lists in {FRAMES} frames");
    assert!(counted.ranges > 3 * most, "{} ranges are few", counted.ranges);
}
