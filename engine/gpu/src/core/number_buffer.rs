//! The buffer of ascending numbers that a device keeps for vertex shaders.

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use crate::core::deletion::Retired;

/// A buffer of the numbers 0, 1, 2, ... in mapped memory. It is never rewritten: if more numbers
/// are needed, a larger buffer replaces it, while frames may still use the old one.
pub(crate) struct NumberBuffer {
    pub(crate) raw: vk::Buffer,
    pub(crate) allocation: Allocation,
    pub(crate) count: u64,
}

impl From<NumberBuffer> for Retired {
    fn from(numbers: NumberBuffer) -> Self {
        Retired::Buffer(numbers.raw, numbers.allocation)
    }
}
