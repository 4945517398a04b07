//! The buffer of rising numbers that a device keeps for vertex shaders.

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use crate::core::deletion::Retired;

/// A buffer of the numbers 0, 1, 2, ... in mapped memory. A larger one takes its place, and it is
/// never written again, so that frames may use it while there is a newer one.
pub(crate) struct NumberBuffer {
    pub(crate) raw: vk::Buffer,
    pub(crate) allocation: Allocation,
    /// The numbers in it.
    pub(crate) count: u64,
}

impl From<NumberBuffer> for Retired {
    fn from(numbers: NumberBuffer) -> Self {
        Retired::Buffer(numbers.raw, numbers.allocation)
    }
}
