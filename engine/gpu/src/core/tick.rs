//! Ticks: values of a timeline semaphore, which prove that work on the GPU is over.

use ash::vk;

use crate::core::error::{Called, Error};

/// A value of a timeline. Ticks of a device are numbered from 1 in the order of its submits. On a
/// device that records into a host's command buffers, they are the numbers of the host's frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Tick(pub u64);

impl Tick {
    /// The tick before any work.
    pub const ZERO: Tick = Tick(0);

    /// Returns the tick after this one.
    pub fn next(self) -> Tick {
        Tick(self.0 + 1)
    }
}

pub(crate) fn create_semaphore(
    device: &ash::Device,
    callbacks: Option<&vk::AllocationCallbacks<'_>>,
) -> Result<vk::Semaphore, Error> {
    let mut kind =
        vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
    let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
    // SAFETY: timelineSemaphore is a required feature.
    unsafe { device.create_semaphore(&info, callbacks) }.called("vkCreateSemaphore")
}
