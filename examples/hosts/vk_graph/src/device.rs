//! The device of vk-graph, made by it with what the engine needs beside.

use std::error::Error;
use std::ffi::CStr;

use ash::{ext, vk};
use gpu::{Purpose, Requirements};
use vk_graph::driver::device::Device;
use vk_graph::driver::instance::Instance;
use vk_graph::driver::physical_device::PhysicalDevice;
use walk::HostInstance;

/// The device of vk-graph, and what it was made from.
pub struct GraphDevice {
    pub raw: Device,
    pub physical: vk::PhysicalDevice,
    pub queue_family: u32,
    pub needs: Requirements,
}

impl GraphDevice {
    /// Creates the device: vk-graph turns on all that it knows, and hands its description to a
    /// closure, which adds what the engine needs beside.
    pub fn new(host: &HostInstance, physical: vk::PhysicalDevice) -> Result<Self, Box<dyn Error>> {
        // SAFETY: made from one another.
        let needs = unsafe { Requirements::of(&host.raw, physical, Purpose::Executor) }?;
        needs.check()?;
        let queue_family = needs.queue_family.ok_or("no queue family for graphics")?;
        let instance = Instance::try_from_entry(host.entry.clone(), host.raw.handle())?;
        // SAFETY: a physical device of this instance.
        let described = unsafe { PhysicalDevice::try_from_ash(&instance, physical) }?;
        let wanted = needs.features();
        let mut rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default()
            .dynamic_rendering(wanted.dynamic_rendering);
        let mut conditional = vk::PhysicalDeviceConditionalRenderingFeaturesEXT::default()
            .conditional_rendering(wanted.conditional_rendering);
        // SAFETY: the device has all that is added, and the closure creates it of this description.
        let raw = unsafe {
            described.create_ash_device(|info| {
                let own = std::slice::from_raw_parts(
                    info.pp_enabled_extension_names,
                    info.enabled_extension_count as usize,
                );
                let added = needs.extensions();
                let is_new = |name: &&&CStr| own.iter().all(|own| CStr::from_ptr(*own) != **name);
                let added: Vec<_> = added.iter().filter(is_new).map(|name| name.as_ptr()).collect();
                let names = [own, &added[..]].concat();
                let mut info = info.enabled_extension_names(&names).push_next(&mut rendering);
                if needs.extensions().contains(&ext::conditional_rendering::NAME) {
                    info = info.push_next(&mut conditional);
                }
                instance.create_device(physical, &info, None)
            })
        }?;
        // SAFETY: just made of this physical device, with all that vk-graph wants.
        let raw = unsafe { Device::try_from_ash(raw, described) }?;
        Ok(Self { raw, physical, queue_family, needs })
    }
}
