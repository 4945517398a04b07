//! Loading: copies data into GPU memory before the frame loop starts, and waits for it.

use ash::vk;
use bytemuck::Pod;

use crate::access::{Access, MemoryBarrier};
use crate::buffer::{Buffer, Place};
use crate::commands::Commands;
use crate::deletion::{Garbage, Recording};
use crate::device::{Device, Order, WaitFor};
use crate::error::{Called, Error};
use crate::frames::create_descriptor_pool;

/// Staging goes in pieces, so that a large scene needs no second copy of itself.
const STAGING_BYTES: usize = 32 << 20;

impl Device {
    /// A buffer in GPU memory that holds `items`. Waits for the copy: for loading, not for frames.
    ///
    /// # Errors
    /// No memory, or a failed call.
    pub fn upload<T: Pod>(
        &self,
        name: &str,
        items: &[T],
        usage: vk::BufferUsageFlags,
    ) -> Result<Buffer, Error> {
        let bytes: &[u8] = bytemuck::cast_slice(items);
        let usage = usage | vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = Buffer::new(self, name, bytes.len() as u64, usage, Place::Device)?;
        if bytes.is_empty() {
            return Ok(buffer);
        }
        let piece_bytes = STAGING_BYTES.min(bytes.len());
        let mut staging = Buffer::new(
            self,
            "staging",
            piece_bytes as u64,
            vk::BufferUsageFlags::TRANSFER_SRC,
            Place::Upload,
        )?;
        for (piece, data) in bytes.chunks(piece_bytes).enumerate() {
            if let Some(place) = staging.bytes_mut().get_mut(..data.len()) {
                place.copy_from_slice(data);
            }
            let offset = (piece * piece_bytes) as u64;
            let to = buffer.whole().part(offset, data.len() as u64);
            self.run_once("upload", |commands| {
                commands.copy_buffer(staging.whole(), to);
                // Waiting for the tick shows the GPU nothing: later submits use it without a barrier.
                commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::Any]));
            })?;
        }
        Ok(buffer)
    }

    /// Records commands, submits them, and waits until they are over. For loading.
    ///
    /// # Errors
    /// What failed while recording, a failed call, or a timeout.
    pub fn run_once(&self, name: &str, record: impl FnOnce(&Commands)) -> Result<(), Error> {
        let pool = create_command_pool(self, name)?;
        let descriptors = create_descriptor_pool(self, name)
            .inspect_err(|_| self.retire(Garbage::CommandPool(pool)))?;
        let recording = self.open_recording();
        let recorded = record_once(self, pool, name, recording.number, descriptors, record);
        let submitted = recorded.and_then(|commands| {
            let tick = self.submit(Some(commands.raw()), &Order::default())?;
            commands.submitted(tick);
            Ok(tick)
        });
        drop(recording);
        // The commands go with their pool once the tick of the submit is over.
        self.retire(Garbage::CommandPool(pool));
        self.retire(Garbage::DescriptorPool(descriptors));
        self.wait(submitted?, WaitFor::Transfer)?;
        self.free_retired()
    }
}

pub(crate) fn create_command_pool(device: &Device, name: &str) -> Result<vk::CommandPool, Error> {
    let info = vk::CommandPoolCreateInfo::default()
        .queue_family_index(device.queue_family())
        .flags(vk::CommandPoolCreateFlags::TRANSIENT);
    // SAFETY: the family of the device's own queue.
    let pool =
        unsafe { device.raw().create_command_pool(&info, None) }.called("vkCreateCommandPool")?;
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

fn record_once(
    device: &Device,
    pool: vk::CommandPool,
    name: &str,
    recording: Recording,
    descriptors: vk::DescriptorPool,
    record: impl FnOnce(&Commands),
) -> Result<Commands, Error> {
    let buffer = allocate_commands(device, pool, name)?;
    begin_commands(device, buffer)?;
    let commands = Commands::new(device, buffer, recording, descriptors, None);
    record(&commands);
    commands.check()?;
    end_commands(device, buffer)?;
    Ok(commands)
}
