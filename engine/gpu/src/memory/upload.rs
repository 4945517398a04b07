//! Upload memory of a frame: the CPU writes it while the frame is recorded, and it is reused when
//! the frame is over.

use ash::vk;
use bytemuck::Pod;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::memory::buffer::{Buffer, BufferSlice, MemoryKind};

/// A linear arena in mapped memory. After the first frames it is a single chunk and does not
/// allocate.
pub struct Uploads {
    device: Device,
    chunks: Vec<Buffer>,
    used_bytes: u64,
    alignment_bytes: u64,
    name: String,
}

const FIRST_CHUNK_BYTES: u64 = 1 << 20;

impl Uploads {
    pub(crate) fn new(device: &Device, name: &str) -> Self {
        let limits = &device.adapter().limits;
        let alignment_bytes = limits.min_storage_buffer_offset_alignment.max(16);
        Self {
            device: device.clone(),
            chunks: Vec::new(),
            used_bytes: 0,
            alignment_bytes,
            name: name.to_owned(),
        }
    }

    /// Resets the arena. If the last frame needed several chunks, they are replaced by one.
    pub(crate) fn reset(&mut self) -> Result<(), Error> {
        self.used_bytes = 0;
        if self.chunks.len() > 1 {
            let total: u64 = self.chunks.iter().map(Buffer::size_bytes).sum();
            // The newest is the largest, and is used again if there is no memory for all of them.
            self.chunks.drain(..self.chunks.len() - 1);
            match self.add_chunk(total.next_power_of_two()) {
                Ok(()) => drop(self.chunks.remove(0)),
                Err(error) if error.is_out_of_memory() => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Copies `items` to the memory of this frame.
    ///
    /// # Errors
    /// No memory.
    pub fn push<T: Pod>(&mut self, items: &[T]) -> Result<BufferSlice, Error> {
        self.push_iter(items.iter().copied())
    }

    /// Writes the items consecutively to the memory of this frame. The slice is at least one item
    /// long, so that it can be bound.
    ///
    /// # Errors
    /// No memory.
    pub fn push_iter<T: Pod>(
        &mut self,
        items: impl ExactSizeIterator<Item = T>,
    ) -> Result<BufferSlice, Error> {
        let item_bytes = size_of::<T>();
        let size_bytes = (items.len().max(1) * item_bytes).max(4) as u64;
        let mut start = self.used_bytes.next_multiple_of(self.alignment_bytes);
        let room = self.chunks.last().map_or(0, Buffer::size_bytes);
        if start + size_bytes > room {
            match self.add_chunk(size_bytes.max(room * 2).max(FIRST_CHUNK_BYTES)) {
                Err(error) if error.is_out_of_memory() => self.add_chunk(size_bytes)?,
                added => added?,
            }
            start = 0;
        }
        let Some(chunk) = self.chunks.last_mut() else {
            return Err(Error::TooLarge { what: self.name.clone(), wanted: size_bytes, limit: 0 });
        };
        let slice = BufferSlice { offset_bytes: start, size_bytes, ..chunk.whole() };
        let bytes = chunk.bytes_mut().get_mut(start as usize..).unwrap_or_default();
        for (place, item) in bytes.chunks_exact_mut(item_bytes).zip(items) {
            place.copy_from_slice(bytemuck::bytes_of(&item));
        }
        self.used_bytes = start + size_bytes;
        Ok(slice)
    }

    fn add_chunk(&mut self, size_bytes: u64) -> Result<(), Error> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::VERTEX_BUFFER
            | vk::BufferUsageFlags::INDEX_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC;
        let chunk = Buffer::new(&self.device, &self.name, size_bytes, usage, MemoryKind::Upload)?;
        self.chunks.push(chunk);
        self.used_bytes = 0;
        Ok(())
    }
}
