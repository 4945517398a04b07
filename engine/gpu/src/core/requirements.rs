//! The requirements that a host merges into its creation of the device that the engine will use.

use std::ffi::CStr;

use ash::vk;

use crate::core::capabilities::{Capabilities, OptionalFeature, Purpose, RequiredFeature};
use crate::core::error::Error;
use crate::core::features::Features;
use crate::core::offer::{Offer, QUEUE_FLAGS};

/// The needs of the engine on one physical device: what to turn on when a device is made of it.
///
/// A host merges them into its own creation of the device, and hands the device to
/// [`Device::adopt`](crate::Device::adopt). The engine's own devices are made from the same value.
///
/// ```no_run
/// # use antumbra_gpu as gpu;
/// # use gpu::vk;
/// # fn make(
/// #     instance: &ash::Instance, physical: vk::PhysicalDevice,
/// # ) -> Result<ash::Device, Box<dyn std::error::Error>> {
/// // SAFETY: the physical device is of this instance, which was made for Vulkan 1.3.
/// let needs =
///     unsafe { gpu::Requirements::of(instance, physical, gpu::Purpose::Executor) };
/// needs.check()?;
/// let queues = [vk::DeviceQueueCreateInfo::default()
///     .queue_family_index(needs.queue_family.unwrap_or_default())
///     .queue_priorities(&[1.0])];
/// let (names, mut features) = (needs.extensions(), needs.features().structures());
/// let extensions: Vec<_> = names.iter().map(|name| name.as_ptr()).collect();
/// // A host adds its own features here, to the fields of `features` or to the chain.
/// let mut chain = features.link(&names);
/// let info = vk::DeviceCreateInfo::default()
///     .queue_create_infos(&queues)
///     .enabled_extension_names(&extensions)
///     .push_next(&mut chain);
/// // SAFETY: the device has all that is asked for.
/// let device = unsafe { instance.create_device(physical, &info, None) }?;
/// # Ok(device)
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Requirements {
    /// The part of the engine that they are for.
    pub purpose: Purpose,
    /// The least version of Vulkan that the instance must be made for, and the device speak.
    pub api_version: u32,
    /// The flags of the queue family whose command buffers the engine records into.
    pub queue_flags: vk::QueueFlags,
    /// The first queue family with these flags.
    pub queue_family: Option<u32>,
    /// The extensions without which there is no engine. Today there are none: all of them became
    /// part of Vulkan 1.3.
    pub required_extensions: Vec<&'static CStr>,
    /// The extensions that this device has and the engine can use.
    pub optional_extensions: Vec<&'static CStr>,
    /// The features without which there is no engine, whether the device has them or not.
    pub required_features: Features,
    /// The features that this device has and the engine can use.
    pub optional_features: Features,
    device: String,
    missing: Vec<RequiredFeature>,
}

impl Requirements {
    /// Reads the needs of a part of the engine on a physical device.
    ///
    /// # Safety
    /// `physical` comes from `instance`, which lives.
    pub unsafe fn of(
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        purpose: Purpose,
    ) -> Self {
        // SAFETY: the caller's promise.
        let offer = unsafe { Offer::read(instance, physical, None) };
        let capabilities = Capabilities::of(&offer);
        // SAFETY: as above.
        let properties = unsafe { instance.get_physical_device_properties(physical) };
        let name = properties.device_name_as_c_str().unwrap_or_default().to_string_lossy();
        Self::new(&name, &offer, &capabilities, purpose)
    }

    /// Returns what a device with `capabilities` turns on, out of what the adapter offers.
    pub(crate) fn new(
        device: &str,
        offer: &Offer,
        capabilities: &Capabilities,
        purpose: Purpose,
    ) -> Self {
        let required = RequiredFeature::ALL.into_iter().filter(|what| what.is_for(purpose));
        let optional = capabilities.optional.iter().copied().filter(|what| what.is_for(purpose));
        let join = |all: Features, more: Features| all.union(more);
        let mut optional_extensions = Vec::new();
        for names in optional.clone().flat_map(OptionalFeature::extensions) {
            let name = names.iter().copied().find(|name| offer.has(name));
            optional_extensions.extend(name.filter(|name| !optional_extensions.contains(name)));
        }
        let missing = capabilities.missing.iter().copied().filter(|what| what.is_for(purpose));
        Self {
            purpose,
            api_version: vk::API_VERSION_1_3,
            queue_flags: QUEUE_FLAGS,
            queue_family: offer.queue_family,
            required_extensions: Vec::new(),
            optional_extensions,
            required_features: required
                .map(RequiredFeature::features)
                .fold(Features::default(), join),
            optional_features: optional
                .map(OptionalFeature::features)
                .fold(Features::default(), join),
            device: device.to_owned(),
            missing: missing.collect(),
        }
    }

    /// Returns the names of all extensions to turn on: the required and the optional ones.
    pub fn extensions(&self) -> Vec<&'static CStr> {
        [&self.required_extensions[..], &self.optional_extensions].concat()
    }

    /// Returns all features to turn on: the required and the optional ones.
    pub fn features(&self) -> Features {
        self.required_features.union(self.optional_features)
    }

    /// Returns the required capabilities that the device lacks.
    pub fn missing(&self) -> &[RequiredFeature] {
        &self.missing
    }

    /// Refuses a device that lacks something required.
    ///
    /// # Errors
    /// [`Error::DeviceLacks`], with the names.
    pub fn check(&self) -> Result<(), Error> {
        if self.missing.is_empty() {
            return Ok(());
        }
        let names: Vec<_> = self.missing.iter().map(|missing| missing.name()).collect();
        let device = self.device.clone();
        let missing = names.join(", ");
        Err(Error::DeviceLacks { device, missing, available: String::new() })
    }
}
