//! Copies of the finished images, by commands of the host's own.

use std::error::Error;
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;
use gpu::{FinishedImage, ImageState};
use walk::{AshBuffer, AshDevice};

/// A command buffer and the memory that it copies an image to.
pub struct ImageCopies {
    host: Arc<AshDevice>,
    lock: Arc<Mutex<()>>,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    buffer: AshBuffer,
}

impl ImageCopies {
    /// Creates what copies images of the size of the walk, on the queue behind `lock`.
    pub fn new(host: &Arc<AshDevice>, lock: &Arc<Mutex<()>>) -> Result<Self, Box<dyn Error>> {
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(host.queue_family);
        let [width, height] = walk::SIZE;
        let zeros = vec![0; (width * height * 4) as usize];
        let buffer = AshBuffer::new(host, &zeros, vk::BufferUsageFlags::TRANSFER_DST)?;
        // SAFETY: plain objects of the host's own device.
        unsafe {
            let pool = host.raw.create_command_pool(&pool, None)?;
            let info =
                vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = host.raw.allocate_command_buffers(&info)?[0];
            let fence = host.raw.create_fence(&vk::FenceCreateInfo::default(), None)?;
            let host = host.clone();
            let lock = lock.clone();
            Ok(Self { host, lock, pool, commands, fence, buffer })
        }
    }

    /// Copies an image behind the frame that draws it, waits, and returns the bytes. The image is
    /// in its state again.
    pub fn copy(&self, finished: &FinishedImage) -> Result<Vec<u8>, Box<dyn Error>> {
        let raw = &self.host.raw;
        let buffers = [self.commands];
        let once = vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT;
        let begin = vk::CommandBufferBeginInfo::default().flags(once);
        let submit = vk::SubmitInfo::default().command_buffers(&buffers);
        // SAFETY: the GPU is done with the command buffer; the engine waits for the lock.
        unsafe {
            raw.begin_command_buffer(self.commands, &begin)?;
            self.record(finished);
            raw.end_command_buffer(self.commands)?;
            let held = self.lock.lock().unwrap_or_else(PoisonError::into_inner);
            raw.queue_submit(self.host.queue, &[submit], self.fence)?;
            drop(held);
            raw.wait_for_fences(&[self.fence], true, 60_000_000_000)?;
            raw.reset_fences(&[self.fence])?;
        }
        Ok(self.buffer.bytes(&self.host)?)
    }

    /// Records the copy between two barriers: from the state of the image, and back to it.
    fn record(&self, finished: &FinishedImage) {
        use vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};
        let layout = L::TRANSFER_SRC_OPTIMAL;
        let stages = S::COPY;
        let access = A::TRANSFER_READ;
        let copied = ImageState { layout, stages, access };
        let [width, height] = finished.size;
        let region = vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                layer_count: 1,
                ..Default::default()
            })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        let visible = [vk::MemoryBarrier2::default()
            .src_stage_mask(S::COPY)
            .src_access_mask(A::TRANSFER_WRITE)
            .dst_stage_mask(S::HOST)
            .dst_access_mask(A::HOST_READ)];
        let to_copy = [barrier(finished.image, finished.state, copied)];
        let back = [barrier(finished.image, copied, finished.state)];
        let before = vk::DependencyInfo::default().image_memory_barriers(&to_copy);
        let behind =
            vk::DependencyInfo::default().image_memory_barriers(&back).memory_barriers(&visible);
        let raw = &self.host.raw;
        let commands = self.commands;
        let buffer = self.buffer.raw;
        // SAFETY: a command buffer in recording, and an image in the state that it says.
        unsafe {
            raw.cmd_pipeline_barrier2(commands, &before);
            let image = finished.image;
            let layout = copied.layout;
            raw.cmd_copy_image_to_buffer(commands, image, layout, buffer, &[region]);
            raw.cmd_pipeline_barrier2(commands, &behind);
        }
    }

    /// Destroys everything. No copy runs.
    pub fn destroy(self) {
        // SAFETY: every copy was waited for.
        unsafe {
            self.host.raw.destroy_fence(self.fence, None);
            self.host.raw.destroy_command_pool(self.pool, None);
        }
        self.buffer.destroy(&self.host);
    }
}

fn barrier(image: vk::Image, from: ImageState, to: ImageState) -> vk::ImageMemoryBarrier2<'static> {
    vk::ImageMemoryBarrier2::default()
        .image(image)
        .subresource_range(vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            level_count: 1,
            layer_count: 1,
            ..Default::default()
        })
        .old_layout(from.layout)
        .src_stage_mask(from.stages)
        .src_access_mask(from.access)
        .new_layout(to.layout)
        .dst_stage_mask(to.stages)
        .dst_access_mask(to.access)
}
