//! Opening a device: requests the features and extensions, and creates the objects that every
//! device needs.

use std::any::Any;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use ash::vk;

use crate::core::adapter::Adapter;
use crate::core::capabilities::Purpose;
use crate::core::clock::{Clock, ClockSource, OwnTimeline};
use crate::core::deletion::DeletionQueue;
use crate::core::device_shared::DeviceShared;
use crate::core::error::{Called, Error};
use crate::core::extensions::Extensions;
use crate::core::host_callbacks::HostCallbacks;
use crate::core::instance::InstanceShared;
use crate::core::offer::Offer;
use crate::core::ownership::{OwnerId, Ownership};
use crate::core::pipeline_cache::PipelineCache;
use crate::core::queue_lock::QueueLock;
use crate::core::requirements::Requirements;
use crate::core::tick::create_semaphore;
use crate::memory::device_memory::DeviceMemory;

/// The options of a [`Device`](crate::Device).
#[derive(Debug, Clone)]
pub struct DeviceOptions {
    /// The file that keeps compiled pipelines between runs; `None` for no file. A file that belongs
    /// to another device or driver, or is damaged, is ignored and replaced.
    pub pipeline_cache: Option<PathBuf>,
    /// The bound of every wait. A frame that takes longer results in an error, not a hang.
    pub wait_bound: Duration,
    /// The most bytes of memory that the device takes from the driver, of all kinds, in blocks that
    /// buffers and images share. Beyond it, scenes are loaded with smaller textures, and what does
    /// not fit is an error ([`Error::Memory`](crate::Error::Memory)). `None` for no bound but that
    /// of the device.
    pub memory_budget_bytes: Option<u64>,
}

impl Default for DeviceOptions {
    fn default() -> Self {
        // A frame of a million objects takes half a minute on a software driver.
        Self {
            pipeline_cache: None,
            wait_bound: Duration::from_secs(300),
            memory_budget_bytes: None,
        }
    }
}

/// A raw device, created by the engine or a host, with the data that is needed to use it.
pub(crate) struct RawDevice {
    pub(crate) instance: Arc<InstanceShared>,
    pub(crate) adapter: Adapter,
    pub(crate) raw: ash::Device,
    pub(crate) ownership: Ownership,
    pub(crate) queue_family: u32,
    /// The queue to submit to; `None` for an executor that records into a host's command buffers.
    pub(crate) queue: Option<QueueLock<vk::Queue>>,
    pub(crate) callbacks: HostCallbacks,
    /// The pipeline cache of a host.
    pub(crate) pipeline_cache: Option<vk::PipelineCache>,
    /// An owner of the handles of a host.
    pub(crate) owner: Option<Arc<dyn Any + Send + Sync>>,
}

/// Creates the objects that every device needs: timeline, allocator, pipeline cache. If it fails,
/// none of them is left.
pub(crate) fn equip(device: RawDevice, options: &DeviceOptions) -> Result<DeviceShared, Error> {
    let RawDevice { instance, adapter, raw, ownership, queue_family, queue, callbacks, .. } =
        device;
    // Owns no object of the device until memory is requested.
    let budget_bytes = options.memory_budget_bytes;
    let extensions = Extensions::load(&instance, &raw, &adapter.capabilities);
    let debug = extensions.debug.clone();
    let memory = DeviceMemory::new(&instance, adapter.physical, &raw, debug, budget_bytes)?;
    let pipeline_cache = match device.pipeline_cache {
        Some(cache) => PipelineCache::of_host(cache),
        None => {
            let path = options.pipeline_cache.clone();
            PipelineCache::open(&instance, &adapter, &raw, &callbacks, path)?
        }
    };
    let source = match queue {
        None => ClockSource::HostFrames,
        Some(queue) => {
            let semaphore = create_semaphore(&raw, callbacks.get())
                .inspect_err(|_| pipeline_cache.destroy(&raw, &callbacks))?;
            ClockSource::Timeline(OwnTimeline { queue, semaphore })
        }
    };
    Ok(DeviceShared {
        id: OwnerId::new(),
        extensions,
        instance,
        adapter,
        ownership,
        queue_family,
        callbacks,
        memory: Mutex::new(Some(memory)),
        deletion: Mutex::new(DeletionQueue::new()),
        clock: Clock::new(source),
        executions: Mutex::default(),
        pending_uploads: Mutex::default(),
        numbers: Mutex::default(),
        wait_bound: options.wait_bound,
        is_lost: AtomicBool::new(false),
        hangs: AtomicBool::new(false),
        slot_waits: AtomicU64::new(0),
        other_waits: AtomicU64::new(0),
        pipeline_cache,
        raw,
        owner: device.owner,
    })
}

/// Creates a device for the engine itself, by the requirements that hosts also get.
pub(super) fn create_raw(
    instance: &InstanceShared,
    adapter: &Adapter,
    queue_family: u32,
) -> Result<ash::Device, Error> {
    // SAFETY: the adapter is of this instance.
    let offer = unsafe { Offer::read(&instance.raw, adapter.physical, instance.windows.as_ref()) }?;
    let needs = Requirements::new(&adapter.name, &offer, &adapter.capabilities, Purpose::Renderer);
    let names = needs.extensions();
    let mut structures = needs.features().structures();
    let mut features = structures.link(&names);
    let extensions: Vec<_> = names.iter().map(|name| name.as_ptr()).collect();
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(queue_family)
        .queue_priorities(&[1.0])];
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .push_next(&mut features);
    // SAFETY: only features and extensions that the adapter reported are requested.
    unsafe { instance.raw.create_device(adapter.physical, &info, None) }.called("vkCreateDevice")
}
