//! The device of wgpu, made by it with what the engine needs beside.

use std::error::Error;

use ash::{ext, vk};
use gpu::{Features, Purpose, Requirements};
use walk::HostInstance;
use wgpu::hal::api::Vulkan;
use wgpu::hal::vulkan;

/// The device of wgpu, and what it was made from.
pub struct WgpuDevice {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// The same device.
    pub raw: ash::Device,
    pub physical: vk::PhysicalDevice,
    pub queue_family: u32,
    pub needs: Requirements,
    /// The features of the engine that are on.
    pub features: Features,
}

impl WgpuDevice {
    /// Creates the device: wgpu hands its description to a closure, which adds what the engine
    /// needs beside.
    pub fn new(host: &HostInstance, physical: vk::PhysicalDevice) -> Result<Self, Box<dyn Error>> {
        // SAFETY: made from one another.
        let needs = unsafe { Requirements::of(&host.raw, physical, Purpose::Executor) }?;
        needs.check()?;
        let adapter = adapter(host, physical)?;
        let counts = wgpu::Features::MULTI_DRAW_INDIRECT_COUNT & adapter.features();
        let described = wgpu::DeviceDescriptor {
            required_features: wgpu::Features::INDIRECT_FIRST_INSTANCE
                | wgpu::Features::IMMEDIATES
                | counts,
            required_limits: wgpu::Limits { max_immediate_size: 128, ..Default::default() },
            ..Default::default()
        };
        // wgpu never turns on precise queries, and draw counts if asked for alone.
        let lacking = Features {
            occlusion_query_precise: true,
            draw_indirect_count: counts.is_empty(),
            ..Default::default()
        };
        let features = needs.features().without(lacking);
        let mut rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default()
            .dynamic_rendering(features.dynamic_rendering);
        let mut synchronization = vk::PhysicalDeviceSynchronization2Features::default()
            .synchronization2(features.synchronization2);
        let mut conditional = vk::PhysicalDeviceConditionalRenderingFeaturesEXT::default()
            .conditional_rendering(features.conditional_rendering);
        let added = needs.extensions();
        // SAFETY: an adapter of Vulkan, which has all that is added.
        let opened = unsafe {
            let raw = adapter.as_hal::<Vulkan>().ok_or("the adapter is not Vulkan's")?;
            raw.open_with_callback(
                described.required_features,
                &described.required_limits,
                &described.memory_hints,
                Some(Box::new(|args| {
                    let has_conditions = added.contains(&ext::conditional_rendering::NAME);
                    let new = added.iter().filter(|name| !args.extensions.contains(name));
                    let new: Vec<_> = new.copied().collect();
                    args.extensions.extend(new);
                    let info = std::mem::take(args.create_info)
                        .push_next(&mut rendering)
                        .push_next(&mut synchronization);
                    *args.create_info =
                        if has_conditions { info.push_next(&mut conditional) } else { info };
                })),
            )
        }?;
        let raw = opened.device.raw_device().clone();
        let queue_family = opened.device.queue_family_index();
        // SAFETY: opened by this adapter, with these features.
        let (device, queue) = unsafe { adapter.create_device_from_hal(opened, &described) }?;
        Ok(Self { device, queue, raw, physical, queue_family, needs, features })
    }
}

/// Returns wgpu's adapter of a physical device of an instance that is the host's own.
fn adapter(
    host: &HostInstance,
    physical: vk::PhysicalDevice,
) -> Result<wgpu::Adapter, Box<dyn Error>> {
    // Without `VALIDATION_INDIRECT_CALL`: wgpu would copy and check every indirect draw.
    let flags = wgpu::InstanceFlags::empty();
    // SAFETY: made for Vulkan 1.3 from this entry; the host destroys it behind all of wgpu.
    unsafe {
        let instance = vulkan::Instance::from_raw(
            host.entry.clone(),
            host.raw.clone(),
            vk::API_VERSION_1_3,
            0,
            None,
            host.extensions().into_iter().collect(),
            flags,
            wgpu::MemoryBudgetThresholds::default(),
            false,
            Some(Box::new(|| {})),
        )?;
        let adapter = instance.expose_adapter(physical).ok_or("wgpu refuses the device")?;
        Ok(wgpu::Instance::from_hal::<Vulkan>(instance).create_adapter_from_hal(adapter))
    }
}
