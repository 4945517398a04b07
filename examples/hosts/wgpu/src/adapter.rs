//! The adapter of wgpu for a device that the user names, under the validation layer of the hosts.
//! Other programs ask `wgpu::Instance` for it.

use std::error::Error;

use ash::vk;
use walk::HostInstance;
use wgpu::hal::{api::Vulkan, vulkan};

/// Returns wgpu's adapter of a physical device of an instance that is the host's own.
pub fn adapter(
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
