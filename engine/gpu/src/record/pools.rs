//! Pools of command buffers, and the buffers that are recorded.

use ash::vk;

use crate::core::device::Device;
use crate::core::error::{Called, Error};

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
