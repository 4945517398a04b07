//! The allocation callbacks of a host, which drivers call for memory of the CPU.

use ash::vk;

/// The callbacks of a host, or none.
#[derive(Default)]
pub(crate) struct HostCallbacks(Option<vk::AllocationCallbacks<'static>>);

// SAFETY: `Device::adopt` has the host promise that the callbacks may be called on any thread, with
// their user data.
unsafe impl Send for HostCallbacks {}
// SAFETY: as above; nothing here changes.
unsafe impl Sync for HostCallbacks {}

impl HostCallbacks {
    pub(crate) fn new(callbacks: Option<vk::AllocationCallbacks<'static>>) -> Self {
        Self(callbacks)
    }

    /// Returns them as the calls of Vulkan take them.
    pub(crate) fn get(&self) -> Option<&vk::AllocationCallbacks<'static>> {
        self.0.as_ref()
    }
}
