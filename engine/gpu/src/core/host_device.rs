//! The description of a host's device by the host.

use std::any::Any;
use std::ffi::CString;
use std::sync::Arc;

use ash::vk;

use crate::core::features::Features;
use crate::core::open_device::DeviceOptions;
use crate::core::queue_lock::HostQueueLock;

/// A device that a host created and keeps owning, for [`Device::adopt`](crate::Device::adopt).
pub struct HostDevice {
    /// The entry through which the instance was created.
    pub entry: ash::Entry,
    /// The instance.
    pub instance: ash::Instance,
    /// The physical device.
    pub physical_device: vk::PhysicalDevice,
    /// The device.
    pub device: ash::Device,
    /// The queue family of the command buffers that the engine records into.
    pub queue_family: u32,
    /// The Vulkan version that the instance was created for.
    pub api_version: u32,
    /// The names of the enabled extensions: all device extensions, and `VK_EXT_debug_utils` of the
    /// instance. Unknown names are ignored.
    pub extensions: Vec<CString>,
    /// The enabled features.
    pub features: Features,
    /// The callbacks for CPU memory. All objects that the engine makes from the device use them,
    /// except blocks of GPU memory (`vkAllocateMemory`), because their allocator does not support
    /// callbacks.
    pub allocation_callbacks: Option<vk::AllocationCallbacks<'static>>,
    /// The cache for the engine's pipelines. Without it the engine creates its own.
    pub pipeline_cache: Option<vk::PipelineCache>,
    /// The queue that the engine submits to. Without it the engine never submits: it records into
    /// the host's command buffers and uses the host's frame numbers as its clock.
    pub queue: Option<HostQueue>,
    /// The bound of waits, and the file of the engine's own pipeline cache.
    pub options: DeviceOptions,
    /// An owner of the handles, which the engine drops after its last use of them. With it a host
    /// in safe code needs no order in which its objects and the engine's are dropped.
    pub owner: Option<Arc<dyn Any + Send + Sync>>,
}

impl HostDevice {
    /// Describes a device of a Vulkan 1.3 instance without extensions, features and queue: set what
    /// the device has beside.
    pub fn new(
        entry: ash::Entry,
        instance: ash::Instance,
        physical_device: vk::PhysicalDevice,
        device: ash::Device,
        queue_family: u32,
    ) -> Self {
        Self {
            entry,
            instance,
            physical_device,
            device,
            queue_family,
            api_version: vk::API_VERSION_1_3,
            extensions: Vec::new(),
            features: Features::default(),
            allocation_callbacks: None,
            pipeline_cache: None,
            queue: None,
            options: DeviceOptions::default(),
            owner: None,
        }
    }
}

/// A queue that the host and the engine share.
pub struct HostQueue {
    /// The queue, of the family [`HostDevice::queue_family`].
    pub raw: vk::Queue,
    /// The lock that excludes other users of the queue while the engine submits.
    pub lock: Arc<dyn HostQueueLock>,
}
