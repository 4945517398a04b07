//! The clocks of the GPU and the CPU, read at once, for a common time line of their work.

use ash::{ext, vk};

use crate::core::device::Device;
use crate::core::error::{Called, Error};

/// The same moment on two clocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clocks {
    /// The GPU clock that times passes, in nanoseconds.
    pub gpu_ns: u64,
    /// `CLOCK_MONOTONIC`, in nanoseconds.
    pub monotonic_ns: u64,
    /// The greatest distance between the two readings, in nanoseconds.
    pub deviation_ns: u64,
}

impl Device {
    /// Reads both clocks. `None` if the device lacks
    /// [`crate::OptionalFeature::CalibratedTimestamps`] or cannot read one of these clocks.
    ///
    /// # Errors
    /// A failed call.
    pub fn clocks(&self) -> Result<Option<Clocks>, Error> {
        let Some(functions) = &self.extensions().calibrated else { return Ok(None) };
        let domains = [vk::TimeDomainEXT::DEVICE, vk::TimeDomainEXT::CLOCK_MONOTONIC];
        let there = self.time_domains()?;
        if !domains.iter().all(|domain| there.contains(domain)) {
            return Ok(None);
        }
        let infos =
            domains.map(|domain| vk::CalibratedTimestampInfoEXT::default().time_domain(domain));
        // SAFETY: the device supports these domains.
        let (stamps, deviation_ns) = unsafe { functions.get_calibrated_timestamps(&infos) }
            .called("vkGetCalibratedTimestampsEXT")?;
        let &[steps, monotonic_ns] = stamps.as_slice() else { return Ok(None) };
        let adapter = self.adapter();
        let mask = u64::MAX >> (64 - adapter.timestamp_bits.clamp(1, 64));
        let ns_per_step = f64::from(adapter.limits.timestamp_period);
        let gpu_ns = ((steps & mask) as f64 * ns_per_step) as u64;
        Ok(Some(Clocks { gpu_ns, monotonic_ns, deviation_ns }))
    }

    fn time_domains(&self) -> Result<Vec<vk::TimeDomainEXT>, Error> {
        let instance = self.instance();
        let functions = ext::calibrated_timestamps::Instance::new(&instance.entry, &instance.raw);
        let physical = self.adapter().physical;
        // SAFETY: the device's own adapter, which has the extension.
        unsafe { functions.get_physical_device_calibrateable_time_domains(physical) }
            .called("vkGetPhysicalDeviceCalibrateableTimeDomainsEXT")
    }
}
