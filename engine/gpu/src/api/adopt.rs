//! Adopting the device of a host.

use std::sync::Arc;

use ash::vk;

use crate::core::adapter::Adapter;
use crate::core::capabilities::Purpose;
use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::host_callbacks::HostCallbacks;
use crate::core::host_device::HostDevice;
use crate::core::instance::InstanceShared;
use crate::core::offer::Offer;
use crate::core::open_device::{RawDevice, equip};
use crate::core::ownership::Ownership;
use crate::core::queue_lock::QueueLock;
use crate::core::requirements::Requirements;

impl Device {
    /// Adopts the device of a host, which was created according to [`Requirements`].
    ///
    /// Without [`HostDevice::queue`] the device never submits: it is for an executor that records
    /// into the host's command buffers. Its [ticks](crate::Tick) are then the numbers of the host's
    /// frames, and [`Device::host_finished`] must be called before its last handle is dropped. With
    /// a queue it works like a device of [`Device::new`]. An optional capability is available if
    /// its features and extensions are enabled.
    ///
    /// The engine never destroys objects of the host, and does not show frames in windows. A device
    /// may be adopted more than once; objects made from one handle cannot be used with the other.
    ///
    /// ```no_run
    /// # use antumbra_gpu as gpu;
    /// # use gpu::{Features, Purpose, Requirements, Tick, vk};
    /// # use std::ffi::CString;
    /// # struct Host { entry: ash::Entry, instance: ash::Instance, physical: vk::PhysicalDevice,
    /// #     device: ash::Device, family: u32, extensions: Vec<CString>, features: Features }
    /// # fn draw(host: &Host, commands: vk::CommandBuffer) -> Result<(), gpu::Error> {
    /// // The host has made its device with what `Requirements` say, and has kept the names and
    /// // features that it turned on. Then, once:
    /// let description = gpu::HostDevice {
    ///     entry: host.entry.clone(),
    ///     instance: host.instance.clone(),
    ///     physical_device: host.physical,
    ///     device: host.device.clone(),
    ///     queue_family: host.family,
    ///     api_version: vk::API_VERSION_1_3,
    ///     extensions: host.extensions.clone(),
    ///     features: host.features,
    ///     allocation_callbacks: None,
    ///     pipeline_cache: None,
    ///     queue: None,
    ///     options: gpu::DeviceOptions::default(),
    ///     owner: None,
    /// };
    /// // SAFETY: the handles belong together, and are destroyed after `device`.
    /// let device = unsafe { gpu::Device::adopt(description) }?;
    /// let mut ring = gpu::FrameRing::new(&device, 3)?;
    ///
    /// // In each frame, while the host records `commands`; frame 16 is the last that is over.
    /// let numbers = gpu::FrameNumbers { current: Tick(18), safe: Tick(16) };
    /// // SAFETY: the commands are being recorded, and the frames up to 16 are over.
    /// let frame = unsafe { ring.begin_in(commands, numbers) }?;
    /// frame.end()?;
    ///
    /// // At the end, after the host has waited for its queue.
    /// drop(ring);
    /// // SAFETY: the queue is idle.
    /// unsafe { device.host_finished() }?;
    /// # Ok(()) }
    /// ```
    ///
    /// # Safety
    /// - The handles are alive, belong together as the fields say, and outlive this device, all of
    ///   its clones, and all objects made from them. If `owner` is set, it suffices that
    ///   they live as long as it.
    /// - `api_version`, `extensions` and `features` name only what is enabled.
    /// - `allocation_callbacks` may be called on any thread with their user data during this time.
    /// - `pipeline_cache` is not `EXTERNALLY_SYNCHRONIZED`.
    /// - While the lock of `queue` is held, no other thread uses the queue.
    ///
    /// # Errors
    /// [`Error::DeviceLacks`] with the names of required capabilities that are not enabled; a
    /// failed call.
    pub unsafe fn adopt(host: HostDevice) -> Result<Self, Error> {
        let purpose = match host.queue {
            Some(_) => Purpose::Renderer,
            None => Purpose::Executor,
        };
        let instance =
            Arc::new(InstanceShared::of_host(host.entry, host.instance, &host.extensions));
        let physical = host.physical_device;
        let family = host.queue_family;
        // SAFETY: the caller promises that the handles belong together, here and below.
        let mut offer = unsafe { Offer::of_family(&instance.raw, physical, family) }?;
        offer.api_version = offer.api_version.min(host.api_version);
        offer.turn_on(host.extensions, host.features);
        // SAFETY: as above.
        let adapter = unsafe { Adapter::read(&instance, physical, &offer) };
        Requirements::new(&adapter.name, &offer, &adapter.capabilities, purpose).check()?;
        let queue = host.queue.map(|queue| QueueLock::new(queue.raw, Some(queue.lock)));
        let device = RawDevice {
            instance,
            adapter,
            raw: host.device,
            ownership: Ownership::Host,
            queue_family: family,
            queue,
            callbacks: HostCallbacks::new(host.allocation_callbacks),
            pipeline_cache: host.pipeline_cache.filter(|cache| *cache != vk::PipelineCache::null()),
            owner: host.owner,
        };
        equip(device, &host.options).map(Self::of)
    }
}
