//! Physical devices: their names, scores and capabilities.

use ash::vk;

use crate::core::capabilities::{Capabilities, Optional};
use crate::core::ownership::OwnerId;

/// A physical device as the engine sees it.
#[derive(Debug, Clone)]
pub struct Adapter {
    pub(crate) instance: OwnerId,
    pub(crate) physical: vk::PhysicalDevice,
    pub(crate) queue_family: Option<u32>,
    pub(crate) timestamp_bits: u32,
    /// The device's name.
    pub name: String,
    /// The driver's name and version.
    pub driver: String,
    /// The Vulkan version it speaks, `1.3.230`.
    pub api: String,
    /// The kind of device: integrated, discrete, software.
    pub kind: vk::PhysicalDeviceType,
    /// The limits of the device, as the driver reports them.
    pub limits: vk::PhysicalDeviceLimits,
    /// The entries of the engine's capability table that it has.
    pub capabilities: Capabilities,
}

impl Adapter {
    /// Returns the preference for it: a real GPU before a software one, then by capabilities.
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
        self.capabilities.has(Optional::ConditionalRendering)
    }

    /// Returns true if it is a driver that draws on the CPU.
    pub fn is_software(&self) -> bool {
        self.kind == vk::PhysicalDeviceType::CPU
    }

    /// Returns the names of the required capabilities that it lacks, if any.
    pub fn missing(&self) -> Option<String> {
        let names: Vec<_> = self.capabilities.missing.iter().map(|m| m.name()).collect();
        if names.is_empty() { None } else { Some(names.join(", ")) }
    }
}
