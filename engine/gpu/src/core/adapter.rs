//! Physical devices: their names, scores and capabilities.

use ash::vk;

use crate::core::capabilities::{Capabilities, OptionalFeature};
use crate::core::instance::{InstanceShared, version_text};
use crate::core::offer::Offer;
use crate::core::ownership::OwnerId;

/// A physical device and its capabilities.
#[derive(Debug, Clone)]
pub struct Adapter {
    pub(crate) instance: OwnerId,
    pub(crate) physical: vk::PhysicalDevice,
    pub(crate) queue_family: Option<u32>,
    pub(crate) timestamp_bits: u32,
    /// The name of the device.
    pub name: String,
    /// The name and version of the driver.
    pub driver: String,
    /// The Vulkan version that the device supports, such as `1.3.230`.
    pub api: String,
    /// The kind of device: integrated, discrete, software.
    pub kind: vk::PhysicalDeviceType,
    /// The limits of the device, as the driver reports them.
    pub limits: vk::PhysicalDeviceLimits,
    /// The most textures of a [`TextureTable`](crate::TextureTable), on devices with
    /// [`OptionalFeature::DescriptorIndexing`].
    pub indexed_textures: u32,
    /// The entries of the engine's capability table that the device has.
    pub capabilities: Capabilities,
}

impl Adapter {
    /// Returns true if both are the same physical device, which others may share the name with.
    pub fn is_same_as(&self, other: &Self) -> bool {
        self.instance == other.instance && self.physical == other.physical
    }

    /// Reads the properties of a physical device, and derives its capabilities from `offer`.
    ///
    /// # Safety
    /// `physical` is of `instance`.
    pub(crate) unsafe fn read(
        instance: &InstanceShared,
        physical: vk::PhysicalDevice,
        offer: &Offer,
    ) -> Self {
        // SAFETY: the caller's promise.
        let properties = unsafe { instance.raw.get_physical_device_properties(physical) };
        let api = properties.api_version;
        Self {
            instance: instance.id,
            physical,
            queue_family: offer.queue_family,
            timestamp_bits: offer.timestamp_bits,
            name: text(properties.device_name_as_c_str()),
            // SAFETY: the caller's promise.
            driver: unsafe { driver_text(&instance.raw, physical, api, properties.driver_version) },
            api: version_text(api),
            kind: properties.device_type,
            limits: properties.limits,
            indexed_textures: offer.indexed_textures,
            capabilities: Capabilities::of(offer),
        }
    }

    /// Returns the preference for this device: a real GPU before a software one, then by
    /// capabilities.
    pub fn score(&self) -> u32 {
        let kind = match self.kind {
            vk::PhysicalDeviceType::DISCRETE_GPU => 4,
            vk::PhysicalDeviceType::INTEGRATED_GPU => 3,
            vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
            vk::PhysicalDeviceType::CPU => 1,
            _ => 0,
        };
        let optional = self.capabilities.optional.len() as u32;
        kind * 100 + optional
    }

    /// Returns true if hidden draws can be skipped by conditional rendering.
    pub fn has_conditional_rendering(&self) -> bool {
        self.capabilities.has(OptionalFeature::ConditionalRendering)
    }

    /// Returns true if the driver draws on the CPU.
    pub fn is_software(&self) -> bool {
        self.kind == vk::PhysicalDeviceType::CPU
    }

    /// Returns the names of the required capabilities that the device lacks; `None` if it lacks
    /// none.
    pub fn missing(&self) -> Option<String> {
        let names: Vec<_> = self.capabilities.missing.iter().map(|m| m.name()).collect();
        if names.is_empty() { None } else { Some(names.join(", ")) }
    }
}

/// Returns the name of a device.
///
/// # Safety
/// `physical` is of `instance`.
pub(crate) unsafe fn adapter_name(
    instance: &InstanceShared,
    physical: vk::PhysicalDevice,
) -> String {
    // SAFETY: the caller's promise.
    let properties = unsafe { instance.raw.get_physical_device_properties(physical) };
    text(properties.device_name_as_c_str())
}

/// Returns the driver's name and version.
///
/// # Safety
/// `physical` is of `instance` and supports the version `api`.
unsafe fn driver_text(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    api: u32,
    version: u32,
) -> String {
    if api < vk::API_VERSION_1_2 {
        return version_text(version);
    }
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: driver properties are core since 1.2, checked above.
    unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
    let name = text(driver.driver_name_as_c_str());
    let info = text(driver.driver_info_as_c_str());
    format!("{name} {info}").trim().to_owned()
}

fn text(name: Result<&std::ffi::CStr, std::ffi::FromBytesUntilNulError>) -> String {
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}
