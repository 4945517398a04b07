//! The device: one queue, one timeline, one allocator, and everything that outlives a frame.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ash::{ext, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use crate::adapter::Adapter;
use crate::capabilities::{Capabilities, Optional};
use crate::deletion::{DeletionQueue, Garbage, Recording};
use crate::error::{Called, Error};
use crate::instance::{Instance, InstanceShared};
use crate::pipeline_cache::PipelineCache;
use crate::timeline::{Tick, Timeline, create_semaphore};

/// How to make a [`Device`].
#[derive(Debug, Clone)]
pub struct DeviceOptions {
    /// Where compiled pipelines are kept between runs; `None` keeps none. A file that belongs to
    /// another device or driver, or is damaged, is ignored and replaced.
    pub pipeline_cache: Option<PathBuf>,
    /// The bound of every wait. A frame that takes longer is an error, not a hang.
    pub wait_bound: Duration,
}

impl Default for DeviceOptions {
    fn default() -> Self {
        // A million objects on a software driver take half a minute a frame.
        Self { pipeline_cache: None, wait_bound: Duration::from_secs(300) }
    }
}

/// How often the CPU waited for the GPU since the device was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WaitCounts {
    /// Waits for a frame slot's own tick of N frames ago: what bounds the frames in flight.
    pub slot: u64,
    /// All others: loading, draining, [`crate::Frame::wait`]. In a frame loop, each of them is a stall.
    pub other: u64,
}

/// Why the CPU waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WaitFor {
    Slot,
    Answer,
    Transfer,
    Drain,
}

/// A Vulkan device with one queue. Clones share it; the last one to go waits for the GPU.
#[derive(Clone)]
pub struct Device {
    shared: Arc<DeviceShared>,
}

struct DeviceShared {
    instance: Arc<InstanceShared>,
    raw: ash::Device,
    debug: Option<ext::debug_utils::Device>,
    conditional: Option<ext::conditional_rendering::Device>,
    adapter: Adapter,
    queue_family: u32,
    queue: Mutex<vk::Queue>,
    // None only while dropping.
    allocator: Mutex<Option<Allocator>>,
    deletion: Mutex<DeletionQueue<Garbage>>,
    timeline: vk::Semaphore,
    submitted: AtomicU64,
    wait_bound: Duration,
    slot_waits: AtomicU64,
    other_waits: AtomicU64,
    pipeline_cache: PipelineCache,
}

impl Device {
    /// Opens `adapter` with everything of the capability table that it has.
    ///
    /// # Errors
    /// [`Error::DeviceLacks`] for an adapter that lacks something required; a failed call.
    pub fn new(
        instance: &Instance,
        adapter: &Adapter,
        options: &DeviceOptions,
    ) -> Result<Self, Error> {
        let shared = &instance.shared;
        let (Some(queue_family), None) = (adapter.queue_family, adapter.missing()) else {
            return Err(Error::DeviceLacks {
                device: adapter.name.clone(),
                missing: adapter.missing().unwrap_or_default(),
                available: String::new(),
            });
        };
        let raw = create_raw(shared, adapter, queue_family)?;
        let (timeline, allocator, pipeline_cache) = equip(shared, adapter, &raw, options)
            // SAFETY: nothing made from the device is left.
            .inspect_err(|_| unsafe { raw.destroy_device(None) })?;
        // SAFETY: the family and index were asked for when the device was created.
        let queue = unsafe { raw.get_device_queue(queue_family, 0) };
        let has = |optional| adapter.capabilities.has(optional);
        let device = Self {
            shared: Arc::new(DeviceShared {
                debug: shared
                    .has_debug_utils
                    .then(|| ext::debug_utils::Device::new(&shared.raw, &raw)),
                conditional: has(Optional::ConditionalRendering)
                    .then(|| ext::conditional_rendering::Device::new(&shared.raw, &raw)),
                instance: Arc::clone(shared),
                adapter: adapter.clone(),
                queue_family,
                queue: Mutex::new(queue),
                allocator: Mutex::new(Some(allocator)),
                deletion: Mutex::new(DeletionQueue::new()),
                timeline,
                submitted: AtomicU64::new(0),
                wait_bound: options.wait_bound,
                slot_waits: AtomicU64::new(0),
                other_waits: AtomicU64::new(0),
                pipeline_cache,
                raw,
            }),
        };
        device.name(queue, "queue");
        device.name(timeline, "device timeline");
        Ok(device)
    }

    /// The adapter this device was opened on.
    pub fn adapter(&self) -> &Adapter {
        &self.shared.adapter
    }

    /// What the device can do.
    pub fn capabilities(&self) -> &Capabilities {
        &self.shared.adapter.capabilities
    }

    /// The newest tick that is over. Never waits.
    ///
    /// # Errors
    /// A failed call, a lost device among them.
    pub fn completed(&self) -> Result<Tick, Error> {
        // SAFETY: the device's own timeline.
        unsafe { self.raw().get_semaphore_counter_value(self.shared.timeline) }
            .map(Tick)
            .called("vkGetSemaphoreCounterValue")
    }

    /// The tick of the newest submit.
    pub fn submitted(&self) -> Tick {
        Tick(self.shared.submitted.load(Ordering::Acquire))
    }

    /// Waits until everything submitted is over. For loading and shutting down, not for a frame loop:
    /// it counts as [`WaitCounts::other`].
    ///
    /// # Errors
    /// [`Error::Timeout`], a failed call.
    pub fn drain(&self) -> Result<(), Error> {
        self.wait(self.submitted(), WaitFor::Drain)?;
        self.free_retired()
    }

    /// How often the CPU waited.
    pub fn wait_counts(&self) -> WaitCounts {
        WaitCounts {
            slot: self.shared.slot_waits.load(Ordering::Relaxed),
            other: self.shared.other_waits.load(Ordering::Relaxed),
        }
    }

    /// Memory taken from the driver and memory in use, in bytes.
    pub fn memory_bytes(&self) -> (u64, u64) {
        let allocator = lock(&self.shared.allocator);
        allocator.as_ref().map_or((0, 0), |allocator| {
            let report = allocator.generate_report();
            (report.total_capacity_bytes, report.total_allocated_bytes)
        })
    }

    /// The number of dropped objects that commands being recorded, or the GPU, may still use.
    pub fn retired(&self) -> usize {
        lock(&self.shared.deletion).len()
    }

    /// The one place where the CPU waits for the GPU; every wait is bounded and counted.
    pub(crate) fn wait(&self, tick: Tick, reason: WaitFor) -> Result<(), Error> {
        let (counter, what) = match reason {
            WaitFor::Slot => (&self.shared.slot_waits, "a frame"),
            WaitFor::Answer => (&self.shared.other_waits, "what a frame was asked"),
            WaitFor::Transfer => (&self.shared.other_waits, "a transfer"),
            WaitFor::Drain => (&self.shared.other_waits, "the work in flight"),
        };
        counter.fetch_add(1, Ordering::Relaxed);
        let bound = self.shared.wait_bound;
        match wait_bounded(self.raw(), self.shared.timeline, tick, bound) {
            Err(vk::Result::TIMEOUT) => Err(Error::Timeout { what, seconds: bound.as_secs_f64() }),
            other => other.called("vkWaitSemaphores"),
        }
    }

    /// Submits one command buffer; it starts after `after`, if given, and signals the tick returned.
    pub(crate) fn submit(
        &self,
        commands: vk::CommandBuffer,
        after: Option<(&Timeline, Tick)>,
    ) -> Result<Tick, Error> {
        if after.is_some_and(|(timeline, _)| !timeline.is_of(self)) {
            return Err(Error::WrongCommands("they wait for a timeline of another device"));
        }
        let queue = lock(&self.shared.queue);
        let tick = self.submitted().next();
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let signals = [vk::SemaphoreSubmitInfo::default()
            .semaphore(self.shared.timeline)
            .value(tick.0)
            .stage_mask(all)];
        let waits = after.map(|(timeline, tick)| {
            [vk::SemaphoreSubmitInfo::default()
                .semaphore(timeline.raw)
                .value(tick.0)
                .stage_mask(all)]
        });
        let mut info = vk::SubmitInfo2::default()
            .command_buffer_infos(&commands)
            .signal_semaphore_infos(&signals);
        if let Some(waits) = &waits {
            info = info.wait_semaphore_infos(waits);
        }
        // SAFETY: the queue is ours while the lock is held; the command buffer is complete.
        unsafe { self.raw().queue_submit2(*queue, &[info], vk::Fence::null()) }
            .called("vkQueueSubmit2")?;
        self.shared.submitted.store(tick.0, Ordering::Release);
        Ok(tick)
    }

    /// Takes the payload of a dropped object. Commands being recorded may still use it, so it is
    /// freed when all of them are over, or given up.
    pub(crate) fn retire(&self, garbage: Garbage) {
        let mut deletion = lock(&self.shared.deletion);
        deletion.retire(self.submitted(), garbage);
    }

    /// Begins to record commands, which keep alive all that is dropped until the guard is.
    pub(crate) fn open_recording(&self) -> OpenRecording {
        OpenRecording { device: self.clone(), number: lock(&self.shared.deletion).open() }
    }

    /// Frees what was retired and is no longer in use.
    pub(crate) fn free_retired(&self) -> Result<(), Error> {
        let completed = self.completed()?;
        let mut deletion = lock(&self.shared.deletion);
        while let Some(garbage) = deletion.pop_over(completed) {
            self.shared.destroy(garbage);
        }
        Ok(())
    }

    pub(crate) fn raw(&self) -> &ash::Device {
        &self.shared.raw
    }

    /// Whether both are the same device.
    pub(crate) fn is(&self, other: &Device) -> bool {
        Arc::ptr_eq(&self.shared, &other.shared)
    }

    pub(crate) fn queue_family(&self) -> u32 {
        self.shared.queue_family
    }

    pub(crate) fn debug(&self) -> Option<&ext::debug_utils::Device> {
        self.shared.debug.as_ref()
    }

    pub(crate) fn conditional(&self) -> Option<&ext::conditional_rendering::Device> {
        self.shared.conditional.as_ref()
    }

    pub(crate) fn pipeline_cache(&self) -> vk::PipelineCache {
        self.shared.pipeline_cache.raw
    }

    pub(crate) fn allocator(&self) -> MutexGuard<'_, Option<Allocator>> {
        lock(&self.shared.allocator)
    }

    /// Gives a Vulkan object its debug name, where anyone listens.
    pub(crate) fn name<H: vk::Handle>(&self, handle: H, name: &str) {
        let Some(debug) = self.debug() else { return };
        let name = std::ffi::CString::new(name.replace('\0', " ")).unwrap_or_default();
        let info =
            vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: a live object of this device. A name that cannot be set is no reason to stop.
        let _unnamed_is_fine = unsafe { debug.set_debug_utils_object_name(&info) };
    }
}

/// Commands that are being recorded. Dropped after their last submit, or when there will be none.
pub(crate) struct OpenRecording {
    device: Device,
    pub(crate) number: Recording,
}

impl Drop for OpenRecording {
    fn drop(&mut self) {
        let mut deletion = lock(&self.device.shared.deletion);
        deletion.close(self.number, self.device.submitted());
    }
}

impl DeviceShared {
    /// Keeps everything for ever: destroying what the GPU still uses would be worse. The allocator
    /// would free its memory as it goes, the instance would go before its device.
    fn abandon(&self) {
        std::mem::forget(lock(&self.allocator).take());
        std::mem::forget(Arc::clone(&self.instance));
    }

    fn destroy(&self, garbage: Garbage) {
        let free = |allocation| {
            if let Some(allocator) = lock(&self.allocator).as_mut()
                && let Err(error) = allocator.free(allocation)
            {
                tracing::error!("memory could not be given back: {error}");
            }
        };
        // SAFETY: the deletion queue hands a payload out once, after the last submit that could
        // use it is over; it was made from this device.
        unsafe {
            match garbage {
                Garbage::Buffer(buffer, allocation) => {
                    self.raw.destroy_buffer(buffer, None);
                    free(allocation);
                }
                Garbage::Image(image, view, allocation) => {
                    self.raw.destroy_image_view(view, None);
                    self.raw.destroy_image(image, None);
                    free(allocation);
                }
                Garbage::Pipeline(pipeline) => self.raw.destroy_pipeline(pipeline, None),
                Garbage::PipelineLayout(layout) => self.raw.destroy_pipeline_layout(layout, None),
                Garbage::SetLayout(layout) => self.raw.destroy_descriptor_set_layout(layout, None),
                Garbage::DescriptorPool(pool) => self.raw.destroy_descriptor_pool(pool, None),
                Garbage::CommandPool(pool) => self.raw.destroy_command_pool(pool, None),
                Garbage::QueryPool(pool) => self.raw.destroy_query_pool(pool, None),
                Garbage::Semaphore(semaphore) => self.raw.destroy_semaphore(semaphore, None),
            }
        }
    }
}

impl Drop for DeviceShared {
    fn drop(&mut self) {
        // vkDeviceWaitIdle knows no bound, so the timeline is waited for first.
        let newest = Tick(self.submitted.load(Ordering::Acquire));
        match wait_bounded(&self.raw, self.timeline, newest, self.wait_bound) {
            Ok(()) => {}
            // All work of a lost device is over (Vulkan specification, "Lost Device").
            Err(vk::Result::ERROR_DEVICE_LOST) => tracing::error!("the device was lost"),
            Err(code) => {
                tracing::error!("the GPU did not finish ({code:?}); the device is left as it is");
                self.abandon();
                return;
            }
        }
        // SAFETY: nobody else holds the device.
        if let Err(code) = unsafe { self.raw.device_wait_idle() } {
            tracing::error!("vkDeviceWaitIdle failed with {code:?} while closing the device");
        }
        loop {
            // No recording is open: each holds the device.
            let retired = lock(&self.deletion).pop_over(newest);
            let Some(garbage) = retired else { break };
            self.destroy(garbage);
        }
        self.pipeline_cache.save_and_destroy(&self.raw);
        if let Some(allocator) = lock(&self.allocator).take() {
            // The allocator frees leaked blocks as it goes, so no layer would ever see a leak.
            let leaked = allocator.generate_report().allocations;
            for allocation in &leaked {
                tracing::error!(
                    "leaked GPU memory: {} ({} bytes)",
                    allocation.name,
                    allocation.size
                );
            }
            debug_assert!(leaked.is_empty(), "GPU memory leaked, see the log");
        }
        // SAFETY: everything made from the device is gone.
        unsafe {
            self.raw.destroy_semaphore(self.timeline, None);
            self.raw.destroy_device(None);
        }
        tracing::debug!(
            "device closed; instance users left: {}",
            Arc::strong_count(&self.instance)
        );
    }
}

fn wait_bounded(
    device: &ash::Device,
    timeline: vk::Semaphore,
    tick: Tick,
    bound: Duration,
) -> Result<(), vk::Result> {
    let (semaphores, values) = ([timeline], [tick.0]);
    let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&values);
    let bound_ns = u64::try_from(bound.as_nanos()).unwrap_or(u64::MAX / 2);
    // SAFETY: the device's own timeline.
    unsafe { device.wait_semaphores(&info, bound_ns) }
}

pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A poisoned lock means that a thread panicked; the values behind our locks stay whole.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a device cannot be without. Failing, it leaves nothing behind.
fn equip(
    instance: &InstanceShared,
    adapter: &Adapter,
    raw: &ash::Device,
    options: &DeviceOptions,
) -> Result<(vk::Semaphore, Allocator, PipelineCache), Error> {
    // Owns nothing of the device until memory is asked for.
    let allocator = Allocator::new(&AllocatorCreateDesc {
        instance: instance.raw.clone(),
        device: raw.clone(),
        physical_device: adapter.physical,
        debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
        buffer_device_address: false,
        allocation_sizes: gpu_allocator::AllocationSizes::default(),
    })
    .map_err(Error::Allocator)?;
    let timeline = create_semaphore(raw)?;
    match PipelineCache::open(instance, adapter, raw, options.pipeline_cache.clone()) {
        Ok(pipeline_cache) => Ok((timeline, allocator, pipeline_cache)),
        Err(error) => {
            // SAFETY: just made, used by nobody.
            unsafe { raw.destroy_semaphore(timeline, None) };
            Err(error)
        }
    }
}

fn create_raw(
    instance: &InstanceShared,
    adapter: &Adapter,
    queue_family: u32,
) -> Result<ash::Device, Error> {
    let has = |optional| adapter.capabilities.has(optional);
    let mut conditional =
        vk::PhysicalDeviceConditionalRenderingFeaturesEXT::default().conditional_rendering(true);
    let mut features_12 = vk::PhysicalDeviceVulkan12Features::default()
        .timeline_semaphore(true)
        .draw_indirect_count(has(Optional::DrawIndirectCount));
    let mut features_13 = vk::PhysicalDeviceVulkan13Features::default()
        .dynamic_rendering(true)
        .synchronization2(true);
    let core = vk::PhysicalDeviceFeatures::default()
        .multi_draw_indirect(true)
        .draw_indirect_first_instance(true)
        .occlusion_query_precise(has(Optional::PreciseQueries))
        .fragment_stores_and_atomics(has(Optional::FragmentStores));
    let mut features = vk::PhysicalDeviceFeatures2::default()
        .features(core)
        .push_next(&mut features_12)
        .push_next(&mut features_13);
    let mut extensions = Vec::new();
    if has(Optional::ConditionalRendering) {
        extensions.push(ext::conditional_rendering::NAME.as_ptr());
        features = features.push_next(&mut conditional);
    }
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(queue_family)
        .queue_priorities(&[1.0])];
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .push_next(&mut features);
    // SAFETY: only features and extensions that the adapter reported are asked for.
    unsafe { instance.raw.create_device(adapter.physical, &info, None) }.called("vkCreateDevice")
}
