//! All that this host writes to leave out what cannot be seen: the engine records its tests into an
//! encoder of their own, between those of two render passes, and hands out the draws of both.

use std::error::Error;
use std::ffi::CString;
use std::sync::Arc;

use ash::vk;
use cull::{Camera, ClipY, CullView, DepthConvention, DrawPhases, Strategy, ViewProjection};
use glam::{Mat4, vec3};
use gpu::{
    BufferSlice, Device, FrameNumbers, FrameRing, HostImage, HostImages, ImageState, IndirectDraw,
    Resubmission, Target, Tick,
};
use occlusion::{
    BucketDraw, BucketId, CulledScene, CulledSceneOptions, DrawList, DrawRequest, HostObject,
    OcclusionState,
};
use walk::{BoxScene, HostInstance, ViewConstants};
use wgpu::hal::{api::Vulkan, vulkan};

use crate::device::WgpuDevice;
use crate::renderer::{FRAMES_IN_FLIGHT, WgpuDraws, WgpuRenderer};

/// The state of the engine for this host.
pub struct WgpuCulling {
    device: Device,
    frames: FrameRing,
    scene: CulledScene,
    view: OcclusionState,
    renderer: Arc<WgpuRenderer>,
    target: Target,
}

impl WgpuCulling {
    /// Adopts the host's device and takes over the boxes and draws of all objects.
    pub fn new(
        host: &HostInstance,
        renderer: &Arc<WgpuRenderer>,
        walk: &BoxScene,
    ) -> Result<Self, Box<dyn Error>> {
        let slots = FRAMES_IN_FLIGHT as usize;
        // SAFETY: as described; the host destroys its device behind `WgpuCulling::finish`.
        let device = unsafe { Device::adopt(description(host, &renderer.host)) }?;
        let depth = depth_image(renderer)?;
        let images = HostImages::new(depth, &[], walk::SIZE);
        // SAFETY: the host's texture lives as long, and nothing but its frames uses it.
        let target = unsafe { Target::of_host(&device, &images) }?;
        let options = CulledSceneOptions {
            object_capacity: walk.objects.len(),
            draw_capacity: walk.parts.len() as u32,
            bucket_count: walk::BUCKETS,
            frames_in_flight: slots,
            draw_phases: DrawPhases::Two,
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
        Ok(Self { device, frames, scene, view, renderer: renderer.clone(), target })
    }

    /// Encodes a frame: its number, and the newest frame that is over.
    pub fn encode(
        &mut self,
        current: u64,
        over: u64,
        camera: &Camera,
        strategy: Strategy,
        image: &wgpu::Buffer,
    ) -> Result<[wgpu::CommandBuffer; 3], Box<dyn Error>> {
        let numbers = FrameNumbers { current: Tick(current), safe: Tick(over) };
        let mut encoder = self.renderer.host.device.create_command_encoder(&Default::default());
        // SAFETY: nothing of wgpu is recorded into this encoder.
        let view_proj = unsafe {
            encoder.as_hal_mut::<Vulkan, _, _>(|raw| {
                let commands = raw.ok_or("no encoder of Vulkan")?.raw_handle();
                self.record(commands, numbers, camera, strategy)
            })
        }?;
        let bits = self.device.adapter().limits.sub_pixel_precision_bits;
        let snap_steps = CullView::new(camera, walk::SIZE, bits).snap_steps;
        let constants = ViewConstants { view_proj: view_proj.to_cols_array(), snap_steps };
        let draws =
            |lists: &[DrawList]| lists.iter().map(|list| self.draws(list)).collect::<Vec<_>>();
        let [visible, revealed] =
            [self.view.visible_lists(), self.view.revealed_lists()].map(draws);
        let first = self.renderer.encode(&visible, &constants, None);
        let second = self.renderer.encode(&revealed, &constants, Some(image));
        Ok([first, encoder.finish(), second])
    }

    /// Records the tests of a frame, and returns the matrix that its draws use.
    fn record(
        &mut self,
        commands: vk::CommandBuffer,
        numbers: FrameNumbers,
        camera: &Camera,
        strategy: Strategy,
    ) -> Result<Mat4, Box<dyn Error>> {
        // SAFETY: the command buffer is being recorded, and frames up to `safe` were waited for.
        let frame = unsafe { self.frames.begin_in(commands, numbers) }?;
        let bits = self.device.adapter().limits.sub_pixel_precision_bits;
        // The y of wgpu's clip space goes up.
        let upwards = Mat4::from_scale(vec3(1.0, -1.0, 1.0));
        let matrix = upwards * CullView::new(camera, walk::SIZE, bits).view_proj;
        let projection = ViewProjection { matrix, depth: DepthConvention::Reversed, y: ClipY::Up };
        let view = CullView::from_matrix(&projection, walk::SIZE, bits)?;
        let request = DrawRequest { strategy, ..DrawRequest::from(&view) };
        let mut scope = self.scene.begin(frame)?;
        let planned = scope.plan(&mut self.view, request)?;
        scope.list(planned)?.record(&mut scope, &mut self.target)?;
        scope.end()?;
        Ok(matrix)
    }

    /// Returns a list as wgpu draws it.
    fn draws(&self, list: &DrawList) -> WgpuDraws {
        let buffer = |slice: BufferSlice| {
            // SAFETY: the buffer lives until the frame is over, longer than what wgpu encodes.
            let buffer = unsafe {
                self.renderer.host.device.create_buffer_from_hal::<Vulkan>(
                    vulkan::Buffer::from_raw_externally_owned(slice.raw(), Box::new(|| {})),
                    &wgpu::BufferDescriptor {
                        label: None,
                        size: slice.offset_bytes + slice.size_bytes,
                        usage: wgpu::BufferUsages::INDIRECT,
                        mapped_at_creation: false,
                    },
                )
            };
            (buffer, slice.offset_bytes)
        };
        let commands = buffer(list.commands);
        let count = list.count.map(buffer);
        WgpuDraws { bucket: list.bucket.0, commands, most: list.most, count }
    }

    /// Frees everything, and returns the draws of the last frame. All frames are over.
    pub fn finish(mut self) -> Result<u64, Box<dyn Error>> {
        // SAFETY: the host waited for its last frame.
        unsafe { self.device.host_finished() }?;
        self.view.collect(self.device.completed()?, &self.scene);
        Ok(self.view.drain_stats().next_back().map_or(0, |outcome| outcome.draws))
    }
}

/// Describes the device of wgpu, which submits by itself.
fn description(instance: &HostInstance, host: &WgpuDevice) -> gpu::HostDevice {
    let extensions = host.needs.extensions().into_iter().chain(instance.extensions());
    gpu::HostDevice {
        extensions: extensions.map(CString::from).collect(),
        features: host.features,
        ..gpu::HostDevice::new(
            instance.entry.clone(),
            instance.raw.clone(),
            host.physical,
            host.raw.clone(),
            host.queue_family,
        )
    }
}

/// Describes the depth as wgpu's render passes leave and expect it.
fn depth_image(renderer: &WgpuRenderer) -> Result<HostImage, Box<dyn Error>> {
    // SAFETY: handles of textures that live as long as the renderer.
    let (image, view) = unsafe {
        let image = renderer.depth.as_hal::<Vulkan>().ok_or("no texture of Vulkan")?.raw_handle();
        let view = renderer.depth_view.as_hal::<Vulkan>().ok_or("no view of Vulkan")?.raw_handle();
        (image, view)
    };
    let drawn = ImageState::depth_attachment();
    Ok(HostImage {
        image,
        view,
        format: vk::Format::D32_SFLOAT,
        usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC,
        entry: drawn,
        exit: Some(drawn),
    })
}
