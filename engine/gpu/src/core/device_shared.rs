//! The state that clones of a device share, from opening to closing.

use std::any::Any;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use ash::vk;

use crate::core::adapter::Adapter;
use crate::core::clock::{Clock, ClockSource};
use crate::core::deletion::{DeletionQueue, Retired};
use crate::core::executions::Executions;
use crate::core::extensions::Extensions;
use crate::core::host_callbacks::HostCallbacks;
use crate::core::instance::InstanceShared;
use crate::core::number_buffer::NumberBuffer;
use crate::core::ownership::{OwnerId, Ownership};
use crate::core::pending_uploads::PendingUploads;
use crate::core::pipeline_cache::PipelineCache;
use crate::core::queue_lock::lock;
use crate::core::tick::Tick;
use crate::memory::device_memory::DeviceMemory;

/// The Vulkan device and all objects with the same lifetime.
pub(crate) struct DeviceShared {
    pub(super) id: OwnerId,
    pub(super) instance: Arc<InstanceShared>,
    pub(super) raw: ash::Device,
    pub(super) ownership: Ownership,
    pub(super) callbacks: HostCallbacks,
    pub(super) extensions: Extensions,
    pub(super) adapter: Adapter,
    pub(super) queue_family: u32,
    // None only while dropping.
    pub(super) memory: Mutex<Option<DeviceMemory>>,
    pub(super) deletion: Mutex<DeletionQueue<Retired>>,
    pub(super) clock: Clock,
    /// The frames of a host, with the knowledge of which ran.
    pub(super) executions: Mutex<Executions>,
    /// Uploads that wait for a frame of a host.
    pub(super) pending_uploads: Mutex<PendingUploads>,
    /// The buffer of instance numbers, once a pipeline has read them.
    pub(super) numbers: Mutex<Option<NumberBuffer>>,
    pub(super) wait_bound: Duration,
    /// True once a call has reported the loss of the device.
    pub(super) is_lost: AtomicBool,
    /// True after work that did not end within `wait_bound`, until a wait ends in time.
    pub(super) hangs: AtomicBool,
    pub(super) slot_waits: AtomicU64,
    pub(super) other_waits: AtomicU64,
    pub(super) pipeline_cache: PipelineCache,
    /// An owner of the handles of a host, dropped after their last use.
    pub(super) owner: Option<Arc<dyn Any + Send + Sync>>,
}

/// The bound of the wait for a GPU that has hung before, when its device is closed.
const HUNG_BOUND: Duration = Duration::from_secs(1);

impl DeviceShared {
    /// Leaks everything, because destroying objects that the GPU still uses would be worse.
    /// Otherwise the memory would free its memory on drop, the surfaces of retired swapchains and
    /// the instance would be destroyed before them, and the owner of a host's handles would end.
    fn abandon(&self) {
        std::mem::forget(std::mem::replace(&mut *lock(&self.deletion), DeletionQueue::new()));
        std::mem::forget(lock(&self.memory).take());
        std::mem::forget(Arc::clone(&self.instance));
        std::mem::forget(self.owner.clone());
    }

    /// Destroys the payload of a dropped object that nothing uses any more.
    pub(super) fn destroy(&self, retired: Retired) {
        let free = |allocation| {
            if let Some(memory) = lock(&self.memory).as_mut() {
                memory.free(allocation);
            }
        };
        let callbacks = self.callbacks.get();
        // SAFETY: the deletion queue hands a payload out once, after the last submit that could
        // use it is over; it was made from this device.
        unsafe {
            match retired {
                Retired::Buffer(buffer, allocation) => {
                    self.raw.destroy_buffer(buffer, callbacks);
                    free(allocation);
                }
                Retired::Image(image, view, allocation) => {
                    self.raw.destroy_image_view(view, callbacks);
                    self.raw.destroy_image(image, callbacks);
                    free(allocation);
                }
                Retired::ImageView(view) => self.raw.destroy_image_view(view, callbacks),
                Retired::Pipeline(pipeline) => self.raw.destroy_pipeline(pipeline, callbacks),
                Retired::PipelineLayout(layout) => {
                    self.raw.destroy_pipeline_layout(layout, callbacks)
                }
                Retired::SetLayout(layout) => {
                    self.raw.destroy_descriptor_set_layout(layout, callbacks)
                }
                Retired::DescriptorPool(pool) => self.raw.destroy_descriptor_pool(pool, callbacks),
                Retired::CommandPool(pool) => self.raw.destroy_command_pool(pool, callbacks),
                Retired::QueryPool(pool) => self.raw.destroy_query_pool(pool, callbacks),
                Retired::Sampler(sampler) => self.raw.destroy_sampler(sampler, callbacks),
                Retired::Semaphore(semaphore) => self.raw.destroy_semaphore(semaphore, callbacks),
                Retired::Other(retired) => retired.destroy(&self.raw),
            }
        }
    }

    /// Waits until the GPU no longer uses objects of the device; returns false if it may still use
    /// them.
    #[expect(clippy::disallowed_methods, reason = "the device ends here")]
    fn finish(&self) -> bool {
        let newest = self.clock.newest();
        let ClockSource::Timeline(timeline) = &self.clock.source else {
            let is_over = self.clock.over() >= newest;
            if !is_over {
                tracing::error!(
                    "frame {} of the host may still be in use, so what was made for it is left as \
                     it is; call `Device::host_finished` when the GPU is idle, before the device \
                     is dropped",
                    newest.0
                );
            }
            return is_over;
        };
        // vkDeviceWaitIdle has no bound, so the timeline is waited for first.
        let began = Instant::now();
        let hangs = self.hangs.load(Ordering::Relaxed);
        let bound = if hangs { HUNG_BOUND.min(self.wait_bound) } else { self.wait_bound };
        match wait_bounded(&self.raw, timeline.semaphore, newest, bound) {
            Ok(()) => {}
            // All work of a lost device is over (Vulkan specification, "Lost Device").
            Err(vk::Result::ERROR_DEVICE_LOST) => tracing::error!("the device was lost"),
            Err(code) if !self.is_reached(timeline.semaphore, newest, began, bound) => {
                tracing::error!(
                    "the GPU did not finish (vkWaitSemaphores: {code:?}); the device is left as it \
                     is"
                );
                return false;
            }
            Err(_) => {}
        }
        // The engine does not wait for other queues of a host.
        if self.ownership == Ownership::Ours {
            // SAFETY: no other handle of the device exists.
            let wait = || unsafe { self.raw.device_wait_idle() };
            // A failure may pass, and no other call proves that presents are over.
            if let Err(code) = wait().or_else(|_| wait()) {
                tracing::error!("vkDeviceWaitIdle failed with {code:?} while closing the device");
            }
        }
        true
    }

    /// Returns true if the timeline reaches a tick within a bound of the beginning. Asks again and
    /// again: the call that waits has failed, or its time is over.
    fn is_reached(
        &self,
        timeline: vk::Semaphore,
        tick: Tick,
        began: Instant,
        bound: Duration,
    ) -> bool {
        loop {
            // SAFETY: the device's own timeline.
            match unsafe { self.raw.get_semaphore_counter_value(timeline) } {
                Ok(reached) if reached >= tick.0 => return true,
                Err(vk::Result::ERROR_DEVICE_LOST) => return true,
                _ if began.elapsed() >= bound => return false,
                _ => std::thread::sleep(Duration::from_millis(1)),
            }
        }
    }
}

impl Drop for DeviceShared {
    fn drop(&mut self) {
        if !self.finish() {
            self.abandon();
            return;
        }
        loop {
            // No recording is open, because each holds the device.
            let popped = lock(&self.deletion).pop_over(Tick(u64::MAX));
            let Some(retired) = popped else { break };
            self.destroy(retired);
        }
        lock(&self.pending_uploads).drain().for_each(|retired| self.destroy(retired));
        if let Some(numbers) = lock(&self.numbers).take() {
            self.destroy(numbers.into());
        }
        self.pipeline_cache.save(&self.raw);
        self.pipeline_cache.destroy(&self.raw, &self.callbacks);
        if let Some(memory) = lock(&self.memory).take() {
            // The allocator frees leaked blocks on drop, so no layer would report a leak.
            let leaked = memory.parts_in_use();
            for allocation in &leaked {
                tracing::error!(
                    "leaked GPU memory: {} ({} bytes)",
                    allocation.name,
                    allocation.size
                );
            }
            debug_assert!(leaked.is_empty(), "GPU memory leaked, see the log");
        }
        // SAFETY: all objects made from the device are destroyed.
        unsafe {
            if let ClockSource::Timeline(timeline) = &self.clock.source {
                self.raw.destroy_semaphore(timeline.semaphore, self.callbacks.get());
            }
            if self.ownership == Ownership::Ours {
                self.raw.destroy_device(None);
            }
        }
        tracing::debug!(
            "device closed; instance users left: {}",
            Arc::strong_count(&self.instance)
        );
    }
}

/// Waits for a tick of a timeline for at most `bound`.
pub(super) fn wait_bounded(
    device: &ash::Device,
    timeline: vk::Semaphore,
    tick: Tick,
    bound: Duration,
) -> Result<(), vk::Result> {
    let semaphores = [timeline];
    let values = [tick.0];
    let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&values);
    let bound_ns = u64::try_from(bound.as_nanos()).unwrap_or(u64::MAX / 2);
    // SAFETY: the device's own timeline.
    unsafe { device.wait_semaphores(&info, bound_ns) }
}
