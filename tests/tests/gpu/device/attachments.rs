//! The loads and stores of attachments of every strategy: undefined contents are not read, contents
//! that nothing reads are not stored, and a frame moves as little memory as its renderings allow.

use cull::{CullConfig, ObjectId, Strategy};
use gpu::{Device, DeviceOptions, OptionalFeature, Readback, SampleCount};
use render::{CostModel, FrameRequest, Rect, Renderer, RendererOptions};
use scene::Scene;
use scenes::{CameraPath, PathKind};
use shadows::{CasterCulling, ShadowMethod, ShadowOptions};
use tests::fault_injection::AttachmentKind::{Average, Colour, Depth};
use tests::fault_injection::{
    AttachmentTraffic, FaultInjection, LAZY_ALLOCATIONS, attachment_traffic, calls,
};
use tests::walk::SceneKind;
use tests::{Driver, instance_with, shadow_scene};

const SIZE: [u32; 2] = [128, 72];

/// Calls `body` with a device of each driver whose loads and stores are recorded.
fn with_recorder(body: impl Fn(&Device)) {
    on_both(&FaultInjection { records_attachments: true, ..FaultInjection::default() }, body);
}

/// Calls `body` with a device of each driver on such a machine.
fn on_both(faults: &FaultInjection, body: impl Fn(&Device)) {
    for driver in [Driver::Lavapipe, Driver::SwiftShader] {
        let instance = instance_with(faults.clone().entry());
        let adapter = instance.pick_adapter(Some(driver.device_name())).unwrap();
        let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
        body(&device);
        drop(device);
        assert_eq!(instance.validation_log().drain(), []);
    }
}

fn options() -> RendererOptions {
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        frames_in_flight: 1,
        cost_model: CostModel::Off,
        ..RendererOptions::default()
    }
}

fn supported(renderer: &Renderer) -> Vec<Strategy> {
    methods::strategies()
        .into_iter()
        .filter(|strategy| renderer.supports(*strategy).is_ok())
        .collect()
}

/// Renders frames of a walk, and passes on the traffic of each. Nothing reads the image.
fn walk(
    renderer: &mut Renderer,
    strategy: Strategy,
    cameras: &[cull::Camera],
    check: impl Fn(usize, &AttachmentTraffic),
) {
    let mut view = renderer.new_view().unwrap();
    let mut finding = renderer.new_view().unwrap();
    for (frame, camera) in cameras.iter().enumerate() {
        let area = Rect::whole(renderer.size());
        let needs_set = strategy.needs_still_scene();
        let visible = needs_set.then(|| renderer.visible_set(&mut finding, camera, area).unwrap());
        // The frames that find visible sets have images that nothing reads.
        attachment_traffic();
        let request = FrameRequest::new(strategy, *camera);
        renderer.render(&mut view, FrameRequest { visible: visible.as_ref(), ..request }).unwrap();
        let traffic = attachment_traffic();
        assert_eq!(traffic.faults, [""; 0], "{strategy}, frame {frame}");
        check(frame, &traffic);
        renderer.wait_idle(&mut view).unwrap();
    }
}

/// Returns cameras of a walk and of a cut.
fn cameras(scene: &scenes::GeneratedScene) -> Vec<cull::Camera> {
    let path = CameraPath::new(PathKind::Cut, &scene.routes).unwrap();
    (0..12).map(|frame| path.camera(frame)).collect()
}

#[test]
fn depth_is_stored_for_later_rounds_alone() {
    with_recorder(|device| {
        let generated = SceneKind::City.build(400);
        // The first rendering, one per round, and one for leaves below nodes that showed in the
        // last round.
        let most = CullConfig::default().tuning.rounds_cut as usize + 2;
        let mut renderer = Renderer::new(device, &generated.scene, &options()).unwrap();
        for strategy in supported(&renderer) {
            walk(&mut renderer, strategy, &cameras(&generated), |frame, traffic| {
                let what = format!("{strategy}, frame {frame}: {traffic:?}");
                let renderings = traffic.renderings;
                assert_eq!(traffic.stores(Colour), renderings, "{what}");
                assert_eq!(traffic.loads(Colour), renderings - 1, "{what}");
                assert_eq!(traffic.loads(Depth), renderings - 1, "{what}");
                // Methods that wait do not know in advance which rendering is the last one.
                let last = usize::from(strategy.is_blocking());
                assert_eq!(traffic.stores(Depth), renderings - 1 + last, "{what}");
                let unread = &[Colour, Depth][..1 + last];
                assert_eq!(traffic.unread, unread, "{what}");
                assert!(strategy.is_blocking() || renderings <= most, "{what}");
                let is_single = strategy == Strategy::FRUSTUM || strategy == methods::IDEAL;
                assert!(!is_single || renderings == 1, "{what}");
            });
        }
    });
}

fn shadowed(method: ShadowMethod) -> RendererOptions {
    let shadows = ShadowOptions { method, ..ShadowOptions::default() };
    RendererOptions { shadows, ..options() }
}

#[test]
fn surfaces_load_no_colour_and_store_it_once() {
    with_recorder(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        for method in [ShadowMethod::Off, ShadowMethod::Maps, ShadowMethod::Volumes] {
            let Ok(mut renderer) = Renderer::new(device, &scene, &shadowed(method)) else {
                assert!(method == ShadowMethod::Volumes && !has_volumes(device));
                continue;
            };
            for strategy in supported(&renderer) {
                let cameras = [shadow_scene::camera(); 3];
                walk(&mut renderer, strategy, &cameras, |frame, traffic| {
                    let what = format!("{strategy}, {method:?}, frame {frame}: {traffic:?}");
                    assert_eq!((traffic.loads(Colour), traffic.stores(Colour)), (0, 1), "{what}");
                    assert_eq!(traffic.unread, [Colour], "{what}");
                    // The last rendering draws the colours too, or stores its depth for the
                    // rendering that does.
                    if method == ShadowMethod::Off {
                        assert_eq!(traffic.stores(Depth), traffic.renderings - 1, "{what}");
                    }
                    if (strategy, method) == (Strategy::FRUSTUM, ShadowMethod::Off) {
                        assert_eq!((traffic.renderings, traffic.loads(Depth)), (1, 0), "{what}");
                    }
                });
            }
        }
    });
}

fn has_volumes(device: &Device) -> bool {
    device.capabilities().has(OptionalFeature::DepthClamp)
}

/// Returns the traffic of the first frame of frustum culling.
fn first_frame(device: &Device, scene: &Scene, options: &RendererOptions) -> AttachmentTraffic {
    let mut renderer = Renderer::new(device, scene, options).unwrap();
    let mut view = renderer.new_view().unwrap();
    let image = Readback::new(device, renderer.size()).unwrap();
    attachment_traffic();
    let request = FrameRequest::new(Strategy::FRUSTUM, shadow_scene::camera());
    renderer.render(&mut view, FrameRequest { image: Some(&image), ..request }).unwrap();
    let traffic = attachment_traffic();
    renderer.wait_idle(&mut view).unwrap();
    assert_eq!((&traffic.faults[..], &traffic.unread[..]), (&[][..], &[][..]), "{traffic:?}");
    traffic
}

#[test]
fn samples_never_leave_the_gpu() {
    with_recorder(|device| {
        let surfaces = shadow_scene::scene(&shadow_scene::boxes(), &[]);
        let plain = Scene { surfaces: None, ..surfaces.clone() };
        let samples = RendererOptions { samples: SampleCount::Four, ..options() };
        for scene in [plain, surfaces] {
            let traffic = first_frame(device, &scene, &samples);
            assert_eq!(traffic.stores(Average), 1, "{traffic:?}");
            assert_eq!((traffic.loads(Colour), traffic.stores(Colour)), (0, 0), "{traffic:?}");
        }
    });
}

#[test]
fn samples_take_no_memory_where_they_need_none() {
    for is_lazy in [false, true] {
        on_both(&FaultInjection { is_lazy, ..FaultInjection::default() }, |device| {
            for samples in [SampleCount::One, SampleCount::Four] {
                let options = RendererOptions { samples, ..options() };
                let scene = shadow_scene::scene(&shadow_scene::boxes(), &[]);
                let before = calls(LAZY_ALLOCATIONS);
                drop(first_frame(device, &scene, &options));
                let taken = calls(LAZY_ALLOCATIONS) - before;
                let expected = usize::from(is_lazy && samples == SampleCount::Four);
                assert_eq!(taken, expected, "lazy: {is_lazy}, {samples:?}");
            }
        });
    }
}

#[test]
fn several_samples_are_averaged_once_by_every_strategy() {
    with_recorder(|device| {
        let generated = SceneKind::City.build(400);
        let samples = RendererOptions { samples: SampleCount::Four, ..options() };
        let mut renderer = Renderer::new(device, &generated.scene, &samples).unwrap();
        for strategy in supported(&renderer) {
            walk(&mut renderer, strategy, &cameras(&generated)[..4], |frame, traffic| {
                let what = format!("{strategy}, frame {frame}: {traffic:?}");
                assert_eq!(traffic.stores(Average), 1, "{what}");
                let of_blocking = usize::from(strategy.is_blocking());
                let unread = &[Depth, Average][1 - of_blocking..];
                assert_eq!(traffic.unread, unread, "{what}");
                assert_eq!(traffic.stores(Colour), traffic.loads(Colour), "{what}");
            });
        }
    });
}

#[test]
fn samples_stay_averaged_where_objects_are_watched() {
    with_recorder(|device| {
        let surfaces = shadow_scene::scene(&shadow_scene::boxes(), &[]);
        let plain = Scene { surfaces: None, ..surfaces.clone() };
        let samples = RendererOptions { samples: SampleCount::Four, ..options() };
        for scene in [plain, surfaces] {
            let mut renderer = Renderer::new(device, &scene, &samples).unwrap();
            let mut view = renderer.new_view().unwrap();
            view.watch(&[ObjectId(0), ObjectId(1)]).unwrap();
            let image = Readback::new(device, renderer.size()).unwrap();
            let strategies = [Strategy::FRUSTUM, Strategy::ANTUMBRA, Strategy::ANTUMBRA];
            for strategy in strategies {
                if renderer.supports(strategy).is_err() {
                    continue;
                }
                attachment_traffic();
                let request = FrameRequest::new(strategy, shadow_scene::camera());
                let request = FrameRequest { image: Some(&image), ..request };
                renderer.render(&mut view, request).unwrap();
                let traffic = attachment_traffic();
                assert_eq!(traffic.faults, [""; 0], "{strategy}: {traffic:?}");
                assert_eq!(traffic.stores(Average), 1, "{strategy}: {traffic:?}");
            }
            renderer.wait_idle(&mut view).unwrap();
        }
    });
}

#[test]
fn maps_that_are_drawn_afresh_load_nothing() {
    with_recorder(|device| {
        // A spot light has one map.
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights()[1..2]);
        let culling = CasterCulling::Unculled;
        let method = ShadowMethod::Maps;
        let shadows = ShadowOptions { method, culling, ..ShadowOptions::default() };
        let traffic = first_frame(device, &scene, &RendererOptions { shadows, ..options() });
        // One store of the map, which the last rendering of the view reads.
        assert_eq!((traffic.loads(Depth), traffic.stores(Depth)), (0, 1), "{traffic:?}");
        assert_eq!((traffic.loads(Colour), traffic.stores(Colour)), (0, 1), "{traffic:?}");
    });
}

#[test]
fn casters_that_are_culled_store_nothing_of_the_view() {
    with_recorder(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        for method in [ShadowMethod::Maps, ShadowMethod::Volumes] {
            let shadows = ShadowOptions { method, ..ShadowOptions::default() };
            assert_ne!(shadows.culling, CasterCulling::Unculled);
            let options = RendererOptions { shadows, ..options() };
            if method == ShadowMethod::Volumes && !has_volumes(device) {
                continue;
            }
            let traffic = first_frame(device, &scene, &options);
            assert!(traffic.renderings > 2, "{traffic:?}");
            assert_eq!((traffic.loads(Colour), traffic.stores(Colour)), (0, 1), "{traffic:?}");
        }
    });
}
