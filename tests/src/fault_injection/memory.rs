//! Devices with other memory than the real ones, which provide plain memory of a single type:
//! lazily allocated memory for transient attachments, as tile-based GPUs have, host memory beside
//! device memory, and little of the latter. All memory is counted.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::ffi::CStr;
use std::mem::transmute;

use ash::vk;

use super::{Function, due, injected, real};

/// Counts the allocations of a [`FaultInjection`](super::FaultInjection) out of lazy memory.
pub const LAZY_ALLOCATIONS: &CStr = c"allocations of lazy memory";

/// Counts the allocations of a [`FaultInjection`](super::FaultInjection) out of host memory.
pub const HOST_ALLOCATIONS: &CStr = c"allocations of host memory";

const PROPERTIES: &CStr = c"vkGetPhysicalDeviceMemoryProperties";
const IMAGE: &CStr = c"vkCreateImage";
const OF_IMAGE: &CStr = c"vkGetImageMemoryRequirements";
const OF_BUFFER: &CStr = c"vkGetBufferMemoryRequirements";
const ALLOCATE: &CStr = c"vkAllocateMemory";
const FREE: &CStr = c"vkFreeMemory";

/// The number of the lazy memory type, after the types of all drivers.
const LAZY_TYPE: u32 = 20;
/// The number of the type of host memory.
const HOST_TYPE: u32 = 21;

/// The memory of this thread's devices.
#[derive(Default)]
struct Allocated {
    transient: HashSet<vk::Image>,
    sizes: HashMap<vk::DeviceMemory, u64>,
    bytes: u64,
    most_bytes: u64,
}

thread_local! {
    static ALLOCATED: RefCell<Allocated> = RefCell::default();
}

/// Returns the most bytes that were allocated at once since the last call.
pub fn most_allocated() -> u64 {
    ALLOCATED.with_borrow_mut(|all| std::mem::replace(&mut all.most_bytes, all.bytes))
}

pub(super) fn calls_of_memory() -> Vec<(&'static CStr, Function)> {
    // SAFETY: all are function pointers, and the caller knows the type by the name.
    unsafe {
        vec![
            (
                PROPERTIES,
                transmute::<vk::PFN_vkGetPhysicalDeviceMemoryProperties, Function>(properties),
            ),
            (IMAGE, transmute::<vk::PFN_vkCreateImage, Function>(create_image)),
            (
                OF_IMAGE,
                transmute::<vk::PFN_vkGetImageMemoryRequirements, Function>(image_requirements),
            ),
            (
                OF_BUFFER,
                transmute::<vk::PFN_vkGetBufferMemoryRequirements, Function>(buffer_requirements),
            ),
            (ALLOCATE, transmute::<vk::PFN_vkAllocateMemory, Function>(allocate)),
            (FREE, transmute::<vk::PFN_vkFreeMemory, Function>(free)),
        ]
    }
}

unsafe extern "system" fn properties(
    physical: vk::PhysicalDevice,
    found: *mut vk::PhysicalDeviceMemoryProperties,
) {
    // SAFETY: here and below: the type belongs to the function, and the caller passes valid
    // arguments for it, so all pointers are valid.
    let found = unsafe {
        real::<vk::PFN_vkGetPhysicalDeviceMemoryProperties>(PROPERTIES)(physical, found);
        &mut *found
    };
    assert!(found.memory_type_count <= LAZY_TYPE);
    let mut add = |number: u32, property_flags, heap_index| {
        found.memory_type_count = found.memory_type_count.max(number + 1);
        found.memory_types[number as usize] = vk::MemoryType { property_flags, heap_index };
    };
    let device = vk::MemoryPropertyFlags::DEVICE_LOCAL;
    if injected(|injected| injected.is_lazy) {
        add(LAZY_TYPE, device | vk::MemoryPropertyFlags::LAZILY_ALLOCATED, 0);
    }
    if injected(|injected| injected.has_host_memory) {
        let host = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let heap = found.memory_heap_count;
        add(HOST_TYPE, host, heap);
        found.memory_heaps[heap as usize].size = 1 << 32;
        found.memory_heap_count += 1;
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
        ALLOCATED.with_borrow_mut(|all| {
            if is_transient && code == vk::Result::SUCCESS {
                all.transient.insert(*made)
            } else {
                all.transient.remove(&*made)
            }
        });
        code
    }
}

unsafe extern "system" fn image_requirements(
    device: vk::Device,
    image: vk::Image,
    found: *mut vk::MemoryRequirements,
) {
    // SAFETY: as above.
    unsafe {
        real::<vk::PFN_vkGetImageMemoryRequirements>(OF_IMAGE)(device, image, found);
        let is_transient = ALLOCATED.with_borrow(|all| all.transient.contains(&image));
        if is_transient && injected(|injected| injected.is_lazy) {
            (*found).memory_type_bits |= 1 << LAZY_TYPE;
        }
    }
}

unsafe extern "system" fn buffer_requirements(
    device: vk::Device,
    buffer: vk::Buffer,
    found: *mut vk::MemoryRequirements,
) {
    // SAFETY: as above.
    unsafe {
        real::<vk::PFN_vkGetBufferMemoryRequirements>(OF_BUFFER)(device, buffer, found);
        if injected(|injected| injected.has_host_memory) {
            (*found).memory_type_bits |= 1 << HOST_TYPE;
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
        let is_host = info.memory_type_index == HOST_TYPE;
        if info.memory_type_index == LAZY_TYPE {
            due(LAZY_ALLOCATIONS);
        } else if is_host {
            due(HOST_ALLOCATIONS);
        }
        if [LAZY_TYPE, HOST_TYPE].contains(&info.memory_type_index) {
            // Both drivers have a single memory type for everything.
            info.memory_type_index = 0;
        }
        let most = injected(|injected| injected.device_bytes).unwrap_or(u64::MAX);
        let in_use = ALLOCATED.with_borrow(|all| all.bytes);
        if !is_host && in_use.saturating_add(info.allocation_size) > most {
            return vk::Result::ERROR_OUT_OF_DEVICE_MEMORY;
        }
        let code = real::<vk::PFN_vkAllocateMemory>(ALLOCATE)(device, &info, callbacks, made);
        if code == vk::Result::SUCCESS && !is_host {
            ALLOCATED.with_borrow_mut(|all| {
                all.sizes.insert(*made, info.allocation_size);
                all.bytes += info.allocation_size;
                all.most_bytes = all.most_bytes.max(all.bytes);
            });
        }
        code
    }
}

unsafe extern "system" fn free(
    device: vk::Device,
    memory: vk::DeviceMemory,
    callbacks: *const vk::AllocationCallbacks<'_>,
) {
    ALLOCATED.with_borrow_mut(|all| {
        all.bytes -= all.sizes.remove(&memory).unwrap_or(0);
    });
    // SAFETY: as above.
    unsafe { real::<vk::PFN_vkFreeMemory>(FREE)(device, memory, callbacks) }
}
