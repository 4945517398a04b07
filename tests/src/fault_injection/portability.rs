//! A device on top of another interface, as MoltenVK's is: it has `VK_KHR_portability_subset`, and
//! instances that do not ask for such devices do not see it. The real device never sees requests
//! for it.

use std::cell::Cell;
use std::ffi::{CStr, c_char};
use std::mem::transmute;

use ash::{khr, vk};
use gpu::RequiredFeature;

use super::{Function, due, injected, real};

const INSTANCE: &CStr = c"vkCreateInstance";

thread_local! {
    static SEES_ALL_DEVICES: Cell<bool> = const { Cell::new(false) };
    static HAS_EXTENSION: Cell<bool> = const { Cell::new(false) };
}

pub(super) fn calls_that_create_instances() -> Vec<(&'static CStr, Function)> {
    // SAFETY: a function pointer, and the caller knows the type by the name.
    vec![(INSTANCE, unsafe { transmute::<vk::PFN_vkCreateInstance, Function>(create_instance) })]
}

/// Returns true if every device claims to have the extension.
pub(super) fn is_claimed() -> bool {
    injected(|machine| {
        machine.is_portability_subset || machine.lacks == Some(RequiredFeature::ComparisonSamplers)
    })
}

/// Returns true if the last instance of this thread does not see the device.
pub(super) fn is_hidden() -> bool {
    is_claimed() && !SEES_ALL_DEVICES.get()
}

/// Returns true if the last device of this thread was created with the extension.
pub fn is_portability_subset_enabled() -> bool {
    HAS_EXTENSION.get()
}

/// Notes the extensions of a device.
pub(super) fn note_device_extensions<'a>(mut names: impl Iterator<Item = &'a CStr>) {
    HAS_EXTENSION.set(names.any(|name| name == khr::portability_subset::NAME));
}

/// Fills in the features of the extension.
pub(super) fn fill(features: &mut vk::PhysicalDevicePortabilitySubsetFeaturesKHR<'_>) {
    let lacks = injected(|machine| machine.lacks == Some(RequiredFeature::ComparisonSamplers));
    features.mutable_comparison_samplers = (!lacks).into();
}

unsafe extern "system" fn create_instance(
    info: *const vk::InstanceCreateInfo<'_>,
    callbacks: *const vk::AllocationCallbacks<'_>,
    made: *mut vk::Instance,
) -> vk::Result {
    if let Some(code) = due(INSTANCE) {
        return code;
    }
    // SAFETY: the caller passes valid arguments.
    unsafe {
        let count = (*info).enabled_extension_count as usize;
        let names: &[*const c_char] = match count {
            0 => &[],
            count => std::slice::from_raw_parts((*info).pp_enabled_extension_names, count),
        };
        let extension = khr::portability_enumeration::NAME;
        let is_enabled = names.iter().any(|name| CStr::from_ptr(*name) == extension);
        let flag = vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
        SEES_ALL_DEVICES.set(is_enabled && (*info).flags.contains(flag));
        real::<vk::PFN_vkCreateInstance>(INSTANCE)(info, callbacks, made)
    }
}
