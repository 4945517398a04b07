//! Allocation callbacks of a host for Vulkan objects, which count blocks.
#![allow(unsafe_code, reason = "Vulkan calls them")]

use std::ffi::c_void;
use std::sync::atomic::{AtomicI64, Ordering};

use ash::vk;

/// The host memory of Vulkan objects, allocated by callbacks of a host.
#[derive(Default)]
pub struct Memory {
    /// Blocks that were allocated and not freed.
    pub blocks: AtomicI64,
    /// Blocks that were allocated.
    pub made: AtomicI64,
}

unsafe extern "system" fn allocate(
    user: *mut c_void,
    size: usize,
    alignment: usize,
    _scope: vk::SystemAllocationScope,
) -> *mut c_void {
    // SAFETY: the test passes this as user data. The size lies before the block.
    unsafe {
        let memory = &*user.cast::<Memory>();
        memory.blocks.fetch_add(1, Ordering::Relaxed);
        memory.made.fetch_add(1, Ordering::Relaxed);
        let head = alignment.max(2 * size_of::<usize>());
        let layout = std::alloc::Layout::from_size_align(size + head, head).unwrap();
        let block = std::alloc::alloc(layout).add(head);
        block.cast::<usize>().sub(1).write(size);
        block.cast::<usize>().sub(2).write(head);
        block.cast()
    }
}

unsafe extern "system" fn reallocate(
    user: *mut c_void,
    old: *mut c_void,
    size: usize,
    alignment: usize,
    scope: vk::SystemAllocationScope,
) -> *mut c_void {
    // SAFETY: as above.
    unsafe {
        let new = allocate(user, size, alignment, scope);
        if !old.is_null() {
            let kept = old.cast::<usize>().sub(1).read().min(size);
            new.cast::<u8>().copy_from_nonoverlapping(old.cast(), kept);
            free(user, old);
        }
        new
    }
}

unsafe extern "system" fn free(user: *mut c_void, block: *mut c_void) {
    if block.is_null() {
        return;
    }
    // SAFETY: as above.
    unsafe {
        (*user.cast::<Memory>()).blocks.fetch_sub(1, Ordering::Relaxed);
        let [size, head] = [1, 2].map(|back| block.cast::<usize>().sub(back).read());
        let layout = std::alloc::Layout::from_size_align(size + head, head).unwrap();
        std::alloc::dealloc(block.cast::<u8>().sub(head), layout);
    }
}

impl Memory {
    /// Returns callbacks that count in `self`.
    pub fn callbacks(&self) -> vk::AllocationCallbacks<'static> {
        vk::AllocationCallbacks {
            p_user_data: std::ptr::from_ref(self).cast_mut().cast(),
            pfn_allocation: Some(allocate),
            pfn_reallocation: Some(reallocate),
            pfn_free: Some(free),
            ..Default::default()
        }
    }
}
