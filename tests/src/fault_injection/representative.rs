//! A device that claims to support representative fragments. The real device never sees requests
//! for them.

use std::ffi::{CStr, c_char};
use std::mem::transmute;

use ash::{ext, khr, nv, vk};

use super::{Function, due, injected, portability, real};

/// Counts the pipelines of a [`FaultInjection`](super::FaultInjection) for representative
/// fragments.
pub const REPRESENTATIVE_PIPELINES: &CStr = c"pipelines for representative fragments";

/// Counts the other graphics pipelines.
pub const OTHER_PIPELINES: &CStr = c"pipelines for all fragments";

/// The call that lists the extensions of a device. It is counted.
pub const CALL_THAT_LISTS: &CStr = c"vkEnumerateDeviceExtensionProperties";
const DEVICE: &CStr = c"vkCreateDevice";
const PIPELINES: &CStr = c"vkCreateGraphicsPipelines";

pub(super) fn that_pretend() -> Vec<(&'static CStr, Function)> {
    // SAFETY: all are function pointers, and the caller knows the type by the name.
    unsafe {
        vec![
            (
                CALL_THAT_LISTS,
                transmute::<vk::PFN_vkEnumerateDeviceExtensionProperties, Function>(extensions),
            ),
            (DEVICE, transmute::<vk::PFN_vkCreateDevice, Function>(create_device)),
            (PIPELINES, transmute::<vk::PFN_vkCreateGraphicsPipelines, Function>(create_pipelines)),
        ]
    }
}

/// Returns the extensions that every device claims to have.
fn pretended() -> impl Iterator<Item = &'static CStr> {
    let representative = injected(|injected| injected.is_representative);
    let faults = injected(|injected| injected.describes_faults);
    let all = [
        representative.then_some(nv::representative_fragment_test::NAME),
        faults.then_some(ext::device_fault::NAME),
        portability::is_claimed().then_some(khr::portability_subset::NAME),
    ];
    all.into_iter().flatten()
}

unsafe extern "system" fn extensions(
    physical: vk::PhysicalDevice,
    layer: *const c_char,
    count: *mut u32,
    found: *mut vk::ExtensionProperties,
) -> vk::Result {
    if let Some(code) = due(CALL_THAT_LISTS) {
        return code;
    }
    // SAFETY: here and below: the type belongs to the function, and the caller passes valid
    // arguments for it, so all pointers are valid.
    unsafe {
        let real = real::<vk::PFN_vkEnumerateDeviceExtensionProperties>(CALL_THAT_LISTS);
        let room = *count as usize;
        let code = real(physical, layer, count, found);
        if !layer.is_null() {
            return code;
        }
        for name in pretended() {
            let place = *count as usize;
            *count += 1;
            if found.is_null() {
                continue;
            }
            if place >= room {
                *count = room as u32;
                return vk::Result::INCOMPLETE;
            }
            let mut properties = vk::ExtensionProperties::default();
            for (to, from) in properties.extension_name.iter_mut().zip(name.to_bytes_with_nul()) {
                *to = *from as c_char;
            }
            found.add(place).write(properties);
        }
        code
    }
}

unsafe extern "system" fn create_device(
    physical: vk::PhysicalDevice,
    info: *const vk::DeviceCreateInfo<'_>,
    callbacks: *const vk::AllocationCallbacks<'_>,
    made: *mut vk::Device,
) -> vk::Result {
    if let Some(code) = due(DEVICE) {
        return code;
    }
    // SAFETY: as above.
    unsafe {
        let mut info = *info;
        let names = match info.enabled_extension_count {
            0 => &[],
            count => std::slice::from_raw_parts(info.pp_enabled_extension_names, count as usize),
        };
        portability::note_device_extensions(names.iter().map(|name| CStr::from_ptr(*name)));
        let is_real =
            |name: &&*const c_char| !pretended().any(|other| other == CStr::from_ptr(**name));
        let names: Vec<*const c_char> = names.iter().filter(is_real).copied().collect();
        (info.pp_enabled_extension_names, info.enabled_extension_count) =
            (names.as_ptr(), names.len() as u32);
        let kind = vk::StructureType::PHYSICAL_DEVICE_REPRESENTATIVE_FRAGMENT_TEST_FEATURES_NV;
        let faults = vk::StructureType::PHYSICAL_DEVICE_FAULT_FEATURES_EXT;
        let subset = vk::StructureType::PHYSICAL_DEVICE_PORTABILITY_SUBSET_FEATURES_KHR;
        let head = (&raw mut info).cast();
        without(head, kind, || {
            without(head, faults, || {
                without(head, subset, || {
                    real::<vk::PFN_vkCreateDevice>(DEVICE)(physical, head.cast(), callbacks, made)
                })
            })
        })
    }
}

unsafe extern "system" fn create_pipelines(
    device: vk::Device,
    cache: vk::PipelineCache,
    count: u32,
    infos: *const vk::GraphicsPipelineCreateInfo<'_>,
    callbacks: *const vk::AllocationCallbacks<'_>,
    made: *mut vk::Pipeline,
) -> vk::Result {
    if let Some(code) = due(PIPELINES) {
        return code;
    }
    assert_eq!(count, 1, "one at a time");
    // SAFETY: as above.
    unsafe {
        let mut info = *infos;
        let kind = vk::StructureType::PIPELINE_REPRESENTATIVE_FRAGMENT_TEST_STATE_CREATE_INFO_NV;
        let before = before((&raw mut info).cast(), kind);
        due(if before.is_some() { REPRESENTATIVE_PIPELINES } else { OTHER_PIPELINES });
        without((&raw mut info).cast(), kind, || {
            let real = real::<vk::PFN_vkCreateGraphicsPipelines>(PIPELINES);
            real(device, cache, count, &info, callbacks, made)
        })
    }
}

/// Calls a function while a structure is removed from its chain.
///
/// # Safety
/// `head` begins a chain of structures that may be written.
unsafe fn without(
    head: *mut vk::BaseOutStructure<'_>,
    kind: vk::StructureType,
    call: impl FnOnce() -> vk::Result,
) -> vk::Result {
    // SAFETY: as above.
    unsafe {
        let Some(before) = before(head, kind) else { return call() };
        let out = (*before).p_next;
        (*before).p_next = (*out).p_next;
        let code = call();
        (*before).p_next = out;
        code
    }
}

/// Returns the predecessor of a structure in a chain.
///
/// # Safety
/// As [`without`].
unsafe fn before<'a>(
    head: *mut vk::BaseOutStructure<'a>,
    kind: vk::StructureType,
) -> Option<*mut vk::BaseOutStructure<'a>> {
    let mut at = head;
    // SAFETY: as above.
    unsafe {
        while let Some(next) = (*at).p_next.as_ref() {
            if next.s_type == kind {
                return Some(at);
            }
            at = (*at).p_next;
        }
    }
    None
}
