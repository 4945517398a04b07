//! The indices of instances as a vertex attribute: one buffer per device, which grows.
//!
//! Vertex shaders of indirect draws do not read the built-in instance index. That index includes
//! the first instance of the draw, and some hardware (Intel's, with Mesa's ANV) can only execute a
//! list of draws without help of the driver if no shader reads it. The attribute has the same
//! value.
//!
//! The indices lie in the device's own memory if the CPU can write to it (Vulkan's `DEVICE_LOCAL`
//! with `HOST_VISIBLE`, which the allocator prefers for [`MemoryKind::Upload`]; today's GPUs have
//! 256 MiB or more of it). So no copy is needed, and no frame waits for one.

use ash::vk;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::number_buffer::NumberBuffer;
use crate::memory::buffer::{Buffer, MemoryKind};

/// The location of the attribute, after the attributes of all vertex layouts; mirrors
/// `instance_number.glsl`.
pub const NUMBER_LOCATION: u32 = 7;

/// The binding of the buffer, after the bindings of all vertex layouts.
pub const NUMBER_BINDING: u32 = 2;

/// The least number of indices in a buffer.
const COUNT_MIN: u64 = 4096;

/// Returns the device's buffer of indices, with at least `count` of them. Does not wait: the CPU
/// writes the indices before any command reads them.
pub(crate) fn instance_numbers(device: &Device, count: u64) -> Result<vk::Buffer, Error> {
    let mut numbers = device.number_buffer();
    if let Some(enough) = numbers.as_ref().filter(|numbers| numbers.count >= count) {
        return Ok(enough.raw);
    }
    let count = count.max(COUNT_MIN).next_power_of_two().min(1 << 32);
    let usage = vk::BufferUsageFlags::VERTEX_BUFFER;
    let bytes = count * size_of::<u32>() as u64;
    let mut buffer = Buffer::new(device, "instance numbers", bytes, usage, MemoryKind::Upload)?;
    for (bytes, number) in buffer.bytes_mut().as_chunks_mut().0.iter_mut().zip(0_u64..) {
        *bytes = (number as u32).to_ne_bytes();
    }
    if let Some((raw, allocation)) = buffer.into_parts()
        && let Some(smaller) = numbers.replace(NumberBuffer { raw, allocation, count })
    {
        device.retire(smaller.into());
    }
    Ok(numbers.as_ref().map_or(vk::Buffer::null(), |numbers| numbers.raw))
}
