//! All that this host writes to leave out what cannot be seen.

use std::error::Error;
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
use walk::{AshDevice, AshImage, BoxScene, ViewConstants};

use crate::renderer::{FRAMES_IN_FLIGHT, HostRenderer};

/// The state of the engine for this host.
pub struct AshCulling {
    device: Device,
    frames: FrameRing,
    scene: CulledScene,
    view: OcclusionState,
    objects: HostObjects,
}

/// The callbacks: the host draws into its own images with its own pipelines.
struct HostObjects {
    renderer: Arc<HostRenderer>,
    target: Target,
}

impl AshCulling {
    /// Adopts the host's device and takes over the boxes and draws of all objects.
    pub fn new(renderer: &Arc<HostRenderer>, walk: &BoxScene) -> Result<Self, Box<dyn Error>> {
        let slots = FRAMES_IN_FLIGHT as usize;
        // SAFETY: as described; the host destroys its device behind `AshCulling::finish`.
        let device = unsafe { Device::adopt(description(&renderer.host)) }?;
        let [depth, colour] = images(renderer);
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

/// Describes the host's device, which submits by itself.
fn description(host: &AshDevice) -> gpu::HostDevice {
    gpu::HostDevice {
        extensions: host.extensions(),
        features: host.needs.features(),
        ..gpu::HostDevice::new(
            host.instance.entry.clone(),
            host.instance.raw.clone(),
            host.physical,
            host.raw.clone(),
            host.queue_family,
        )
    }
}

/// Describes the host's depth and colour: cleared by each frame, the colour then copied.
fn images(renderer: &HostRenderer) -> [HostImage; 2] {
    use vk::{AccessFlags2 as A, PipelineStageFlags2 as S};
    let image = |image_state: &AshImage, before: ImageState, exit| HostImage {
        image: image_state.raw,
        view: image_state.view,
        format: image_state.format,
        usage: image_state.usage,
        entry: ImageState { layout: vk::ImageLayout::UNDEFINED, ..before },
        exit,
    };
    let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    let stages = S::ALL_TRANSFER;
    let copied = ImageState { layout, stages, access: A::TRANSFER_READ };
    let depth = image(&renderer.depth, ImageState::depth_attachment(), None);
    [depth, image(&renderer.colour, copied, Some(copied))]
}
