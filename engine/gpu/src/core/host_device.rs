//! The device of a host, as the host describes it.

use std::ffi::CString;
use std::sync::Arc;

use ash::vk;

use crate::core::features::Features;
use crate::core::open_device::DeviceOptions;
use crate::core::queue_lock::HostQueueLock;

/// A device that a host made and goes on to own, for [`Device::adopt`](crate::Device::adopt).
pub struct HostDevice {
    /// The entry through which the instance was made.
    pub entry: ash::Entry,
    /// The instance.
    pub instance: ash::Instance,
    /// The physical device.
    pub physical_device: vk::PhysicalDevice,
    /// The device.
    pub device: ash::Device,
    /// The queue family of the command buffers that the engine records into.
    pub queue_family: u32,
    /// The version of Vulkan that the instance was made for.
    pub api_version: u32,
    /// The names of the extensions that are on, those of the device and `VK_EXT_debug_utils` of the
    /// instance. Names that the engine does not know are ignored.
    pub extensions: Vec<CString>,
    /// The features that are on.
    pub features: Features,
    /// The callbacks for memory of the CPU. Everything that the engine makes from the device gets
    /// them, except blocks of GPU memory (`vkAllocateMemory`), whose allocator knows none.
    pub allocation_callbacks: Option<vk::AllocationCallbacks<'static>>,
    /// The cache for the engine's pipelines. Without one the engine has its own.
    pub pipeline_cache: Option<vk::PipelineCache>,
    /// The queue that the engine submits to. Without one it never submits: it records into the
    /// host's command buffers, and the host's frame numbers are its clock.
    pub queue: Option<HostQueue>,
    /// The bound of waits, and the file of a pipeline cache of the engine's own.
    pub options: DeviceOptions,
}

/// A queue that host and engine share.
pub struct HostQueue {
    /// The queue, of the family [`HostDevice::queue_family`].
    pub raw: vk::Queue,
    /// The lock that keeps others from the queue while the engine submits.
    pub lock: Arc<dyn HostQueueLock>,
}
