//! Results that the GPU writes for the predicates of the same frame, and a copy in mapped memory
//! for the CPU after the frame.

use ash::vk;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::memory::buffer::{Buffer, BufferSlice, MemoryKind};
use crate::record::access::{Access, MemoryBarrier};
use crate::record::commands::Commands;

/// The size of one result.
pub(crate) const RESULT_BYTES: u64 = 4;
/// The smallest capacity, so that slots with few results need not grow.
const FIRST_CAPACITY: usize = 256;

/// The 32-bit results of one frame slot.
pub(crate) struct ResultBuffer {
    buffer: Buffer,
    mapped: Buffer,
}

impl ResultBuffer {
    /// Creates room for exactly `count` results.
    pub(crate) fn new(device: &Device, name: &str, count: usize) -> Result<Self, Error> {
        let mut usage = vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::STORAGE_BUFFER;
        if device.conditional().is_some() {
            usage |= vk::BufferUsageFlags::CONDITIONAL_RENDERING_EXT;
        }
        if device.capture().is_some() {
            usage |= vk::BufferUsageFlags::TRANSFORM_FEEDBACK_BUFFER_EXT;
        }
        let size_bytes = count as u64 * RESULT_BYTES;
        let to_host = vk::BufferUsageFlags::TRANSFER_DST;
        let mapped = format!("{name} read back");
        Ok(Self {
            buffer: Buffer::new(device, name, size_bytes, usage, MemoryKind::Device)?,
            mapped: Buffer::new(device, &mapped, size_bytes, to_host, MemoryKind::ReadBack)?,
        })
    }

    /// Returns a capacity for `wanted` results with some reserve, so that slots seldom grow.
    pub(crate) fn roomy(wanted: usize) -> usize {
        wanted.max(FIRST_CAPACITY).next_power_of_two()
    }

    /// Returns true if there is room for `count` results.
    pub(crate) fn holds(&self, count: usize) -> bool {
        self.buffer.size_bytes() >= count as u64 * RESULT_BYTES
    }

    pub(crate) fn whole(&self) -> BufferSlice {
        self.buffer.whole()
    }

    pub(crate) fn first(&self, count: usize) -> BufferSlice {
        self.whole().part(0, count as u64 * RESULT_BYTES)
    }

    /// Copies the first `count` results to mapped memory. Waits for their access `written`, and for
    /// the fill or copy that cleared them, because no other barrier waits for it if nothing else
    /// wrote in this frame. Must be their last use in a frame.
    pub(crate) fn read_back(&self, commands: &Commands, count: usize, written: Access) {
        if count == 0 {
            return;
        }
        let writes = [Access::CopyWrite, written];
        commands.barrier(MemoryBarrier::between(&writes, &[Access::CopyRead]));
        commands.copy_buffer(self.first(count), self.mapped.whole());
        commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
    }

    /// Returns the first `count` results of the last frame that copied them, which must be over.
    pub(crate) fn read(&self, count: usize) -> &[u32] {
        self.mapped.read(0..count)
    }
}
