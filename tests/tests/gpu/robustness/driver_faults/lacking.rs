//! Machines that lack something, or do not start: each is refused with a message.

use ash::vk;
use cull::Strategy;
use gpu::{
    Counting, Device, DeviceOptions, Error, FrameRing, IndirectDraw, Instance, Predicates,
    PredicationMode, QueryRing, Readback, RequiredFeature,
};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::captured_log::CapturedLog;
use tests::fault_injection::{
    CALL_THAT_LISTS, CALLS_THAT_RESET, CALLS_THAT_START, Fault, FaultInjection, calls,
};
use tests::{Driver, instance_with, take_turn};
use tracing_subscriber::prelude::*;

/// Returns the error of opening an instance without validation on `machine` and picking a device
/// there.
fn refusal(faults: FaultInjection, wanted: Option<&str>) -> Error {
    take_turn();
    let options = gpu::InstanceOptions::default();
    let instance = Instance::new(faults.entry(), &options);
    let picked = instance.and_then(|instance| instance.pick_adapter(wanted));
    picked.map(|adapter| adapter.name).expect_err("an error")
}

#[test]
fn an_old_loader_is_refused_with_its_version() {
    for (version, found) in [(vk::make_api_version(0, 1, 1, 70), "1.1.70"), (0, "1.0.0")] {
        let faults = FaultInjection { loader_version: Some(version), ..FaultInjection::default() };
        let error = refusal(faults, None);
        assert!(matches!(&error, Error::OldLoader { found: f } if f == found), "{error}");
        assert!(error.to_string().contains("needs 1.3"), "{error}");
    }
}

#[test]
fn no_device_means_no_driver() {
    let fails = |call, code| FaultInjection {
        faults: vec![Fault { call, fails: 0..usize::MAX, code }],
        ..FaultInjection::default()
    };
    for faults in [
        FaultInjection { has_no_devices: true, ..FaultInjection::default() },
        fails(c"vkEnumeratePhysicalDevices", vk::Result::ERROR_INITIALIZATION_FAILED),
        fails(c"vkCreateInstance", vk::Result::ERROR_INCOMPATIBLE_DRIVER),
    ] {
        for wanted in [None, Some("llvmpipe"), Some("0")] {
            let error = refusal(faults.clone(), wanted);
            assert!(matches!(error, Error::NoDriver(_)), "{error}");
        }
    }
}

#[test]
fn a_device_is_refused_by_the_name_of_what_it_lacks() {
    let name = Driver::Lavapipe.device_name();
    for lacks in RequiredFeature::ALL {
        let faults = FaultInjection { lacks: Some(lacks), ..FaultInjection::default() };
        let error = refusal(faults.clone(), None);
        assert!(matches!(error, Error::NoSuitableDevice { .. }), "{error}");
        let expected = format!("lacks {}", lacks.name());
        let text = error.to_string();
        assert!(text.contains(&expected) && text.contains(name), "{text}");

        let error = refusal(faults, Some(name));
        assert!(matches!(error, Error::DeviceLacks { .. }), "{error}");
        assert!(error.to_string().contains(&expected), "{error}");
    }
}

#[test]
fn a_device_that_lacks_something_is_not_opened_either() {
    let faults = FaultInjection {
        lacks: Some(RequiredFeature::MultiDrawIndirect),
        ..FaultInjection::default()
    };
    let instance = instance_with(faults.entry());
    let adapters = instance.adapters().unwrap();
    let opened = Device::new(&instance, &adapters[0], &DeviceOptions::default());
    let error = opened.err().expect("an error").to_string();
    assert!(error.contains("lacks multiDrawIndirect"), "{error}");
}

#[test]
fn a_device_that_cannot_be_described_is_left_out() {
    take_turn();
    let code = vk::Result::ERROR_OUT_OF_HOST_MEMORY;
    let fails = |fails| FaultInjection {
        faults: vec![Fault { call: CALL_THAT_LISTS, fails, code }],
        ..FaultInjection::default()
    };
    let instance = |faults: FaultInjection| {
        Instance::new(faults.entry(), &gpu::InstanceOptions::default()).unwrap()
    };
    let names = |adapters: Vec<gpu::Adapter>| -> Vec<String> {
        adapters.into_iter().map(|adapter| adapter.name).collect()
    };
    let all = names(instance(fails(0..0)).adapters().unwrap());
    assert!(all.len() > 1, "{all:?}");
    let log = CapturedLog::default();
    let writer = log.clone();
    let subscriber = tracing_subscriber::fmt().with_writer(move || writer.clone());
    let logged = subscriber.set_default();
    assert_eq!(names(instance(fails(0..1)).adapters().unwrap()), all[1..]);
    drop(logged);
    let refused = instance(fails(0..1)).pick_adapter(Some(&all[0])).unwrap_err();
    let all_fail = instance(fails(0..usize::MAX)).adapters().unwrap_err();
    for text in [log.take(), refused.to_string(), all_fail.to_string()] {
        let call = CALL_THAT_LISTS.to_str().unwrap();
        assert!(text.contains(call) && text.contains("ERROR_OUT_OF_HOST_MEMORY"), "{text}");
    }
}

#[test]
fn draw_counts_are_taken_where_they_hold_all_draws() {
    for (is_unconditional, best) in
        [(true, PredicationMode::Counts), (false, PredicationMode::Conditional)]
    {
        let faults =
            FaultInjection { most_draws: Some(100), is_unconditional, ..FaultInjection::default() };
        let instance = instance_with(faults.entry());
        let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
        let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        let predicates = |predication, draws| {
            Predicates::new(&device, predication, &vec![IndirectDraw::default(); draws], 1)
        };
        let chosen = |draws| predicates(None, draws).unwrap().predication();
        let fallback = if is_unconditional { PredicationMode::Instances } else { best };
        assert_eq!((chosen(100), chosen(101)), (best, fallback));
        for counted in [PredicationMode::Counts, PredicationMode::Compacted] {
            assert!(predicates(Some(counted), 100).is_ok());
            let error = predicates(Some(counted), 101).err().expect("an error").to_string();
            assert!(error.contains("101") && error.contains("at most 100"), "{error}");
        }
        assert_eq!(instance.validation_log().drain(), []);
    }
}

#[test]
fn a_device_that_does_not_count_says_so_when_asked_to_count() {
    let faults = FaultInjection { is_imprecise: true, ..FaultInjection::default() };
    let instance = instance_with(faults.entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let GeneratedScene { scene, routes } = city(50, 1).unwrap();
    let path = CameraPath::new(PathKind::Street, &routes).unwrap();
    let options = RendererOptions { methods: methods::all(), size: [32, 32], ..Default::default() };
    let mut renderer = Renderer::new(&device, &scene, &options).unwrap();
    let mut view = renderer.new_view().unwrap();
    for error in
        [renderer.supports_counts().unwrap_err(), view.watch(&[cull::ObjectId(1)]).unwrap_err()]
    {
        let error = error.to_string();
        assert!(error.contains("lacks occlusionQueryPrecise, which counting visible"), "{error}");
    }
    let options = RendererOptions { threshold_samples: 4, ..options };
    let error = Renderer::new(&device, &scene, &options).err().unwrap().to_string();
    assert!(error.contains("occlusionQueryPrecise, which a visibility threshold"), "{error}");
    let mut queries = QueryRing::<()>::new(&device, 1, "counted").unwrap();
    queries.set_counting(Counting::Samples);
    let mut frames = FrameRing::new(&device, 1).unwrap();
    let error = queries.begin(&mut frames.begin().unwrap(), &[()]).unwrap_err().to_string();
    assert!(error.contains("occlusionQueryPrecise, which queries that count"), "{error}");
    view.watch(&[]).unwrap();
    renderer.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, path.camera(0))).unwrap();
    renderer.wait_idle(&mut view).unwrap();
    assert_eq!(view.visible_samples(), []);
    drop((queries, frames, renderer, view, device));
    assert_eq!(instance.validation_log().drain(), []);
}

#[test]
fn queries_are_reset_by_commands_only_where_the_cpu_cannot() {
    let GeneratedScene { scene, routes } = city(200, 1).unwrap();
    let path = CameraPath::new(PathKind::Street, &routes).unwrap();
    let images = [false, true].map(|resets_by_commands| {
        let faults = FaultInjection { resets_by_commands, ..FaultInjection::default() };
        let instance = instance_with(faults.entry());
        let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
        let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        let options = RendererOptions {
            methods: methods::all(),
            size: [64, 48],
            // The costs of both are measured.
            cost_model: CostModel::Off,
            ..Default::default()
        };
        let mut renderer = Renderer::new(&device, &scene, &options).unwrap();
        renderer.time_passes().unwrap();
        let image = Readback::new(&device, renderer.size()).unwrap();
        for strategy in [Strategy::ANTUMBRA_QUERIES, methods::BATCHED] {
            let mut view = renderer.new_view().unwrap();
            for frame in 0..6 {
                let request = FrameRequest {
                    image: Some(&image),
                    ..FrameRequest::new(strategy, path.camera(frame))
                };
                renderer.render(&mut view, request).unwrap();
            }
            renderer.wait_idle(&mut view).unwrap();
        }
        assert!(!renderer.pass_times().is_empty());
        let resets = CALLS_THAT_RESET.map(calls);
        let [used, unused] = if resets_by_commands { [1, 0] } else { [0, 1] };
        assert!(resets[used] >= 12 && resets[unused] == 0, "{resets:?}");
        let pixels = image.rgba8().unwrap().to_vec();
        drop((image, renderer, device));
        assert_eq!(instance.validation_log().drain(), []);
        pixels
    });
    assert!(images[0] == images[1]);
}

#[test]
fn an_instance_that_cannot_start_says_which_call_failed() {
    let code = vk::Result::ERROR_OUT_OF_HOST_MEMORY;
    for &call in CALLS_THAT_START {
        let faults = vec![Fault { call, fails: 0..1, code }];
        let error =
            refusal(FaultInjection { faults, ..FaultInjection::default() }, None).to_string();
        assert!(error.contains(call.to_str().unwrap()) && error.contains("memory"), "{error}");
    }
}
