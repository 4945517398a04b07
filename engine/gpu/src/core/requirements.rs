//! The requirements that a host includes when it creates a device for the engine.

use std::ffi::CStr;

use ash::vk;

use crate::core::capabilities::{Capabilities, OptionalFeature, Purpose, RequiredFeature};
use crate::core::error::Error;
use crate::core::features::Features;
use crate::core::offer::{Offer, QUEUE_FLAGS};

/// The needs of the engine on one physical device: the extensions and features to enable when a
/// device is created.
///
/// A host includes them in its own creation of a device, and passes the device to
/// [`Device::adopt`](crate::Device::adopt). The engine creates its own devices from the same value.
///
/// ```no_run
/// # use antumbra_gpu as gpu;
/// # use gpu::vk;
/// # fn make(
/// #     instance: &ash::Instance, physical: vk::PhysicalDevice,
/// # ) -> Result<ash::Device, Box<dyn std::error::Error>> {
/// // SAFETY: the physical device is of this instance, which was made for Vulkan 1.3.
/// let needs =
///     unsafe { gpu::Requirements::of(instance, physical, gpu::Purpose::Executor) }?;
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
    /// The part of the engine that will use the device.
    pub purpose: Purpose,
    /// The least Vulkan version of the instance and of the device.
    pub api_version: u32,
    /// The flags of the queue family whose command buffers the engine records into.
    pub queue_flags: vk::QueueFlags,
    /// The first queue family with these flags.
    pub queue_family: Option<u32>,
    /// The extensions that the engine cannot work without. Today there are none: all of them became
    /// part of Vulkan 1.3.
    pub required_extensions: Vec<&'static CStr>,
    /// The supported extensions that the engine can use.
    pub optional_extensions: Vec<&'static CStr>,
    /// The features that the engine cannot work without, supported or not.
    pub required_features: Features,
    /// The supported features that the engine can use.
    pub optional_features: Features,
    device: String,
    missing: Vec<RequiredFeature>,
}

impl Requirements {
    /// Reads the needs of a part of the engine on a physical device.
    ///
    /// # Safety
    /// `physical` comes from `instance`, which is alive.
    ///
    /// # Errors
    /// A failed call.
    pub unsafe fn of(
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        purpose: Purpose,
    ) -> Result<Self, Error> {
        // SAFETY: the caller's promise.
        let offer = unsafe { Offer::read(instance, physical, None) }?;
        let capabilities = Capabilities::of(&offer);
        // SAFETY: as above.
        let properties = unsafe { instance.get_physical_device_properties(physical) };
        let name = properties.device_name_as_c_str().unwrap_or_default().to_string_lossy();
        Ok(Self::new(&name, &offer, &capabilities, purpose))
    }

    /// Returns the extensions and features to enable on a device with `capabilities`, out of
    /// `offer`.
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

    /// Returns the names of all extensions to enable: required and optional ones.
    pub fn extensions(&self) -> Vec<&'static CStr> {
        [&self.required_extensions[..], &self.optional_extensions].concat()
    }

    /// Returns all features to enable: required and optional ones.
    pub fn features(&self) -> Features {
        self.required_features.union(self.optional_features)
    }

    /// Returns the required capabilities that the device lacks.
    pub fn missing(&self) -> &[RequiredFeature] {
        &self.missing
    }

    /// Checks that the device has everything that is required.
    ///
    /// # Errors
    /// [`Error::DeviceLacks`] with the names of the missing capabilities.
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
