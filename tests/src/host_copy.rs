//! A host that copies an image of the engine by its own commands.

use ash::vk;
use gpu::{FinishedImage, HostQueueLock, ImageState};

use crate::host_device::Host;

impl Host {
    /// Copies `finished` on the queue that the engine shares, restores its state, and returns its
    /// bytes.
    pub fn copy(&self, lock: &dyn HostQueueLock, finished: &FinishedImage) -> Vec<u8> {
        let [width, height] = finished.size;
        let size_bytes = u64::from(width) * u64::from(height) * 4;
        let buffer_info = vk::BufferCreateInfo::default()
            .size(size_bytes)
            .usage(vk::BufferUsageFlags::TRANSFER_DST);
        // SAFETY: plain Vulkan; the submit is over when `run_once` returns.
        unsafe {
            let buffer = self.device.create_buffer(&buffer_info, None).unwrap();
            let needs = self.device.get_buffer_memory_requirements(buffer);
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(needs.size)
                .memory_type_index(self.mapped_memory_type(needs.memory_type_bits));
            let memory = self.device.allocate_memory(&info, None).unwrap();
            self.device.bind_buffer_memory(buffer, memory, 0).unwrap();
            self.run_once(lock, |commands| self.record_copy(commands, finished, buffer));
            let flags = vk::MemoryMapFlags::empty();
            let bytes = self.device.map_memory(memory, 0, vk::WHOLE_SIZE, flags).unwrap();
            let bytes = std::slice::from_raw_parts(bytes.cast::<u8>(), size_bytes as usize);
            let copy = bytes.to_vec();
            self.device.destroy_buffer(buffer, None);
            self.device.free_memory(memory, None);
            copy
        }
    }

    /// Records the copy between two barriers: from the state of the image, and back to it.
    ///
    /// # Safety
    /// The image exists and is in its state, and the buffer is large enough.
    unsafe fn record_copy(
        &self,
        commands: vk::CommandBuffer,
        finished: &FinishedImage,
        buffer: vk::Buffer,
    ) {
        use vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};
        let state = |layout, stages, access| ImageState { layout, stages, access };
        // The validation layer refuses this layout unless the image can be sampled.
        let sampled =
            state(L::SHADER_READ_ONLY_OPTIMAL, S::FRAGMENT_SHADER, A::SHADER_SAMPLED_READ);
        let copied = state(L::TRANSFER_SRC_OPTIMAL, S::COPY, A::TRANSFER_READ);
        let change = |from: ImageState, to: ImageState| {
            let barrier = [barrier(finished.image, from, to)];
            let info = vk::DependencyInfo::default().image_memory_barriers(&barrier);
            // SAFETY: the caller's promise.
            unsafe { self.device.cmd_pipeline_barrier2(commands, &info) };
        };
        let [width, height] = finished.size;
        let region = vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                layer_count: 1,
                ..Default::default()
            })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        change(finished.state, sampled);
        change(sampled, copied);
        // SAFETY: the caller's promise.
        unsafe {
            self.device.cmd_copy_image_to_buffer(
                commands,
                finished.image,
                copied.layout,
                buffer,
                &[region],
            );
        }
        change(copied, finished.state);
    }

    fn mapped_memory_type(&self, allowed: u32) -> u32 {
        let wanted = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        // SAFETY: a physical device of this instance.
        let memory = unsafe { self.instance.get_physical_device_memory_properties(self.physical) };
        let types = (0..).zip(memory.memory_types_as_slice());
        let fits = |(index, kind): &(u32, &vk::MemoryType)| {
            allowed & (1 << index) != 0 && kind.property_flags.contains(wanted)
        };
        types.filter(fits).map(|(index, _)| index).next().unwrap()
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
