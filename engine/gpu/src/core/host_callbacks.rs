//! The allocation callbacks of a host, which drivers call for CPU memory.

use ash::vk;

/// The callbacks of a host, if it has any.
#[derive(Default)]
pub(crate) struct HostCallbacks(Option<vk::AllocationCallbacks<'static>>);

// SAFETY: the caller of `Device::adopt` promises that the callbacks may be called on any thread
// with their user data.
unsafe impl Send for HostCallbacks {}
// SAFETY: as above; the value never changes.
unsafe impl Sync for HostCallbacks {}

impl HostCallbacks {
    pub(crate) fn new(callbacks: Option<vk::AllocationCallbacks<'static>>) -> Self {
        Self(callbacks)
    }

    /// Returns the callbacks in the form that Vulkan calls take.
    pub(crate) fn get(&self) -> Option<&vk::AllocationCallbacks<'static>> {
        self.0.as_ref()
    }
}
