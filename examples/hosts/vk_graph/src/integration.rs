//! All that this host writes to leave out what cannot be seen: the engine records into the command
//! buffer that vk-graph gives to a closure.

use std::error::Error;
use std::ffi::CString;
use std::sync::Arc;

use ash::vk;
use cull::{Camera, CullView, Strategy};
use gpu::{
    Commands, Device, FrameNumbers, FrameRing, HostImage, HostImages, ImageState, IndirectDraw,
    RenderTarget, Resubmission, Target, Tick,
};
use occlusion::{
    BucketDraw, BucketId, CulledScene, CulledSceneOptions, DrawRequest, HostObject, ObjectRenderer,
    OcclusionState, Rendering,
};
use walk::{BoxScene, HostInstance, ViewConstants};

use crate::device::GraphDevice;
use crate::renderer::{FRAMES_IN_FLIGHT, GraphRenderer};

/// The state of the engine for this host.
pub struct GraphCulling {
    device: Device,
    frames: FrameRing,
    scene: CulledScene,
    view: OcclusionState,
    objects: HostObjects,
}

/// The callbacks: the host draws into its own images with its own pipelines.
struct HostObjects {
    renderer: Arc<GraphRenderer>,
    target: Target,
}

impl GraphCulling {
    /// Adopts the host's device and takes over the boxes and draws of all objects.
    pub fn new(
        host: &HostInstance,
        renderer: &Arc<GraphRenderer>,
        walk: &BoxScene,
    ) -> Result<Self, Box<dyn Error>> {
        let slots = FRAMES_IN_FLIGHT as usize;
        // SAFETY: as described; the host destroys its device behind `GraphCulling::finish`.
        let device = unsafe { Device::adopt(description(host, &renderer.device)) }?;
        let [depth, colour] = images(renderer)?;
        let colours = [colour];
        let images = HostImages::new(depth, &colours, walk::SIZE);
        // SAFETY: the host's images live as long, and nothing but its frames uses them.
        let target = unsafe { Target::of_host(&device, &images) }?;
        let options = CulledSceneOptions {
            object_capacity: walk.objects.len(),
            draw_capacity: walk.parts.len() as u32,
            bucket_count: walk::BUCKETS,
            frames_in_flight: slots,
            ..Default::default()
        };
        let mut scene = CulledScene::new(&device, target.attachments(), &options)?;
        let draw = |number: u32| BucketDraw {
            bucket: BucketId(walk.parts[number as usize].bucket),
            draw: IndirectDraw {
                index_count: walk::INDICES.len() as u32,
                instance_count: 1,
                first_instance: number,
                ..Default::default()
            },
            triangles: 12,
        };
        for object in &walk.objects {
            let draws: Vec<_> = object.parts.clone().map(draw).collect();
            scene.add(&[HostObject { bounds: object.bounds, draws: &draws }], &mut Vec::new())?;
        }
        let view = scene.new_view(&target)?;
        let mut frames = FrameRing::new(&device, slots)?;
        frames.set_resubmission(Resubmission::Never);
        let objects = HostObjects { renderer: renderer.clone(), target };
        Ok(Self { device, frames, scene, view, objects })
    }

    /// Records the draws of a frame: its number, and the newest frame that is over.
    pub fn record(
        &mut self,
        commands: vk::CommandBuffer,
        current: u64,
        over: u64,
        camera: &Camera,
        strategy: Strategy,
    ) -> Result<(), Box<dyn Error>> {
        let numbers = FrameNumbers { current: Tick(current), safe: Tick(over) };
        // SAFETY: the command buffer is being recorded, and frames up to `over` were waited for.
        let frame = unsafe { self.frames.begin_in(commands, numbers) }?;
        let bits = self.device.adapter().limits.sub_pixel_precision_bits;
        let view = CullView::new(camera, walk::SIZE, bits);
        let request = DrawRequest { strategy, ..DrawRequest::from(&view) };
        let mut scope = self.scene.begin(frame)?;
        scope.draw(&mut self.view, request, &mut self.objects)?;
        scope.end()?;
        Ok(())
    }

    /// Frees everything, and returns the draws of the last frame. All frames are over.
    pub fn finish(mut self) -> Result<u64, Box<dyn Error>> {
        // SAFETY: the host waited for its last frame.
        unsafe { self.device.host_finished() }?;
        self.view.collect(self.device.completed()?, &self.scene);
        Ok(self.view.drain_stats().next_back().map_or(0, |outcome| outcome.draws))
    }
}

impl ObjectRenderer for HostObjects {
    fn target(&mut self) -> &mut Target {
        &mut self.target
    }

    fn rendering(&self, _view: &CullView, rendering: Rendering) -> RenderTarget {
        self.target.render_target((rendering == Rendering::First).then_some([0.0; 4]))
    }

    fn bind(&self, commands: &Commands, view: &CullView, bucket: BucketId) {
        let view_proj = view.view_proj.to_cols_array();
        let snap_steps = view.snap_steps;
        self.renderer.bind(commands.raw(), bucket.0, &ViewConstants { view_proj, snap_steps });
    }
}

/// Describes the device of vk-graph, which submits by itself.
fn description(host: &HostInstance, device: &GraphDevice) -> gpu::HostDevice {
    let extensions = device.needs.extensions().into_iter().chain(host.extensions());
    gpu::HostDevice {
        extensions: extensions.map(CString::from).collect(),
        features: device.needs.features(),
        ..gpu::HostDevice::new(
            host.entry.clone(),
            host.raw.clone(),
            device.physical,
            ash::Device::clone(&device.raw),
            device.queue_family,
        )
    }
}

/// Describes depth and colour in the states of the accesses that the graph's command declares:
/// vk-graph brings them there before, and goes on from there.
fn images(renderer: &GraphRenderer) -> Result<[HostImage; 2], Box<dyn Error>> {
    let image = |source: &vk_graph::driver::image::Image,
                 entry|
     -> Result<HostImage, Box<dyn Error>> {
        let image = source.handle;
        let info = source.info;
        let format = info.format;
        let usage = info.usage;
        Ok(HostImage { image, view: source.view(info.into())?, format, usage, entry, exit: None })
    };
    Ok([
        image(&renderer.depth, ImageState::depth_attachment())?,
        image(&renderer.colour, ImageState::colour_attachment())?,
    ])
}
