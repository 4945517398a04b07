//! Pools of command buffers and of descriptor sets, and the buffers that are recorded.

use ash::vk;

use crate::core::device::Device;
use crate::core::error::{Called, Error};

/// The number of storage-buffer sets that a frame may bind; a frame binds a few per pass.
const DESCRIPTOR_SETS: u32 = 256;
/// The number of storage buffers over all those sets.
const DESCRIPTORS: u32 = 1024;
/// The number of textures over all those sets.
const TEXTURE_DESCRIPTORS: u32 = 1024;

pub(crate) fn create_command_pool(device: &Device, name: &str) -> Result<vk::CommandPool, Error> {
    let info = vk::CommandPoolCreateInfo::default()
        .queue_family_index(device.queue_family())
        .flags(vk::CommandPoolCreateFlags::TRANSIENT);
    // SAFETY: the family of the device's own queue.
    let pool = unsafe { device.raw().create_command_pool(&info, device.callbacks()) }
        .called("vkCreateCommandPool")?;
    device.name(pool, name);
    Ok(pool)
}

pub(crate) fn allocate_commands(
    device: &Device,
    pool: vk::CommandPool,
    name: &str,
) -> Result<vk::CommandBuffer, Error> {
    let info = vk::CommandBufferAllocateInfo::default()
        .command_pool(pool)
        .level(vk::CommandBufferLevel::PRIMARY)
        .command_buffer_count(1);
    // SAFETY: a live pool that is not in use.
    let buffers = unsafe { device.raw().allocate_command_buffers(&info) }
        .called("vkAllocateCommandBuffers")?;
    let buffer = buffers.first().copied().unwrap_or_default();
    device.name(buffer, name);
    Ok(buffer)
}

pub(crate) fn begin_commands(device: &Device, buffer: vk::CommandBuffer) -> Result<(), Error> {
    let info =
        vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
    // SAFETY: the buffer is fresh or its pool was reset after its tick.
    unsafe { device.raw().begin_command_buffer(buffer, &info) }.called("vkBeginCommandBuffer")
}

pub(crate) fn end_commands(device: &Device, buffer: vk::CommandBuffer) -> Result<(), Error> {
    // SAFETY: the buffer is being recorded.
    unsafe { device.raw().end_command_buffer(buffer) }.called("vkEndCommandBuffer")
}

pub(crate) fn create_descriptor_pool(
    device: &Device,
    name: &str,
) -> Result<vk::DescriptorPool, Error> {
    let size = |ty, descriptor_count| vk::DescriptorPoolSize { ty, descriptor_count };
    let sizes = [
        size(vk::DescriptorType::STORAGE_BUFFER, DESCRIPTORS),
        size(vk::DescriptorType::COMBINED_IMAGE_SAMPLER, TEXTURE_DESCRIPTORS),
    ];
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(DESCRIPTOR_SETS).pool_sizes(&sizes);
    // SAFETY: a plain descriptor pool.
    let pool = unsafe { device.raw().create_descriptor_pool(&info, device.callbacks()) }
        .called("vkCreateDescriptorPool")?;
    device.name(pool, name);
    Ok(pool)
}
