//! Memory for the buffers and images of a device.

use gpu_allocator::vulkan::Allocation;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::memory::device_memory::MemoryRequest;
use crate::memory::memory_error::{MemoryError, MemoryFailure};

/// Allocates memory for a buffer or an image. If there is none, frees what is retired and over, and
/// then makes all attempts.
pub(crate) fn allocate(device: &Device, request: &MemoryRequest<'_>) -> Result<Allocation, Error> {
    let failed = |failure| {
        let in_use = device.memory_use();
        let what = request.name.to_owned();
        Error::Memory(Box::new(MemoryError {
            what,
            size_bytes: request.requirements.size,
            failure,
            in_use,
        }))
    };
    let first = match device.memory().as_mut() {
        Some(memory) => memory.allocate_plainly(request),
        None => Err(MemoryFailure::NoType),
    };
    match first {
        Err(failure) if failure.is_out_of_memory() => {}
        first => return first.map_err(failed),
    }
    if let Err(error) = device.free_retired() {
        tracing::debug!("nothing is freed for {}: {error}", request.name);
    }
    let all = match device.memory().as_mut() {
        Some(memory) => memory.allocate(request),
        None => Err(MemoryFailure::NoType),
    };
    all.map_err(failed)
}

/// Allocates memory for an image that the device provides only when the image is stored; `None` if
/// there is no memory of this kind.
pub(crate) fn allocate_lazily(device: &Device, request: &MemoryRequest<'_>) -> Option<Allocation> {
    device.memory().as_mut()?.allocate_lazily(request)
}

pub(crate) fn free(device: &Device, allocation: Allocation) {
    if let Some(memory) = device.memory().as_mut() {
        memory.free(allocation);
    }
}
