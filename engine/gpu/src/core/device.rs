//! The device: one queue, one timeline, one allocator, and all objects that outlive a frame.

use std::sync::atomic::Ordering;
use std::sync::{Arc, MutexGuard};
use std::time::{Duration, Instant};

use ash::{ext, vk};

use crate::core::adapter::Adapter;
use crate::core::capabilities::{Capabilities, OptionalFeature};
use crate::core::clock::ClockSource;
use crate::core::debug_name::set_debug_name;
use crate::core::deletion::{RecordingId, Retired};
use crate::core::device_shared::{DeviceShared, wait_bounded};
use crate::core::error::{Called, Error};
use crate::core::executions::Executions;
use crate::core::extensions::Extensions;
use crate::core::host_callbacks::HostCallbacks;
use crate::core::instance::{Instance, InstanceShared};
use crate::core::number_buffer::NumberBuffer;
use crate::core::open_device::{DeviceOptions, RawDevice, create_raw, equip};
use crate::core::order::Order;
use crate::core::ownership::{self, OfDevice, OwnerId, Ownership};
use crate::core::pending_uploads::PendingUploads;
use crate::core::queue_lock::{QueueLock, lock};
use crate::core::tick::Tick;
use crate::memory::device_memory::DeviceMemory;
use crate::memory::memory_use::MemoryUse;

/// The numbers of times that the CPU waited for the GPU since the device was created.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WaitCounts {
    /// Waits for the tick of a frame slot, N frames ago; these bound the frames in flight.
    pub slot: u64,
    /// All other waits: loading, draining, [`crate::Frame::wait`]. In a frame loop, each of them is
    /// a stall.
    pub other: u64,
}

/// The reason for which the CPU waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WaitFor {
    Slot,
    Answer,
    Transfer,
    Drain,
}

/// A Vulkan device with one queue. Clones share it; dropping the last clone waits for the GPU.
#[derive(Clone)]
pub struct Device {
    shared: Arc<DeviceShared>,
}

impl Device {
    /// Opens `adapter` with all entries of the capability table that it has.
    ///
    /// # Errors
    /// [`Error::Foreign`] for an adapter of another instance; [`Error::DeviceLacks`] for an adapter
    /// without a required capability; a failed call.
    pub fn new(
        instance: &Instance,
        adapter: &Adapter,
        options: &DeviceOptions,
    ) -> Result<Self, Error> {
        let shared = &instance.shared;
        ownership::check(adapter.instance, shared.id, "an adapter", "an instance", "Instance")?;
        let (Some(queue_family), None) = (adapter.queue_family, adapter.missing()) else {
            return Err(Error::DeviceLacks {
                device: adapter.name.clone(),
                missing: adapter.missing().unwrap_or_default(),
                available: String::new(),
            });
        };
        let raw = create_raw(shared, adapter, queue_family)?;
        // SAFETY: the family and index were requested when the device was created.
        let queue = unsafe { raw.get_device_queue(queue_family, 0) };
        let device = RawDevice {
            instance: Arc::clone(shared),
            adapter: adapter.clone(),
            raw: raw.clone(),
            ownership: Ownership::Ours,
            queue_family,
            queue: Some(QueueLock::new(queue, None)),
            callbacks: HostCallbacks::default(),
            pipeline_cache: None,
            owner: None,
        };
        let shared = equip(device, options)
            // SAFETY: nothing made from the device is left.
            .inspect_err(|_| unsafe { raw.destroy_device(None) })?;
        let device = Self::of(shared);
        device.name(device.raw().handle(), &adapter.name);
        device.name(queue, "queue");
        Ok(device)
    }

    /// Returns the first handle of a device.
    pub(crate) fn of(shared: DeviceShared) -> Self {
        let device = Self { shared: Arc::new(shared) };
        if let ClockSource::Timeline(timeline) = &device.shared.clock.source {
            device.name(timeline.semaphore, "device timeline");
        }
        if device.shared.pipeline_cache.ownership == Ownership::Ours {
            device.name(device.pipeline_cache(), "compiled pipelines");
        }
        device
    }

    /// Returns the adapter that this device was opened on.
    pub fn adapter(&self) -> &Adapter {
        &self.shared.adapter
    }

    /// Returns the capabilities of the device.
    pub fn capabilities(&self) -> &Capabilities {
        &self.shared.adapter.capabilities
    }

    /// Checks that the device has a feature. `wanted` is what needs it, for the error.
    ///
    /// # Errors
    /// [`Error::Unsupported`].
    pub fn require(&self, feature: OptionalFeature, wanted: &'static str) -> Result<(), Error> {
        if self.capabilities().has(feature) {
            return Ok(());
        }
        let device = self.adapter().name.clone();
        Err(Error::Unsupported { device, missing: feature.name(), wanted })
    }

    /// Checks that `thing` was made from this device; `user` names the object or method that will
    /// use it.
    ///
    /// # Errors
    /// [`Error::Foreign`] if it was made from another device.
    pub fn check<T: OfDevice>(&self, thing: &T, user: &'static str) -> Result<(), Error> {
        ownership::check(thing.device_id(), self.id(), T::KIND, user, "Device")
    }

    /// Returns the newest tick that is over. Never waits.
    ///
    /// # Errors
    /// A failed call, for example on a lost device.
    pub fn completed(&self) -> Result<Tick, Error> {
        let clock = &self.shared.clock;
        let ClockSource::Timeline(timeline) = &clock.source else { return Ok(clock.over()) };
        // SAFETY: the device's own timeline.
        let completed = unsafe { self.raw().get_semaphore_counter_value(timeline.semaphore) }
            .called("vkGetSemaphoreCounterValue")
            .inspect_err(|error| self.note_loss(error))?;
        clock.completed(Tick(completed));
        Ok(Tick(completed))
    }

    /// Notes an error of a call that can report the loss of the device.
    pub(crate) fn note_loss(&self, error: &Error) {
        if error.is_device_lost() {
            self.shared.is_lost.store(true, Ordering::Release);
        }
    }

    /// Returns true once a submit, a wait or a present has reported the loss of the device.
    pub fn is_known_lost(&self) -> bool {
        self.shared.is_lost.load(Ordering::Acquire)
    }

    /// Returns the newest tick that was over when this was last read.
    pub(crate) fn known_over(&self) -> Tick {
        self.shared.clock.over()
    }

    /// Returns the semaphore that counts the submits of this device. A host can wait for a [`Tick`]
    /// by waiting for its value. The semaphore lives as long as the device.
    ///
    /// # Errors
    /// [`Error::NoQueue`] on a device without a queue.
    pub fn timeline_semaphore(&self) -> Result<vk::Semaphore, Error> {
        Ok(self.shared.clock.timeline("a timeline")?.semaphore)
    }

    /// Returns an error on a device without a queue; `what` names the operation that needs one.
    pub(crate) fn check_queue(&self, what: &'static str) -> Result<(), Error> {
        self.shared.clock.timeline(what).map(|_| ())
    }

    /// Begins the frame `current` of a host. All frames up to `safe` are over on the GPU or will
    /// never be submitted. `current` must increase, and `safe` must not decrease.
    pub(crate) fn host_frame(&self, current: Tick, safe: Tick) -> Result<(), Error> {
        self.shared.clock.begin_host_frame(current, safe)?;
        self.executions().settle(safe);
        Ok(())
    }

    /// Notes that all frames of the host are over, and frees the objects that were kept for them.
    /// Call this before the last handle of an adopted device without a queue is dropped; otherwise
    /// objects that a frame may still use are leaked.
    ///
    /// # Safety
    /// Every frame that was begun is over on the GPU or will never be submitted.
    ///
    /// # Errors
    /// [`Error::HasQueue`] on a device with a queue, which tracks this without help.
    pub unsafe fn host_finished(&self) -> Result<(), Error> {
        self.shared.clock.finish_host_frames()?;
        self.executions().settle(self.submitted());
        self.free_retired()
    }

    /// Limits `completed` to the newest tick that this device is known to have completed, because
    /// `completed` may come from another device.
    pub(crate) fn proven(&self, completed: Tick) -> Tick {
        completed.min(self.shared.clock.over())
    }

    /// Returns a tick of this device at or after the end of the frame that was just submitted as
    /// `tick`. `tick` may come from another device.
    pub(crate) fn not_before(&self, tick: Tick) -> Tick {
        tick.max(self.submitted())
    }

    /// Returns the tick of the newest submit, or of the newest frame that a host began.
    pub fn submitted(&self) -> Tick {
        self.shared.clock.newest()
    }

    /// Waits until all submitted work is over. For loading and shutting down, not for a frame loop:
    /// the wait counts as [`WaitCounts::other`].
    ///
    /// # Errors
    /// [`Error::Timeout`], a failed call.
    pub fn wait_idle(&self) -> Result<(), Error> {
        self.wait(self.submitted(), WaitFor::Drain)?;
        self.free_retired()
    }

    /// Returns the numbers of times that the CPU waited.
    pub fn wait_counts(&self) -> WaitCounts {
        WaitCounts {
            slot: self.shared.slot_waits.load(Ordering::Relaxed),
            other: self.shared.other_waits.load(Ordering::Relaxed),
        }
    }

    /// Returns the memory taken from the driver and the memory in use.
    pub fn memory_use(&self) -> MemoryUse {
        let memory = self.memory();
        memory.as_ref().map(DeviceMemory::in_use).unwrap_or_default()
    }

    /// Returns the number of dropped objects that commands being recorded, or the GPU, may still
    /// use.
    pub fn retired(&self) -> usize {
        lock(&self.shared.deletion).len()
    }

    /// Waits for the GPU. Only this function and [`Device::wait_within`] do so; each wait is
    /// bounded and counted.
    pub(crate) fn wait(&self, tick: Tick, reason: WaitFor) -> Result<(), Error> {
        let (counter, what) = match reason {
            WaitFor::Slot => (&self.shared.slot_waits, "a frame"),
            WaitFor::Answer => (&self.shared.other_waits, "what a frame was asked"),
            WaitFor::Transfer => (&self.shared.other_waits, "a transfer"),
            WaitFor::Drain => (&self.shared.other_waits, "the work in flight"),
        };
        let timeline = self.shared.clock.timeline("waiting for the GPU")?.semaphore;
        counter.fetch_add(1, Ordering::Relaxed);
        let bound = self.shared.wait_bound;
        let began = Instant::now();
        match wait_bounded(self.raw(), timeline, tick, bound) {
            Err(vk::Result::TIMEOUT) => {
                // A driver may say so before the bound.
                let waited = began.elapsed();
                self.shared.hangs.fetch_or(waited >= bound, Ordering::Relaxed);
                let seconds = waited.as_secs_f64();
                Err(Error::Timeout { what, call: "vkWaitSemaphores", seconds })
            }
            Ok(()) => {
                self.shared.hangs.store(false, Ordering::Relaxed);
                Ok(())
            }
            other => other.called("vkWaitSemaphores").inspect_err(|error| self.note_loss(error)),
        }
    }

    /// Waits for the tick of a slot for at most `bound`, and returns true if it is over.
    pub(crate) fn wait_within(&self, tick: Tick, bound: Duration) -> Result<bool, Error> {
        if self.completed()? >= tick {
            return Ok(true);
        }
        let timeline = self.shared.clock.timeline("waiting for the GPU")?.semaphore;
        self.shared.slot_waits.fetch_add(1, Ordering::Relaxed);
        match wait_bounded(self.raw(), timeline, tick, bound) {
            Err(vk::Result::TIMEOUT) => Ok(false),
            other => {
                let waited = other.called("vkWaitSemaphores").map(|()| true);
                waited.inspect_err(|error| self.note_loss(error))
            }
        }
    }

    /// Submits a command buffer, or only the `order`, and signals the returned tick.
    pub(crate) fn submit(
        &self,
        commands: Option<vk::CommandBuffer>,
        order: &Order<'_>,
    ) -> Result<Tick, Error> {
        order.after.map_or(Ok(()), |after| self.check(after.timeline, "a submit"))?;
        let semaphore = self.shared.clock.timeline("a submit")?.semaphore;
        self.with_queue("a submit", |queue| {
            let tick = self.submitted().next();
            // SAFETY: the lock gives exclusive use of the queue; the commands are complete.
            unsafe { order.submit(self.raw(), queue, commands, semaphore, tick) }
                .inspect_err(|error| self.note_loss(error))?;
            self.shared.clock.submitted(tick);
            Ok(tick)
        })?
    }

    /// Calls `user` with exclusive use of the queue; `what` names the user.
    ///
    /// # Errors
    /// [`Error::NoQueue`] on a device without a queue; [`Error::Timeout`] if other users hold the
    /// queue for longer than the bound of every wait.
    pub(crate) fn with_queue<R>(
        &self,
        what: &'static str,
        user: impl FnOnce(vk::Queue) -> R,
    ) -> Result<R, Error> {
        let bound = self.shared.wait_bound;
        let timeline = self.shared.clock.timeline(what)?;
        timeline.queue.locked(bound, user).ok_or(Error::Timeout {
            what: "the frame before, which a hidden window or another user holds back",
            call: "waiting for the queue",
            seconds: bound.as_secs_f64(),
        })
    }

    /// Takes the payload of a dropped object. Commands being recorded may still use it, so it is
    /// freed when all of them are over or abandoned.
    pub(crate) fn retire(&self, retired: Retired) {
        let mut deletion = lock(&self.shared.deletion);
        deletion.retire(self.submitted(), retired);
    }

    /// Takes the payload of an object that a present uses. No tick so far proves that the present
    /// is over, so it is freed when the next submit is over.
    pub(crate) fn retire_behind_next_submit(&self, retired: Retired) {
        let mut deletion = lock(&self.shared.deletion);
        deletion.retire(self.submitted().next(), retired);
    }

    /// Begins a recording. Objects that are dropped before the guard is dropped stay alive for it.
    pub(crate) fn open_recording(&self) -> OpenRecording {
        OpenRecording { device: self.clone(), number: lock(&self.shared.deletion).open() }
    }

    /// Frees retired objects that are no longer in use.
    pub(crate) fn free_retired(&self) -> Result<(), Error> {
        self.free_over(self.completed()?);
        Ok(())
    }

    /// Frees the retired objects of a lost device. Its work is over once a wait reports the loss
    /// (Vulkan specification, "Lost Device"), but no frame frees anything any more. Does nothing
    /// while the device works.
    pub(crate) fn free_retired_of_lost(&self) {
        let newest = self.submitted();
        let is_over = |waited: Result<(), Error>| {
            waited.map_or_else(|error| error.is_device_lost(), |()| true)
        };
        if self.is_known_lost() && is_over(self.wait(newest, WaitFor::Drain)) {
            self.free_over(Tick(u64::MAX));
        }
    }

    fn free_over(&self, completed: Tick) {
        loop {
            // Nothing is locked meanwhile: a swapchain waits for its presents, and the end of a
            // window of the host may retire other objects.
            let popped = lock(&self.shared.deletion).pop_over(completed);
            let Some(retired) = popped else { break };
            self.shared.destroy(retired);
        }
    }

    /// Returns true if the device submits work, and false if it was adopted without a queue.
    /// Without a queue it records into command buffers of the host
    /// ([`FrameRing::begin_in`](crate::FrameRing::begin_in)).
    pub fn has_queue(&self) -> bool {
        matches!(self.shared.clock.source, ClockSource::Timeline(_))
    }

    pub(crate) fn executions(&self) -> MutexGuard<'_, Executions> {
        lock(&self.shared.executions)
    }

    pub(crate) fn pending_uploads(&self) -> MutexGuard<'_, PendingUploads> {
        lock(&self.shared.pending_uploads)
    }

    pub(crate) fn number_buffer(&self) -> MutexGuard<'_, Option<NumberBuffer>> {
        lock(&self.shared.numbers)
    }

    /// Returns the functions of the device, for a host that records commands or creates objects.
    /// The device still belongs to the engine: do not destroy it, and do not submit to its queue.
    pub fn raw(&self) -> &ash::Device {
        &self.shared.raw
    }

    /// Returns true if images of `format` with optimal tiling support all of `features`.
    pub(crate) fn has_format_feature(
        &self,
        format: vk::Format,
        features: vk::FormatFeatureFlags,
    ) -> bool {
        let raw = &self.shared.instance.raw;
        let physical = self.shared.adapter.physical;
        // SAFETY: the device's own adapter, and a format of the core.
        let has = unsafe { raw.get_physical_device_format_properties(physical, format) };
        has.optimal_tiling_features.contains(features)
    }

    /// Returns the unique id of this device.
    pub(crate) fn id(&self) -> OwnerId {
        self.shared.id
    }

    pub(crate) fn instance(&self) -> &InstanceShared {
        &self.shared.instance
    }

    pub(crate) fn queue_family(&self) -> u32 {
        self.shared.queue_family
    }

    /// Returns the functions of the enabled extensions.
    pub(crate) fn extensions(&self) -> &Extensions {
        &self.shared.extensions
    }

    pub(crate) fn debug(&self) -> Option<&ext::debug_utils::Device> {
        self.shared.extensions.debug.as_ref()
    }

    pub(crate) fn conditional(&self) -> Option<&ext::conditional_rendering::Device> {
        self.shared.extensions.conditional.as_ref()
    }

    pub(crate) fn capture(&self) -> Option<&ext::transform_feedback::Device> {
        self.shared.extensions.capture.as_ref()
    }

    /// Returns the allocation callbacks for all objects made from the device.
    pub(crate) fn callbacks(&self) -> Option<&vk::AllocationCallbacks<'static>> {
        self.shared.callbacks.get()
    }

    pub(crate) fn pipeline_cache(&self) -> vk::PipelineCache {
        self.shared.pipeline_cache.raw
    }

    pub(crate) fn memory(&self) -> MutexGuard<'_, Option<DeviceMemory>> {
        lock(&self.shared.memory)
    }

    /// Gives a Vulkan object its debug name if a debugger or layer is active.
    pub(crate) fn name<H: vk::Handle>(&self, handle: H, name: &str) {
        if let Some(debug) = self.debug() {
            set_debug_name(debug, handle, name);
        }
    }
}

/// The guard of commands that are being recorded. It must be dropped after their last submit, or
/// when they are abandoned.
pub(crate) struct OpenRecording {
    device: Device,
    pub(crate) number: RecordingId,
}

impl Drop for OpenRecording {
    fn drop(&mut self) {
        let mut deletion = lock(&self.device.shared.deletion);
        deletion.close(self.number, self.device.submitted());
    }
}
