//! A device that claims to have lazily allocated memory for transient attachments, as tile-based
//! GPUs do. The real device provides plain memory.

use std::cell::RefCell;
use std::collections::HashSet;
use std::ffi::CStr;
use std::mem::transmute;

use ash::vk;

use super::{Function, due, injected, real};

/// Counts the allocations of a [`FaultInjection`](super::FaultInjection) out of lazy memory.
pub const LAZY_ALLOCATIONS: &CStr = c"allocations of lazy memory";

const PROPERTIES: &CStr = c"vkGetPhysicalDeviceMemoryProperties";
const IMAGE: &CStr = c"vkCreateImage";
const REQUIREMENTS: &CStr = c"vkGetImageMemoryRequirements";
const ALLOCATE: &CStr = c"vkAllocateMemory";

/// The number of the memory type, after the types of all drivers.
const LAZY_TYPE: u32 = 20;

thread_local! {
    static TRANSIENT: RefCell<HashSet<vk::Image>> = RefCell::default();
}

pub(super) fn that_are_lazy() -> Vec<(&'static CStr, Function)> {
    // SAFETY: all are function pointers, and the caller knows the type by the name.
    unsafe {
        vec![
            (
                PROPERTIES,
                transmute::<vk::PFN_vkGetPhysicalDeviceMemoryProperties, Function>(properties),
            ),
            (IMAGE, transmute::<vk::PFN_vkCreateImage, Function>(create_image)),
            (
                REQUIREMENTS,
                transmute::<vk::PFN_vkGetImageMemoryRequirements, Function>(requirements),
            ),
            (ALLOCATE, transmute::<vk::PFN_vkAllocateMemory, Function>(allocate)),
        ]
    }
}

unsafe extern "system" fn properties(
    physical: vk::PhysicalDevice,
    found: *mut vk::PhysicalDeviceMemoryProperties,
) {
    // SAFETY: here and below: the type belongs to the function, and the caller passes valid
    // arguments for it, so all pointers are valid.
    unsafe {
        real::<vk::PFN_vkGetPhysicalDeviceMemoryProperties>(PROPERTIES)(physical, found);
        if injected(|injected| injected.is_lazy) {
            let found = &mut *found;
            assert!(found.memory_type_count <= LAZY_TYPE);
            found.memory_type_count = LAZY_TYPE + 1;
            found.memory_types[LAZY_TYPE as usize].property_flags =
                vk::MemoryPropertyFlags::DEVICE_LOCAL | vk::MemoryPropertyFlags::LAZILY_ALLOCATED;
        }
    }
}

unsafe extern "system" fn create_image(
    device: vk::Device,
    info: *const vk::ImageCreateInfo<'_>,
    callbacks: *const vk::AllocationCallbacks<'_>,
    made: *mut vk::Image,
) -> vk::Result {
    if let Some(code) = due(IMAGE) {
        return code;
    }
    // SAFETY: as above.
    unsafe {
        let code = real::<vk::PFN_vkCreateImage>(IMAGE)(device, info, callbacks, made);
        let is_transient = (*info).usage.contains(vk::ImageUsageFlags::TRANSIENT_ATTACHMENT);
        TRANSIENT.with_borrow_mut(|images| {
            if is_transient && code == vk::Result::SUCCESS {
                images.insert(*made)
            } else {
                images.remove(&*made)
            }
        });
        code
    }
}

unsafe extern "system" fn requirements(
    device: vk::Device,
    image: vk::Image,
    found: *mut vk::MemoryRequirements,
) {
    // SAFETY: as above.
    unsafe {
        real::<vk::PFN_vkGetImageMemoryRequirements>(REQUIREMENTS)(device, image, found);
        let is_transient = TRANSIENT.with_borrow(|images| images.contains(&image));
        if is_transient && injected(|injected| injected.is_lazy) {
            (*found).memory_type_bits |= 1 << LAZY_TYPE;
        }
    }
}

unsafe extern "system" fn allocate(
    device: vk::Device,
    info: *const vk::MemoryAllocateInfo<'_>,
    callbacks: *const vk::AllocationCallbacks<'_>,
    made: *mut vk::DeviceMemory,
) -> vk::Result {
    if let Some(code) = due(ALLOCATE) {
        return code;
    }
    // SAFETY: as above.
    unsafe {
        let mut info = *info;
        if info.memory_type_index == LAZY_TYPE {
            due(LAZY_ALLOCATIONS);
            // Both drivers have a single memory type for everything.
            info.memory_type_index = 0;
        }
        real::<vk::PFN_vkAllocateMemory>(ALLOCATE)(device, &info, callbacks, made)
    }
}
