//! Loading: copies data into GPU memory before the frame loop starts, and waits for the copies.

use ash::vk;
use bytemuck::Pod;

use crate::core::deletion::{RecordingId, Retired};
use crate::core::device::{Device, WaitFor};
use crate::core::error::Error;
use crate::core::order::Order;
use crate::memory::buffer::{Buffer, MemoryKind};
use crate::record::access::{Access, MemoryBarrier};
use crate::record::commands::Commands;
use crate::record::descriptor_pools::DescriptorPools;
use crate::record::pools::{allocate_commands, begin_commands, create_command_pool, end_commands};

/// The size of a staging buffer: an upload is divided into pieces, so that a large scene needs no
/// second copy of itself.
const STAGING_BYTES: usize = 32 << 20;

impl Device {
    /// Returns a buffer in GPU memory with the contents `items`. Waits for the copy, so it is for
    /// loading, not for frames. On a device without a queue it does not wait: the next frame of the
    /// host first records the copy.
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
        let mut buffer = Buffer::new(self, name, bytes.len() as u64, usage, MemoryKind::Device)?;
        if bytes.is_empty() {
            return Ok(buffer);
        }
        let piece_bytes =
            if self.has_queue() { STAGING_BYTES.min(bytes.len()) } else { bytes.len() };
        let mut staging = Buffer::new(
            self,
            "staging",
            piece_bytes as u64,
            vk::BufferUsageFlags::TRANSFER_SRC,
            MemoryKind::Upload,
        )?;
        if !self.has_queue() {
            if let Some(place) = staging.bytes_mut().get_mut(..bytes.len()) {
                place.copy_from_slice(bytes);
            }
            buffer.upload_later(staging);
            return Ok(buffer);
        }
        for (piece, data) in bytes.chunks(piece_bytes).enumerate() {
            if let Some(place) = staging.bytes_mut().get_mut(..data.len()) {
                place.copy_from_slice(data);
            }
            let offset = (piece * piece_bytes) as u64;
            let to = buffer.whole().part(offset, data.len() as u64);
            self.run_once("upload", |commands| {
                commands.copy_buffer(staging.whole(), to);
                // The wait makes nothing visible to the GPU, and later submits use the buffer
                // without a barrier of their own.
                commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::Any]));
            })?;
        }
        Ok(buffer)
    }

    /// Records commands, submits them, and waits until they are over. For loading.
    ///
    /// # Errors
    /// A failure while recording, a failed call, or a timeout.
    pub fn run_once(&self, name: &str, record: impl FnOnce(&Commands)) -> Result<(), Error> {
        let pool = create_command_pool(self, name)?;
        let descriptors = DescriptorPools::new(self, name)
            .inspect_err(|_| self.retire(Retired::CommandPool(pool)))?;
        let recording = self.open_recording();
        let recorded = record_once(self, pool, name, recording.number, descriptors, record);
        let submitted = recorded.and_then(|commands| {
            let tick = self.submit(Some(commands.raw()), &Order::default())?;
            commands.submitted(tick);
            Ok(tick)
        });
        drop(recording);
        // The commands are freed with their pool once the tick of the submit is over.
        self.retire(Retired::CommandPool(pool));
        self.wait(submitted?, WaitFor::Transfer)?;
        self.free_retired()
    }
}

fn record_once(
    device: &Device,
    pool: vk::CommandPool,
    name: &str,
    recording: RecordingId,
    descriptors: DescriptorPools,
    record: impl FnOnce(&Commands),
) -> Result<Commands, Error> {
    let buffer = allocate_commands(device, pool, name)?;
    begin_commands(device, buffer)?;
    let commands = Commands::new(device, buffer, recording, descriptors);
    record(&commands);
    commands.check()?;
    end_commands(device, buffer)?;
    Ok(commands)
}
