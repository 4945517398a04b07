//! The host memory of a host: allocation callbacks that count.

use std::alloc::{Layout, alloc, dealloc};
use std::ffi::c_void;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};

use ash::vk;

/// The counts of a host's allocation callbacks.
#[derive(Debug, Default)]
pub struct HostMemory {
    live: AtomicI64,
    made: AtomicU64,
}

/// The least number of bytes before a block, which hold the block's size and alignment.
const HEADER: usize = 16;

impl HostMemory {
    /// Returns the callbacks, which count until the program ends.
    pub fn callbacks(&'static self) -> vk::AllocationCallbacks<'static> {
        vk::AllocationCallbacks::default()
            .user_data(std::ptr::from_ref(self).cast_mut().cast())
            .pfn_allocation(Some(allocate))
            .pfn_reallocation(Some(reallocate))
            .pfn_free(Some(free))
    }

    /// Returns the number of blocks that were allocated and not freed.
    pub fn live(&self) -> i64 {
        self.live.load(Ordering::Relaxed)
    }

    /// Returns the number of all blocks that were ever allocated.
    pub fn made(&self) -> u64 {
        self.made.load(Ordering::Relaxed)
    }
}

/// Returns the layout of a block with its header, and the size of the header.
fn layout(size: usize, alignment: usize) -> (Layout, usize) {
    let header = alignment.max(HEADER);
    (Layout::from_size_align(header + size, header).unwrap(), header)
}

unsafe extern "system" fn allocate(
    user_data: *mut c_void,
    size: usize,
    alignment: usize,
    _scope: vk::SystemAllocationScope,
) -> *mut c_void {
    // SAFETY: the user data of `HostMemory::callbacks`.
    let memory = unsafe { &*user_data.cast::<HostMemory>() };
    memory.live.fetch_add(1, Ordering::Relaxed);
    memory.made.fetch_add(1, Ordering::Relaxed);
    let (layout, header) = layout(size, alignment);
    // SAFETY: the layout is not empty, and the header lies within it, aligned.
    unsafe {
        let block = alloc(layout).add(header);
        block.sub(HEADER).cast::<[usize; 2]>().write([size, alignment]);
        block.cast()
    }
}

unsafe extern "system" fn reallocate(
    user_data: *mut c_void,
    block: *mut c_void,
    size: usize,
    alignment: usize,
    scope: vk::SystemAllocationScope,
) -> *mut c_void {
    // SAFETY: `allocate` returned the blocks, with a header; the copy stays within both.
    unsafe {
        if size == 0 {
            free(user_data, block);
            return std::ptr::null_mut();
        }
        let larger = allocate(user_data, size, alignment, scope);
        if !block.is_null() {
            let [old, _] = *block.cast::<u8>().sub(HEADER).cast::<[usize; 2]>();
            std::ptr::copy_nonoverlapping(block.cast::<u8>(), larger.cast(), old.min(size));
            free(user_data, block);
        }
        larger
    }
}

unsafe extern "system" fn free(user_data: *mut c_void, block: *mut c_void) {
    if block.is_null() {
        return;
    }
    // SAFETY: as in `reallocate`.
    unsafe {
        (*user_data.cast::<HostMemory>()).live.fetch_sub(1, Ordering::Relaxed);
        let [size, alignment] = *block.cast::<u8>().sub(HEADER).cast::<[usize; 2]>();
        let (layout, header) = layout(size, alignment);
        dealloc(block.cast::<u8>().sub(header), layout);
    }
}
