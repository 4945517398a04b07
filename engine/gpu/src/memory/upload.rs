//! Upload memory of a frame: the CPU writes it while the frame is recorded, and it is reused when
//! the frame is over.

use ash::vk;
use bytemuck::Pod;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::memory::buffer::{Buffer, BufferSlice, MemoryKind};

/// A linear arena in mapped memory. After the first frames it is a single chunk and does not
/// allocate. Large data, such as that of all objects of a scene in its first frame, has buffers of
/// its own, which are freed after a frame that does not need them.
pub struct Uploads {
    device: Device,
    chunks: Vec<Buffer>,
    used_bytes: u64,
    large: Vec<LargeUpload>,
    alignment_bytes: u64,
    name: String,
}

const FIRST_CHUNK_BYTES: u64 = 1 << 20;

/// The least size of data that gets a buffer of its own.
const LARGE_BYTES: u64 = 16 << 20;

/// A buffer for data of at least [`LARGE_BYTES`].
struct LargeUpload {
    buffer: Buffer,
    /// True if the present frame has written it.
    is_used: bool,
}

impl Uploads {
    pub(crate) fn new(device: &Device, name: &str) -> Self {
        let limits = &device.adapter().limits;
        let alignment_bytes = limits.min_storage_buffer_offset_alignment.max(16);
        Self {
            device: device.clone(),
            chunks: Vec::new(),
            used_bytes: 0,
            large: Vec::new(),
            alignment_bytes,
            name: name.to_owned(),
        }
    }

    /// Resets the arena. If the last frame needed several chunks, they are replaced by one. Large
    /// buffers that it did not write are freed.
    pub(crate) fn reset(&mut self) -> Result<(), Error> {
        self.used_bytes = 0;
        self.large.retain_mut(|large| std::mem::take(&mut large.is_used));
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
        let size_bytes = (items.len().max(1) * size_of::<T>()).max(4) as u64;
        let place = self.place(size_bytes)?;
        let slice = BufferSlice { offset_bytes: place.start, size_bytes, ..place.buffer.whole() };
        let bytes = place.buffer.bytes_mut().get_mut(place.start as usize..).unwrap_or_default();
        for (to, item) in bytes.chunks_exact_mut(size_of::<T>()).zip(items) {
            to.copy_from_slice(bytemuck::bytes_of(&item));
        }
        Ok(slice)
    }

    /// Returns a place for `size_bytes` that is free in this frame.
    fn place(&mut self, size_bytes: u64) -> Result<Place<'_>, Error> {
        if size_bytes >= LARGE_BYTES {
            return self.large_place(size_bytes);
        }
        let mut start = self.used_bytes.next_multiple_of(self.alignment_bytes);
        let room = self.chunks.last().map_or(0, Buffer::size_bytes);
        if start + size_bytes > room {
            match self.add_chunk(size_bytes.max(room * 2).max(FIRST_CHUNK_BYTES)) {
                Err(error) if error.is_out_of_memory() => self.add_chunk(size_bytes)?,
                added => added?,
            }
            start = 0;
        }
        self.used_bytes = start + size_bytes;
        let none = || Error::TooLarge { what: self.name.clone(), wanted: size_bytes, limit: 0 };
        let buffer = self.chunks.last_mut().ok_or_else(none)?;
        Ok(Place { buffer, start })
    }

    /// Returns a buffer of the last frame that has the size, or a new one.
    fn large_place(&mut self, size_bytes: u64) -> Result<Place<'_>, Error> {
        let fits = |large: &LargeUpload| !large.is_used && large.buffer.size_bytes() >= size_bytes;
        let index = match self.large.iter().position(fits) {
            Some(index) => index,
            None => {
                let buffer = self.buffer(size_bytes)?;
                self.large.push(LargeUpload { buffer, is_used: true });
                self.large.len() - 1
            }
        };
        let large = &mut self.large[index];
        large.is_used = true;
        Ok(Place { buffer: &mut large.buffer, start: 0 })
    }

    fn add_chunk(&mut self, size_bytes: u64) -> Result<(), Error> {
        let chunk = self.buffer(size_bytes)?;
        self.chunks.push(chunk);
        self.used_bytes = 0;
        Ok(())
    }

    fn buffer(&self, size_bytes: u64) -> Result<Buffer, Error> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::VERTEX_BUFFER
            | vk::BufferUsageFlags::INDEX_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC;
        Buffer::new(&self.device, &self.name, size_bytes, usage, MemoryKind::Upload)
    }
}

/// A free place in a buffer, from the byte `start` on.
struct Place<'a> {
    buffer: &'a mut Buffer,
    start: u64,
}
