//! Opens a device by the Vulkan loader of the machine.

use std::ffi::CStr;

use gpu::{Device, DeviceOptions, Instance, InstanceOptions, Validation, load_entry};

use super::device_open::{
    ANTUMBRA_VALIDATION_CORE, ANTUMBRA_VALIDATION_OFF, ANTUMBRA_VALIDATION_SYNCHRONIZATION,
    AntumbraDeviceOpenDesc,
};
use crate::error::Failure;

/// Opens a device.
///
/// # Safety
/// As the rules of the interface.
pub(crate) unsafe fn open(desc: &AntumbraDeviceOpenDesc) -> Result<Device, Failure> {
    let validation = match desc.validation {
        ANTUMBRA_VALIDATION_OFF => Validation::Off,
        ANTUMBRA_VALIDATION_CORE => Validation::Core,
        ANTUMBRA_VALIDATION_SYNCHRONIZATION => Validation::Synchronization,
        other => {
            let message = format_args!("there is no ANTUMBRA_VALIDATION_.. {other}");
            return Err(Failure::argument(message));
        }
    };
    let name = if desc.name.is_null() {
        None
    } else {
        // SAFETY: the caller's promise.
        let name = unsafe { CStr::from_ptr(desc.name) }.to_str();
        Some(name.map_err(|_| Failure::argument("desc.name is not UTF-8"))?)
    };
    let options = InstanceOptions { validation, ..InstanceOptions::default() };
    let instance = Instance::new(load_entry()?, &options)?;
    let adapter = instance.pick_adapter(name)?;
    let budget_bytes = desc.memory_budget_bytes;
    let options = DeviceOptions {
        memory_budget_bytes: (budget_bytes > 0).then_some(budget_bytes),
        ..DeviceOptions::default()
    };
    Ok(Device::new(&instance, &adapter, &options)?)
}
