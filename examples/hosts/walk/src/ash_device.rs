//! An instance and a device of a host in plain Vulkan.

use std::error::Error;
use std::ffi::CString;

use ash::vk;
use gpu::{Purpose, Requirements};

use crate::instance::HostInstance;

/// The instance, the device, and its one queue.
pub struct AshDevice {
    /// The instance.
    pub instance: HostInstance,
    /// The physical device.
    pub physical: vk::PhysicalDevice,
    /// The device.
    pub raw: ash::Device,
    /// The queue.
    pub queue: vk::Queue,
    /// The family of the queue.
    pub queue_family: u32,
    /// The requirements that the device was made from.
    pub needs: Requirements,
}

impl AshDevice {
    /// Creates a device of the first driver whose device's name contains `wanted`, with all that
    /// the engine can use for this purpose.
    ///
    /// # Errors
    /// No such device, no queue family for graphics, a failed call.
    pub fn new(wanted: &str, purpose: Purpose) -> Result<Self, Box<dyn Error>> {
        let instance = HostInstance::new(&[])?;
        let physical = instance.find(wanted)?;
        // SAFETY: made from one another.
        let needs = unsafe { Requirements::of(&instance.raw, physical, purpose) }?;
        needs.check()?;
        let queue_family = needs.queue_family.ok_or("no queue family for graphics")?;
        let raw = create_device(&instance.raw, physical, queue_family, &needs)?;
        // SAFETY: the family and index were asked for when the device was created.
        let queue = unsafe { raw.get_device_queue(queue_family, 0) };
        Ok(Self { instance, physical, raw, queue, queue_family, needs })
    }

    /// Returns the names of the extensions that are on.
    #[must_use]
    pub fn extensions(&self) -> Vec<CString> {
        let of_device = self.needs.extensions().into_iter();
        of_device.chain(self.instance.extensions()).map(CString::from).collect()
    }

    /// Destroys device and instance, and returns the number of messages of the validation layer.
    #[must_use]
    pub fn destroy(self) -> u64 {
        // SAFETY: everything made from it is gone.
        unsafe { self.raw.destroy_device(None) };
        self.instance.destroy()
    }
}

/// Creates the device with what the engine needs. A host adds features of its own to the chain.
fn create_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    queue_family: u32,
    needs: &Requirements,
) -> Result<ash::Device, Box<dyn Error>> {
    let extensions = needs.extensions();
    let mut features = needs.features().structures();
    let mut chain = features.link(&extensions);
    let names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(queue_family)
        .queue_priorities(&[1.0])];
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&names)
        .push_next(&mut chain);
    // SAFETY: the device has all of it.
    Ok(unsafe { instance.create_device(physical, &info, None) }?)
}
