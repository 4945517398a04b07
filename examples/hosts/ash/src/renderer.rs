//! The host's own renderer of boxes: pipelines, images, command buffers, submits.

use std::error::Error;
use std::sync::Arc;

use ash::vk;
use walk::{AshBuffer, AshDevice, AshImage, BoxGeometry, BoxPipelines, BoxScene, ViewConstants};

/// The frames that may be in flight at once.
pub const FRAMES_IN_FLIGHT: u64 = 2;

/// The host's pipelines, geometry, images and frames.
pub struct HostRenderer {
    pub host: Arc<AshDevice>,
    pub colour: AshImage,
    pub depth: AshImage,
    corners: AshBuffer,
    indices: AshBuffer,
    pipelines: BoxPipelines,
    pool: vk::CommandPool,
    slots: Vec<FrameSlot>,
}

/// The resources of a frame in flight.
struct FrameSlot {
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    image: AshBuffer,
}

impl HostRenderer {
    /// Creates everything to draw `scene`.
    pub fn new(host: &Arc<AshDevice>, scene: &BoxScene) -> Result<Self, Box<dyn Error>> {
        use vk::{BufferUsageFlags as B, ImageAspectFlags as A, ImageUsageFlags as U};
        let rgba = vk::Format::R8G8B8A8_UNORM;
        let d32 = vk::Format::D32_SFLOAT;
        let colour = AshImage::new(host, rgba, A::COLOR, U::COLOR_ATTACHMENT | U::TRANSFER_SRC)?;
        let depth_usage = U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_SRC;
        let depth = AshImage::new(host, d32, A::DEPTH, depth_usage)?;
        let corners = scene.corners();
        let corners = AshBuffer::new(host, bytemuck::cast_slice(&corners), B::VERTEX_BUFFER)?;
        let indices = bytemuck::cast_slice(&walk::INDICES);
        let indices = AshBuffer::new(host, indices, B::INDEX_BUFFER)?;
        let pipelines = BoxPipelines::new(&host.raw, [rgba, d32])?;
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(host.queue_family);
        // SAFETY: the family of the host's queue.
        let pool = unsafe { host.raw.create_command_pool(&pool, None) }?;
        let slots = (0..FRAMES_IN_FLIGHT).map(|_| FrameSlot::new(host, pool));
        let slots = slots.collect::<Result<_, _>>()?;
        let host = host.clone();
        Ok(Self { host, colour, depth, corners, indices, pipelines, pool, slots })
    }

    /// Waits for the frame that used the slot of frame `number` before, and returns its image.
    pub fn wait(&self, number: u64) -> Result<Vec<u8>, Box<dyn Error>> {
        let slot = &self.slots[(number % FRAMES_IN_FLIGHT) as usize];
        // SAFETY: a fence of this device.
        unsafe { self.host.raw.wait_for_fences(&[slot.fence], true, 60_000_000_000) }?;
        Ok(slot.image.bytes(&self.host)?)
    }

    /// Begins the command buffer of frame `number`; the frame before in its slot is over.
    pub fn begin(&self, number: u64) -> Result<vk::CommandBuffer, vk::Result> {
        let slot = &self.slots[(number % FRAMES_IN_FLIGHT) as usize];
        let once = vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT;
        let info = vk::CommandBufferBeginInfo::default().flags(once);
        // SAFETY: the GPU is done with the command buffer.
        unsafe { self.host.raw.begin_command_buffer(slot.commands, &info) }?;
        Ok(slot.commands)
    }

    /// Binds the pipeline of a bucket with the geometry of all boxes.
    pub fn bind(&self, commands: vk::CommandBuffer, bucket: u32, constants: &ViewConstants) {
        let geometry = BoxGeometry { corners: self.corners.raw, indices: self.indices.raw };
        // SAFETY: the command buffer is being recorded; the objects live until its frame is over.
        unsafe { self.pipelines.bind(commands, bucket, geometry, constants) };
    }

    /// Copies the colour image, which is a source of transfers now, and submits the frame.
    pub fn submit(&self, number: u64) -> Result<(), vk::Result> {
        let slot = &self.slots[(number % FRAMES_IN_FLIGHT) as usize];
        let [width, height] = walk::SIZE;
        let region = vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                layer_count: 1,
                ..Default::default()
            })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        let visible = vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ);
        let from = vk::PipelineStageFlags::TRANSFER;
        let to = vk::PipelineStageFlags::HOST;
        let raw = &self.host.raw;
        let commands = [slot.commands];
        let submit = vk::SubmitInfo::default().command_buffers(&commands);
        // SAFETY: a command buffer in recording, and an image in the layout that is named.
        unsafe {
            let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
            let image = self.colour.raw;
            let buffer = slot.image.raw;
            raw.cmd_copy_image_to_buffer(slot.commands, image, layout, buffer, &[region]);
            let flags = vk::DependencyFlags::empty();
            raw.cmd_pipeline_barrier(slot.commands, from, to, flags, &[visible], &[], &[]);
            raw.end_command_buffer(slot.commands)?;
            raw.reset_fences(&[slot.fence])?;
            raw.queue_submit(self.host.queue, &[submit], slot.fence)
        }
    }

    /// Destroys everything. The GPU is idle.
    pub fn destroy(self) {
        let Self { host, colour, depth, corners, indices, .. } = self;
        // SAFETY: the GPU is idle, and nothing is used any more.
        unsafe {
            host.raw.destroy_command_pool(self.pool, None);
            self.slots.iter().for_each(|slot| host.raw.destroy_fence(slot.fence, None));
        }
        self.pipelines.destroy();
        [colour, depth].into_iter().for_each(|image| image.destroy(&host));
        let images = self.slots.into_iter().map(|slot| slot.image);
        [corners, indices].into_iter().chain(images).for_each(|buffer| buffer.destroy(&host));
    }
}

impl FrameSlot {
    fn new(host: &AshDevice, pool: vk::CommandPool) -> Result<Self, Box<dyn Error>> {
        let info =
            vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
        let signaled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        let [width, height] = walk::SIZE;
        let zeros = vec![0; (width * height * 4) as usize];
        // SAFETY: plain objects of the host's own device.
        let (commands, fence) = unsafe {
            (host.raw.allocate_command_buffers(&info)?[0], host.raw.create_fence(&signaled, None)?)
        };
        let image = AshBuffer::new(host, &zeros, vk::BufferUsageFlags::TRANSFER_DST)?;
        Ok(Self { commands, fence, image })
    }
}
