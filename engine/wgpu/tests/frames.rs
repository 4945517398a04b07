//! Frames on a driver: who may drop what when, and what is refused. That images are exact is
//! checked by `examples/hosts/wgpu`.

#![allow(clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]
#![allow(unsafe_code, reason = "a frame is submitted by other means")]

use antumbra_wgpu::cull::{Aabb, Camera, CullView, DepthConvention, Projection};
use antumbra_wgpu::glam::{Mat4, Vec3, vec3};
use antumbra_wgpu::occlusion::{
    BucketDraw, BucketId, CulledSceneOptions, HostObject, OcclusionState,
};
use antumbra_wgpu::{Error, WgpuCulling, WgpuDevice, WgpuFrame, WgpuTarget};

const SIZE: [u32; 2] = [64, 48];
const FRAMES_IN_FLIGHT: usize = 2;

/// A scene of one box before the camera.
struct Scene {
    view: OcclusionState,
    culling: WgpuCulling,
    target: WgpuTarget,
    depth: wgpu::Texture,
}

/// Returns a device of the first adapter with Vulkan 1.3, opened by wgpu's own instance.
fn open() -> WgpuDevice {
    let mut instance = wgpu::InstanceDescriptor::new_without_display_handle();
    instance.backends = wgpu::Backends::VULKAN;
    instance.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    let instance = wgpu::Instance::new(instance);
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    let opened = adapters
        .iter()
        .map(|adapter| WgpuDevice::open(adapter, &wgpu::DeviceDescriptor::default()));
    opened.flatten().next().expect("a driver of Vulkan 1.3")
}

fn texture(device: &wgpu::Device, format: wgpu::TextureFormat) -> wgpu::Texture {
    let [width, height] = SIZE;
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

impl Scene {
    fn new(gpu: &WgpuDevice) -> Self {
        let depth = texture(&gpu.device, wgpu::TextureFormat::Depth32Float);
        let target = WgpuTarget::new(gpu, &depth, DepthConvention::Reversed).expect("a target");
        let options =
            CulledSceneOptions { frames_in_flight: FRAMES_IN_FLIGHT, ..Default::default() };
        let mut culling = WgpuCulling::new(gpu, &target, &options).expect("a scene");
        let draws = [BucketDraw { bucket: BucketId(0), draw: Default::default(), triangles: 0 }];
        let bounds = Aabb::new(vec3(-1.0, -1.0, -6.0), vec3(1.0, 1.0, -5.0));
        let object = HostObject { bounds, draws: &draws };
        culling.scene.add(&[object], &mut Vec::new()).expect("a box");
        let view = culling.new_view(&target).expect("a view");
        Self { view, culling, target, depth }
    }

    fn camera(&self) -> CullView {
        let projection = Projection::perspective(1.0);
        let camera =
            Camera { eye: Vec3::ZERO, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 };
        // A camera of the engine has y down, and wgpu's clip space up.
        let upwards = Mat4::from_scale(vec3(1.0, -1.0, 1.0));
        self.target.view(upwards * CullView::new(&camera, SIZE, 0).view_proj).expect("a camera")
    }

    fn encode(&mut self) -> Result<WgpuFrame, Error> {
        let camera = self.camera();
        self.culling.encode(&mut self.view, &mut self.target, &camera)
    }

    /// Encodes a pass that clears the depth.
    fn clear(&self, device: &wgpu::Device) -> wgpu::CommandBuffer {
        let mut encoder = device.create_command_encoder(&Default::default());
        let view = self.depth.create_view(&Default::default());
        let cleared =
            wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store };
        drop(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(cleared),
                stencil_ops: None,
            }),
            ..Default::default()
        }));
        encoder.finish()
    }
}

#[test]
fn frames_are_over_without_help_and_have_answers() {
    let gpu = open();
    let mut scene = Scene::new(&gpu);
    // More frames than slots: each waits for the one that used its slot.
    for _ in 0..4 * FRAMES_IN_FLIGHT {
        let frame = scene.encode().expect("a frame");
        let first = scene.clear(&gpu.device);
        frame.submit(&gpu.queue, [first], []);
    }
    // Submits of the program's own are waited for too.
    for _ in 0..2 * FRAMES_IN_FLIGHT {
        let frame = scene.encode().expect("a frame");
        let first = scene.clear(&gpu.device);
        // SAFETY: both in one submit, behind the pass.
        let tests = unsafe { frame.into_tests() };
        gpu.queue.submit([first].into_iter().chain(tests));
    }
    gpu.finish().expect("all frames end");
    scene.culling.collect(&mut scene.view).expect("a device");
    let frames = scene.view.drain_stats().count();
    assert_eq!(frames, 6 * FRAMES_IN_FLIGHT);
}

#[test]
fn a_frame_that_is_dropped_gives_its_place_back() {
    let gpu = open();
    let mut scene = Scene::new(&gpu);
    for _ in 0..2 * FRAMES_IN_FLIGHT {
        drop(scene.encode().expect("a frame"));
    }
    let held: Vec<_> = (0..FRAMES_IN_FLIGHT).map(|_| scene.encode().expect("a frame")).collect();
    let refused = scene.encode().map(|_| ());
    assert!(matches!(refused, Err(Error::FramesHeld(FRAMES_IN_FLIGHT))), "{refused:?}");
    assert!(matches!(gpu.finish(), Err(Error::FramesHeld(_))));
    drop(held);
    gpu.finish().expect("no frame is left");
    drop(scene.encode().expect("a frame"));
}

#[test]
fn scenes_of_a_device_take_turns() {
    let gpu = open();
    let mut scenes = [Scene::new(&gpu), Scene::new(&gpu)];
    for _ in 0..2 * FRAMES_IN_FLIGHT {
        for scene in &mut scenes {
            let frame = scene.encode().expect("a frame");
            let first = scene.clear(&gpu.device);
            frame.submit(&gpu.queue, [first], []);
        }
    }
    let [mut one, mut other] = scenes;
    let camera = one.camera();
    // Another target of the same format and device fits.
    drop(one.culling.encode(&mut one.view, &mut other.target, &camera).expect("a frame"));
    let foreign = one.culling.encode(&mut other.view, &mut one.target, &camera).map(|_| ());
    assert!(matches!(foreign, Err(Error::Occlusion(_))), "a view of another scene: {foreign:?}");
}

#[test]
fn the_order_of_drops_does_not_matter() {
    let gpu = open();
    let mut scene = Scene::new(&gpu);
    let frame = scene.encode().expect("a frame");
    let first = scene.clear(&gpu.device);
    let device = gpu.device.clone();
    let queue = gpu.queue.clone();
    drop(gpu);
    let Scene { view, culling, target, depth } = scene;
    drop((depth, target));
    let WgpuCulling { scene: engine_scene, .. } = culling;
    frame.submit(&queue, [first], []);
    drop((queue, device));
    // The last owners of the Vulkan device.
    drop(view);
    drop(engine_scene);
}

#[test]
fn what_does_not_fit_is_refused() {
    let gpu = open();
    let colour = texture(&gpu.device, wgpu::TextureFormat::Rgba8Unorm);
    let refused = WgpuTarget::new(&gpu, &colour, DepthConvention::Reversed).map(|_| ());
    assert!(matches!(refused, Err(Error::NotDepth { .. })), "{refused:?}");

    let mut scene = Scene::new(&gpu);
    let frame = scene.encode().expect("a frame");
    let errors = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    scene.depth.destroy();
    frame.submit(&gpu.queue, [], []);
    let error = pollster::block_on(errors.pop());
    assert!(error.is_some(), "wgpu submits no tests of a texture that is destroyed");
    let refused = scene.encode().map(|_| ());
    assert!(matches!(refused, Err(Error::NoDepth)), "{refused:?}");
}

#[test]
fn a_target_of_another_device_is_refused() {
    let one = open();
    let other = open();
    let mut scene = Scene::new(&one);
    let mut foreign = Scene::new(&other).target;
    let camera = scene.camera();
    let refused = scene.culling.encode(&mut scene.view, &mut foreign, &camera).map(|_| ());
    assert!(matches!(refused, Err(Error::NoDepth)), "{refused:?}");
    let options = CulledSceneOptions::default();
    let refused = WgpuCulling::new(&one, &foreign, &options).map(|_| ());
    assert!(matches!(refused, Err(Error::NoDepth)), "{refused:?}");
}
