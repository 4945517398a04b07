//! The physical devices of an instance, and the choice of one.

use ash::vk;

use crate::core::adapter::{Adapter, adapter_name};
use crate::core::address_space::explained;
use crate::core::error::{Called, Error};
use crate::core::instance::{Instance, refusal};
use crate::core::offer::Offer;
#[cfg(feature = "window")]
use crate::core::ownership;
#[cfg(feature = "window")]
use crate::present::surface::Surface;

impl Instance {
    /// Returns all devices of this machine in the driver's order, suitable or not. A device whose
    /// driver cannot describe it is left out, with a warning in the log.
    ///
    /// # Errors
    /// [`Error::NoDriver`] if there is none; [`Error::AddressSpace`] if there is too little address
    /// space for a driver; a failed call, which leaves no device.
    pub fn adapters(&self) -> Result<Vec<Adapter>, Error> {
        Ok(self.read_adapters()?.readable)
    }

    fn read_adapters(&self) -> Result<Adapters, Error> {
        // SAFETY: no contract beyond a valid instance.
        let devices = match unsafe { self.shared.raw.enumerate_physical_devices() } {
            Err(code @ vk::Result::ERROR_INITIALIZATION_FAILED) => {
                return Err(refusal("vkEnumeratePhysicalDevices", code));
            }
            other => other.called("vkEnumeratePhysicalDevices")?,
        };
        if devices.is_empty() {
            let found = "vkEnumeratePhysicalDevices lists no device".to_owned();
            return Err(explained(Error::NoDriver(found)));
        }
        let mut adapters = Adapters::default();
        let mut first_error = None;
        for physical in devices {
            match self.read_adapter(physical) {
                Ok(adapter) => adapters.readable.push(adapter),
                Err(error) => {
                    // SAFETY: `physical` comes from this instance.
                    let name = unsafe { adapter_name(&self.shared, physical) };
                    adapters.left_out.push(left_out(&name, &error));
                    first_error.get_or_insert(error);
                }
            }
        }
        match first_error {
            Some(error) if adapters.readable.is_empty() => Err(error),
            _ => Ok(adapters),
        }
    }

    /// Returns the adapter to use: `wanted` by its index or a part of its name, otherwise the best
    /// one.
    ///
    /// # Errors
    /// [`Error::UnknownDevice`]; [`Error::DeviceLacks`] for the requested device;
    /// [`Error::NoSuitableDevice`] if no device is suitable.
    pub fn pick_adapter(&self, wanted: Option<&str>) -> Result<Adapter, Error> {
        pick(self.read_adapters()?, wanted)
    }

    /// Returns the adapter that [`Instance::pick_adapter`] would choose among those that can
    /// present to the window of `surface`. A device whose driver cannot say whether it can is left
    /// out, with a warning in the log.
    ///
    /// # Errors
    /// The errors of [`Instance::pick_adapter`]; [`Error::Foreign`] for a surface of another
    /// instance; [`Error::CannotPresent`] if the requested device, or every device, cannot present
    /// to the window; a failed call, which leaves no device.
    #[cfg(feature = "window")]
    pub fn pick_adapter_for(
        &self,
        surface: &Surface,
        wanted: Option<&str>,
    ) -> Result<Adapter, Error> {
        let ids = (surface.instance().id, self.shared.id);
        ownership::check(ids.0, ids.1, "a surface (`Surface`)", "an instance", "Instance")?;
        if wanted.is_some() {
            let adapter = self.pick_adapter(wanted)?;
            return surface.presenting(&adapter)?.map_err(Error::CannotPresent);
        }
        let mut fit = Vec::new();
        let mut first_error = None;
        let Adapters { readable, left_out: mut refused } = self.read_adapters()?;
        for adapter in readable {
            if let Some(missing) = adapter.missing() {
                refused.push(format!("{} lacks {missing}", adapter.name));
                continue;
            }
            match surface.presenting(&adapter) {
                Ok(Ok(adapter)) => fit.push(adapter),
                Ok(Err(reason)) => refused.push(reason),
                Err(error) => {
                    refused.push(left_out(&adapter.name, &error));
                    first_error.get_or_insert(error);
                }
            }
        }
        // The first of the best: `max_by_key` would return the last one.
        let best = fit.into_iter().rev().max_by_key(Adapter::score);
        best.ok_or_else(|| first_error.unwrap_or_else(|| Error::CannotPresent(refused.join("; "))))
    }

    fn read_adapter(&self, physical: vk::PhysicalDevice) -> Result<Adapter, Error> {
        let shared = &self.shared;
        // SAFETY: `physical` comes from this instance.
        let offer = unsafe { Offer::read(&shared.raw, physical, shared.windows.as_ref()) }?;
        // SAFETY: as above.
        Ok(unsafe { Adapter::read(shared, physical, &offer) })
    }
}

/// Returns the reason why a device is left out, and warns of it.
fn left_out(name: &str, error: &Error) -> String {
    let reason = format!("{name} is left out: {error}");
    tracing::warn!("{reason}");
    reason
}

/// The devices of a machine.
#[derive(Default)]
struct Adapters {
    readable: Vec<Adapter>,
    /// Each other device with the call that failed.
    left_out: Vec<String>,
}

impl Adapters {
    fn list(&self) -> String {
        let readable = self.readable.iter().enumerate();
        let readable = readable.map(|(index, adapter)| format!("{index}: {}", adapter.name));
        let all: Vec<_> = readable.chain(self.left_out.iter().cloned()).collect();
        all.join(", ")
    }
}

fn pick(found: Adapters, wanted: Option<&str>) -> Result<Adapter, Error> {
    let available = found.list();
    let Adapters { readable: mut adapters, left_out: mut refused } = found;
    let Some(wanted) = wanted else {
        refused.extend(
            adapters
                .iter()
                .filter_map(|a| a.missing().map(|missing| format!("{} lacks {missing}", a.name))),
        );
        adapters.retain(|adapter| adapter.capabilities.missing.is_empty());
        // The first of the best: `max_by_key` would return the last one.
        let best = adapters.into_iter().rev().max_by_key(Adapter::score);
        return best.ok_or_else(|| Error::NoSuitableDevice { refused: refused.join("; ") });
    };
    let needle = wanted.trim().to_lowercase();
    let position = match needle.parse::<usize>() {
        Ok(index) => Some(index).filter(|index| *index < adapters.len()),
        Err(_) if needle.is_empty() => None,
        Err(_) => adapters.iter().position(|a| {
            a.name.to_lowercase().contains(&needle) || a.driver.to_lowercase().contains(&needle)
        }),
    };
    let Some(position) = position else {
        return Err(Error::UnknownDevice { wanted: wanted.to_owned(), available });
    };
    let adapter = adapters.swap_remove(position);
    match adapter.missing() {
        None => Ok(adapter),
        Some(missing) => Err(Error::DeviceLacks { device: adapter.name, missing, available }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::capabilities::{Capabilities, RequiredFeature};
    use crate::core::ownership::OwnerId;

    fn adapter(name: &str, kind: vk::PhysicalDeviceType, missing: Vec<RequiredFeature>) -> Adapter {
        Adapter {
            instance: OwnerId::new(),
            physical: vk::PhysicalDevice::null(),
            queue_family: Some(0),
            timestamp_bits: 64,
            name: name.to_owned(),
            driver: "test".to_owned(),
            api: "1.3.0".to_owned(),
            kind,
            indexed_textures: 0,
            limits: vk::PhysicalDeviceLimits::default(),
            capabilities: Capabilities { missing, ..Capabilities::default() },
        }
    }

    fn machine() -> Adapters {
        let readable = vec![
            adapter("llvmpipe (LLVM 15)", vk::PhysicalDeviceType::CPU, vec![]),
            adapter(
                "Old Card",
                vk::PhysicalDeviceType::DISCRETE_GPU,
                vec![RequiredFeature::Vulkan13],
            ),
            adapter("Card", vk::PhysicalDeviceType::INTEGRATED_GPU, vec![]),
        ];
        Adapters { readable, left_out: Vec::new() }
    }

    #[test]
    fn the_best_fit_device_is_taken() {
        assert_eq!(pick(machine(), None).unwrap().name, "Card");
    }

    #[test]
    fn names_and_indices_choose() {
        assert_eq!(pick(machine(), Some("LLVMpipe")).unwrap().name, "llvmpipe (LLVM 15)");
        assert_eq!(pick(machine(), Some("2")).unwrap().name, "Card");
        for unknown in ["3", "", "voodoo", "-1"] {
            let error = pick(machine(), Some(unknown)).unwrap_err();
            assert!(error.to_string().contains("0: llvmpipe"), "{error}");
        }
    }

    #[test]
    fn a_refusal_names_what_is_missing() {
        let error = pick(machine(), Some("old")).unwrap_err();
        assert!(error.to_string().contains("Old Card lacks Vulkan 1.3"), "{error}");
        let only_old =
            Adapters { readable: vec![machine().readable.swap_remove(1)], ..Adapters::default() };
        let error = pick(only_old, None).unwrap_err();
        assert!(error.to_string().contains("Old Card lacks Vulkan 1.3"), "{error}");
    }

    #[test]
    fn an_error_has_the_devices_that_were_left_out() {
        let left_out = vec!["Broken Card is left out: vkSomething failed".to_owned()];
        for wanted in [None, Some("Broken")] {
            let adapters = Adapters { readable: Vec::new(), left_out: left_out.clone() };
            let error = pick(adapters, wanted).unwrap_err();
            assert!(error.to_string().contains("Broken Card is left out"), "{error}");
        }
    }
}
