//! Opening a device: the features and extensions asked for, and the objects that every device
//! needs.

use std::path::PathBuf;
use std::time::Duration;

use ash::{ext, google, khr, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use crate::core::adapter::Adapter;
use crate::core::capabilities::{Capabilities, Optional, extension_names, fences_extension};
use crate::core::error::{Called, Error};
use crate::core::instance::InstanceShared;
use crate::core::pipeline_cache::PipelineCache;
use crate::core::tick::create_semaphore;

/// The options of a [`Device`](crate::Device).
#[derive(Debug, Clone)]
pub struct DeviceOptions {
    /// The file of compiled pipelines between runs; `None` keeps none. A file that belongs to
    /// another device or driver, or is damaged, is ignored and replaced.
    pub pipeline_cache: Option<PathBuf>,
    /// The bound of every wait. A frame that takes longer is an error, not a hang.
    pub wait_bound: Duration,
}

impl Default for DeviceOptions {
    fn default() -> Self {
        // A million objects on a software driver take half a minute per frame.
        Self { pipeline_cache: None, wait_bound: Duration::from_secs(300) }
    }
}

/// The functions of the extensions that are on.
pub(crate) struct Extensions {
    pub(crate) debug: Option<ext::debug_utils::Device>,
    pub(crate) conditional: Option<ext::conditional_rendering::Device>,
    pub(crate) calibrated: Option<ext::calibrated_timestamps::Device>,
    pub(crate) swapchain: Option<khr::swapchain::Device>,
    pub(crate) present_wait: Option<khr::present_wait::Device>,
    pub(crate) display_timing: Option<google::display_timing::Device>,
}

impl Extensions {
    pub(crate) fn load(
        instance: &InstanceShared,
        device: &ash::Device,
        capabilities: &Capabilities,
    ) -> Self {
        let (from, has) = (&instance.raw, |optional| capabilities.has(optional));
        Self {
            debug: instance.has_debug_utils.then(|| ext::debug_utils::Device::new(from, device)),
            conditional: has(Optional::ConditionalRendering)
                .then(|| ext::conditional_rendering::Device::new(from, device)),
            calibrated: has(Optional::CalibratedTimestamps)
                .then(|| ext::calibrated_timestamps::Device::new(from, device)),
            swapchain: has(Optional::Swapchain).then(|| khr::swapchain::Device::new(from, device)),
            present_wait: has(Optional::PresentWait)
                .then(|| khr::present_wait::Device::new(from, device)),
            display_timing: has(Optional::DisplayTiming)
                .then(|| google::display_timing::Device::new(from, device)),
        }
    }
}

/// Creates the timeline, the allocator and the pipeline cache, without which there is no device. A
/// failure leaves nothing behind.
pub(crate) fn equip(
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

pub(crate) fn create_raw(
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
        .fragment_stores_and_atomics(has(Optional::FragmentStores))
        .fill_mode_non_solid(has(Optional::Wireframe))
        .sampler_anisotropy(has(Optional::Anisotropy));
    let mut features = vk::PhysicalDeviceFeatures2::default()
        .features(core)
        .push_next(&mut features_12)
        .push_next(&mut features_13);
    let mut extensions = Vec::new();
    if has(Optional::ConditionalRendering) {
        extensions.push(ext::conditional_rendering::NAME.as_ptr());
        features = features.push_next(&mut conditional);
    }
    let mut present_fences =
        vk::PhysicalDeviceSwapchainMaintenance1FeaturesEXT::default().swapchain_maintenance1(true);
    let mut present_id = vk::PhysicalDevicePresentIdFeaturesKHR::default().present_id(true);
    let mut present_wait = vk::PhysicalDevicePresentWaitFeaturesKHR::default().present_wait(true);
    if has(Optional::CalibratedTimestamps) {
        extensions.push(ext::calibrated_timestamps::NAME.as_ptr());
    }
    if has(Optional::Swapchain) {
        extensions.push(khr::swapchain::NAME.as_ptr());
    }
    if has(Optional::PresentFences)
        && let Some(name) = fences_extension(instance, &extension_names(instance, adapter.physical))
    {
        extensions.push(name.as_ptr());
        features = features.push_next(&mut present_fences);
    }
    if has(Optional::PresentWait) {
        extensions.extend([khr::present_id::NAME.as_ptr(), khr::present_wait::NAME.as_ptr()]);
        features = features.push_next(&mut present_id).push_next(&mut present_wait);
    }
    if has(Optional::DisplayTiming) {
        extensions.push(google::display_timing::NAME.as_ptr());
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
