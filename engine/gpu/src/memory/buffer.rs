//! Buffers: each has one allocation and one name, and is retired when it is dropped.

use std::ops::Range;

use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::ownership::{OfDevice, OwnerId};
use crate::core::pending_uploads::UploadToken;
use crate::memory::allocation::{allocate, free};
use crate::memory::device_memory::{MemoryOwner, MemoryRequest};

/// The kind of memory of a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MemoryKind {
    /// GPU memory that the CPU cannot access.
    Device,
    /// Mapped memory that the CPU writes.
    Upload,
    /// Mapped memory that the CPU reads.
    ReadBack,
}

/// A buffer with memory of its own, retired when it is dropped.
pub struct Buffer {
    device: Device,
    raw: vk::Buffer,
    // None only while dropping.
    allocation: Option<Allocation>,
    size_bytes: u64,
    /// Held while the upload of the first contents may be pending.
    upload: Option<UploadToken>,
}

/// A part of a buffer. It is valid for the frame being recorded even if the buffer is dropped
/// meanwhile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BufferSlice {
    pub(crate) raw: vk::Buffer,
    pub(crate) device: OwnerId,
    /// The offset of the part in the buffer.
    pub offset_bytes: u64,
    /// The length of the part.
    pub size_bytes: u64,
}

impl OfDevice for BufferSlice {
    const KIND: &'static str = "a buffer (`BufferSlice`)";

    fn device_id(&self) -> OwnerId {
        self.device
    }
}

impl BufferSlice {
    /// Returns the buffer of the part, for a host that uses it in its own commands.
    #[must_use]
    pub fn raw(&self) -> vk::Buffer {
        self.raw
    }

    /// Returns the part of this slice from `offset_bytes` on, `size_bytes` long, clamped to its
    /// end.
    #[must_use]
    pub fn part(self, offset_bytes: u64, size_bytes: u64) -> Self {
        let offset = offset_bytes.min(self.size_bytes);
        Self {
            offset_bytes: self.offset_bytes + offset,
            size_bytes: size_bytes.min(self.size_bytes - offset),
            ..self
        }
    }

    /// Returns the part of this slice with a range of elements of type `T`, clamped to its end.
    #[must_use]
    pub fn elements<T>(self, range: Range<u32>) -> Self {
        let bytes = size_of::<T>() as u64;
        self.part(u64::from(range.start) * bytes, range.len() as u64 * bytes)
    }
}

impl Buffer {
    /// Creates a buffer of `size_bytes` (at least 4, so that an empty scene still binds something).
    ///
    /// # Errors
    /// No memory, or a failed call.
    pub fn new(
        device: &Device,
        name: &str,
        size_bytes: u64,
        usage: vk::BufferUsageFlags,
        place: MemoryKind,
    ) -> Result<Self, Error> {
        let size_bytes = size_bytes.max(4);
        let info = vk::BufferCreateInfo::default().size(size_bytes).usage(usage);
        // SAFETY: a plain buffer; the size is not zero.
        let raw = unsafe { device.raw().create_buffer(&info, device.callbacks()) }
            .called("vkCreateBuffer")?;
        device.name(raw, name);
        // SAFETY: just made.
        let requirements = unsafe { device.raw().get_buffer_memory_requirements(raw) };
        let location = match place {
            MemoryKind::Device => MemoryLocation::GpuOnly,
            MemoryKind::Upload => MemoryLocation::CpuToGpu,
            MemoryKind::ReadBack => MemoryLocation::GpuToCpu,
        };
        let owner = MemoryOwner::Buffer(raw);
        let request = MemoryRequest { name, owner, requirements, location };
        let allocation = allocate(device, &request).and_then(|memory| {
            // SAFETY: fresh memory that fits the buffer's requirements.
            let bound =
                unsafe { device.raw().bind_buffer_memory(raw, memory.memory(), memory.offset()) };
            match bound.called("vkBindBufferMemory") {
                Ok(()) => Ok(memory),
                Err(error) => {
                    free(device, memory);
                    Err(error)
                }
            }
        });
        let allocation = match allocation {
            Ok(allocation) => Some(allocation),
            Err(error) => {
                // SAFETY: never used.
                unsafe { device.raw().destroy_buffer(raw, device.callbacks()) };
                return Err(error);
            }
        };
        Ok(Self { device: device.clone(), raw, allocation, size_bytes, upload: None })
    }

    /// Makes the next frame of a host copy all of `staging` to this buffer.
    pub(crate) fn upload_later(&mut self, mut staging: Self) {
        if let Some(allocation) = staging.allocation.take() {
            let size_bytes = staging.size_bytes;
            let mut pending = self.device.pending_uploads();
            let token =
                pending.push(staging.raw, allocation, self.raw, size_bytes.min(self.size_bytes));
            drop(pending);
            self.upload = Some(token);
        }
    }

    /// Returns the size in bytes.
    pub fn size_bytes(&self) -> u64 {
        self.size_bytes
    }

    /// Returns the whole buffer as a slice.
    pub fn whole(&self) -> BufferSlice {
        let raw = self.raw;
        let device = self.device.id();
        BufferSlice { raw, device, offset_bytes: 0, size_bytes: self.size_bytes }
    }

    /// Returns the elements `range` of the mapped memory as `T`; empty if they do not exist. The
    /// caller must know by a tick that the GPU has finished writing.
    pub fn read<T: Pod>(&self, range: Range<usize>) -> &[T] {
        let size = size_of::<T>();
        let bytes = self.allocation.as_ref().and_then(Allocation::mapped_slice).unwrap_or(&[]);
        let bytes = bytes.get(range.start * size..range.end * size).unwrap_or(&[]);
        bytemuck::try_cast_slice(bytes).unwrap_or(&[])
    }

    /// Copies `items` to the beginning of mapped memory, cut to the size of the buffer. The caller
    /// must know by a tick that the GPU has finished reading the old contents.
    pub fn write<T: Copy>(&mut self, items: &[T]) {
        let bytes = self.bytes_mut();
        let size = size_of_val(items).min(bytes.len());
        // SAFETY: `size` bytes are mapped, and the borrow is exclusive. Padding bytes between the
        // fields of an item may be uninitialised: they are copied, never read.
        unsafe {
            let from = items.as_ptr().cast::<u8>();
            std::ptr::copy_nonoverlapping(from, bytes.as_mut_ptr(), size);
        }
    }

    /// Returns the buffer and its memory, and passes their ownership to the caller.
    pub(crate) fn into_parts(mut self) -> Option<(vk::Buffer, Allocation)> {
        Some((self.raw, self.allocation.take()?))
    }

    /// Returns the mapped bytes, for the upload arena.
    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        self.allocation.as_mut().and_then(Allocation::mapped_slice_mut).unwrap_or(&mut [])
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        if let Some(allocation) = self.allocation.take() {
            self.device.retire(Retired::Buffer(self.raw, allocation));
        }
    }
}
