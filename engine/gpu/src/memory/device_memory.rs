//! Device memory: the one place that takes it from the driver, and decides what is tried when there
//! is too little of it.
//!
//! The crate `gpu-allocator` divides blocks. It neither knows a budget nor reports the code of a
//! failed call. So it gets a device whose functions for memory are ours: they refuse a block beyond
//! the budget, and keep the code.

use std::ffi::c_void;
use std::ptr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use ash::ext::debug_utils;
use ash::vk::{self, Handle as _};
use gpu_allocator::vulkan::{
    Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc,
};
use gpu_allocator::{AllocationError, AllocationSizes, AllocatorDebugSettings, MemoryLocation};

use crate::core::debug_name::set_debug_name;
use crate::core::error::Error;
use crate::core::instance::InstanceShared;
use crate::core::queue_lock::lock;
use crate::memory::attempts::{Attempt, MemoryTypes, Scheme, attempts, block_bytes};
use crate::memory::memory_error::MemoryFailure;
use crate::memory::memory_use::MemoryUse;

/// A buffer or an image that needs memory.
#[derive(Clone, Copy)]
pub(crate) enum MemoryOwner {
    Buffer(vk::Buffer),
    Image(vk::Image),
}

/// A request for memory.
#[derive(Clone, Copy)]
pub(crate) struct MemoryRequest<'a> {
    pub(crate) name: &'a str,
    pub(crate) owner: MemoryOwner,
    pub(crate) requirements: vk::MemoryRequirements,
    pub(crate) location: MemoryLocation,
}

/// The memory of a device.
pub(crate) struct DeviceMemory {
    // Dropped before the source of its blocks.
    allocator: Allocator,
    source: Arc<BlockSource>,
    types: MemoryTypes,
    budget_bytes: Option<u64>,
    /// True once a buffer or image has got slower memory.
    has_warned: bool,
}

impl DeviceMemory {
    /// Prepares the memory of a device; takes no memory yet.
    pub(crate) fn new(
        instance: &InstanceShared,
        physical: vk::PhysicalDevice,
        device: &ash::Device,
        debug: Option<debug_utils::Device>,
        budget_bytes: Option<u64>,
    ) -> Result<Self, Error> {
        // SAFETY: a physical device of the instance.
        let types = unsafe { instance.raw.get_physical_device_memory_properties(physical) };
        let [device_bytes, host_bytes] = block_bytes(budget_bytes);
        let source = BlockSource::new(device, debug);
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: source.as_device(),
            physical_device: physical,
            debug_settings: AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: AllocationSizes::new(device_bytes, host_bytes),
        })
        .map_err(Error::Allocator)?;
        Ok(Self { allocator, source, types: MemoryTypes(types), budget_bytes, has_warned: false })
    }

    /// Returns the use of the memory.
    pub(crate) fn in_use(&self) -> MemoryUse {
        let report = self.allocator.generate_report();
        MemoryUse {
            block_bytes: report.total_capacity_bytes,
            used_bytes: report.total_allocated_bytes,
            budget_bytes: self.budget_bytes,
            heap_bytes: self.types.device_heap_bytes(),
        }
    }

    /// Returns the names and sizes of the parts of blocks that are in use.
    pub(crate) fn parts_in_use(&self) -> Vec<gpu_allocator::AllocationReport> {
        self.allocator.generate_report().allocations
    }

    /// Allocates memory by the attempt that succeeds unless memory is short.
    pub(crate) fn allocate_plainly(
        &mut self,
        request: &MemoryRequest<'_>,
    ) -> Result<Allocation, MemoryFailure> {
        let bits = request.requirements.memory_type_bits;
        self.attempt(request, Attempt::plain(bits, request.location))
    }

    /// Allocates memory that the device provides only when an image is stored; `None` if there is
    /// no memory of this kind.
    pub(crate) fn allocate_lazily(&mut self, request: &MemoryRequest<'_>) -> Option<Allocation> {
        let type_bits = request.requirements.memory_type_bits & self.types.lazy();
        let plain = Attempt::plain(type_bits, MemoryLocation::GpuOnly);
        let lazily = Attempt { scheme: Scheme::OwnBlock, ..plain };
        if type_bits == 0 { None } else { self.attempt(request, lazily).ok() }
    }

    /// Allocates memory by one attempt after the other, until one succeeds.
    pub(crate) fn allocate(
        &mut self,
        request: &MemoryRequest<'_>,
    ) -> Result<Allocation, MemoryFailure> {
        let bits = request.requirements.memory_type_bits;
        let mut failure = None;
        for attempt in attempts(bits, request.location, &self.types) {
            match self.attempt(request, attempt) {
                Ok(allocation) => {
                    if attempt.is_slower && !self.has_warned {
                        self.has_warned = true;
                        warn_of_host_memory(request, self.in_use(), failure);
                    }
                    return Ok(allocation);
                }
                Err(failed) if failed.is_out_of_memory() => failure = Some(failed),
                Err(failed) => return Err(failed),
            }
        }
        Err(failure.unwrap_or(MemoryFailure::NoType))
    }

    /// Allocates memory of the first type that an attempt allows.
    fn attempt(
        &mut self,
        request: &MemoryRequest<'_>,
        attempt: Attempt,
    ) -> Result<Allocation, MemoryFailure> {
        let MemoryRequest { name, owner, requirements, .. } = *request;
        let wanted = AllocationCreateDesc {
            name,
            requirements: vk::MemoryRequirements {
                memory_type_bits: attempt.type_bits,
                ..requirements
            },
            location: attempt.location,
            linear: matches!(owner, MemoryOwner::Buffer(_)),
            allocation_scheme: match (attempt.scheme, owner) {
                (Scheme::SharedBlock, _) => AllocationScheme::GpuAllocatorManaged,
                (Scheme::OwnBlock, MemoryOwner::Buffer(buffer)) => {
                    AllocationScheme::DedicatedBuffer(buffer)
                }
                (Scheme::OwnBlock, MemoryOwner::Image(image)) => {
                    AllocationScheme::DedicatedImage(image)
                }
            },
        };
        let block_bytes = self.allocator.capacity();
        let left_bytes = self.budget_bytes.map_or(u64::MAX, |all| all.saturating_sub(block_bytes));
        self.source.left_bytes.store(left_bytes, Ordering::Relaxed);
        *lock(&self.source.failure) = None;
        let allocated = self.allocator.allocate(&wanted);
        let failure = lock(&self.source.failure).take();
        allocated.map_err(|error| match (error, failure) {
            (_, Some(BlockFailure::OverBudget)) => MemoryFailure::OverBudget,
            (_, Some(BlockFailure::Call { call, code })) => MemoryFailure::Call { call, code },
            (AllocationError::OutOfMemory, None) => MemoryFailure::SmallHeap,
            (AllocationError::NoCompatibleMemoryTypeFound, None) => MemoryFailure::NoType,
            (error, None) => MemoryFailure::Allocator(error),
        })
    }

    /// Gives memory back.
    pub(crate) fn free(&mut self, allocation: Allocation) {
        if let Err(error) = self.allocator.free(allocation) {
            tracing::error!("memory could not be given back: {error}");
        }
    }
}

/// Warns of memory that the GPU reads over the bus.
fn warn_of_host_memory(
    request: &MemoryRequest<'_>,
    in_use: MemoryUse,
    failure: Option<MemoryFailure>,
) {
    let failure = failure.map(|failure| failure.text(in_use)).unwrap_or_default();
    tracing::warn!(
        "no device memory is left for {} ({} bytes): it lies in host memory, which the GPU reads \
         over the bus, many times slower, and so may what follows ({failure}; {in_use})",
        request.name,
        request.requirements.size,
    );
}

/// A device as the allocator sees it: its handle points here, and it has no other functions than
/// the ones below.
struct BlockSource {
    /// The real device.
    device: ash::Device,
    /// The functions that name blocks, if a debugger or layer is active.
    debug: Option<debug_utils::Device>,
    /// The bytes that the budget leaves for the next block.
    left_bytes: AtomicU64,
    /// The failure of the newest block.
    failure: Mutex<Option<BlockFailure>>,
}

/// The failure of a block.
#[derive(Clone, Copy)]
enum BlockFailure {
    OverBudget,
    Call { call: &'static str, code: vk::Result },
}

impl BlockSource {
    fn new(device: &ash::Device, debug: Option<debug_utils::Device>) -> Arc<Self> {
        let device = device.clone();
        Arc::new(Self { device, debug, left_bytes: AtomicU64::new(0), failure: Mutex::default() })
    }

    /// Gives a block its debug name.
    fn name(&self, block: vk::DeviceMemory, info: &vk::MemoryAllocateInfo<'_>) {
        let Some(debug) = &self.debug else { return };
        let kib = info.allocation_size.div_ceil(1 << 10);
        let name = format!("block of {kib} KiB, memory type {}", info.memory_type_index);
        set_debug_name(debug, block, &name);
    }

    /// Notes the code of a call that failed, and returns it.
    fn noted(&self, call: &'static str, code: vk::Result) -> vk::Result {
        if code != vk::Result::SUCCESS {
            *lock(&self.failure) = Some(BlockFailure::Call { call, code });
        }
        code
    }

    /// Returns the device for the allocator, which must not outlive the source.
    fn as_device(self: &Arc<Self>) -> ash::Device {
        // A function that an allocator newly calls ends the program with its name, instead of
        // giving the real driver our pointer.
        let mut core = ash::DeviceFnV1_0::load(|_| ptr::null());
        core.allocate_memory = allocate_block;
        core.free_memory = free_block;
        core.map_memory = map_block;
        core.unmap_memory = unmap_block;
        ash::Device::from_parts_1_3(
            vk::Device::from_raw(Arc::as_ptr(self).expose_provenance() as u64),
            core,
            ash::DeviceFnV1_1::load(|_| ptr::null()),
            ash::DeviceFnV1_2::load(|_| ptr::null()),
            ash::DeviceFnV1_3::load(|_| ptr::null()),
        )
    }

    /// Returns the source that a handle of [`BlockSource::as_device`] points to.
    ///
    /// # Safety
    /// The handle is of a source that lives as long as the reference.
    unsafe fn of<'a>(device: vk::Device) -> &'a Self {
        let source = ptr::with_exposed_provenance::<Self>(device.as_raw() as usize);
        // SAFETY: the caller's promise.
        unsafe { &*source }
    }
}

unsafe extern "system" fn allocate_block(
    device: vk::Device,
    info: *const vk::MemoryAllocateInfo<'_>,
    callbacks: *const vk::AllocationCallbacks<'_>,
    memory: *mut vk::DeviceMemory,
) -> vk::Result {
    // SAFETY: here and below: the allocator lives shorter than the source, and passes what it
    // would pass to the driver's function.
    let source = unsafe { BlockSource::of(device) };
    // SAFETY: as above.
    let is_over = unsafe { (*info).allocation_size } > source.left_bytes.load(Ordering::Relaxed);
    if is_over {
        *lock(&source.failure) = Some(BlockFailure::OverBudget);
        return vk::Result::ERROR_OUT_OF_DEVICE_MEMORY;
    }
    let real = source.device.fp_v1_0().allocate_memory;
    // SAFETY: as above.
    let code = unsafe { real(source.device.handle(), info, callbacks, memory) };
    if code == vk::Result::SUCCESS {
        // SAFETY: as above; the call has written the handle.
        unsafe { source.name(*memory, &*info) };
    }
    source.noted("vkAllocateMemory", code)
}

unsafe extern "system" fn free_block(
    device: vk::Device,
    memory: vk::DeviceMemory,
    callbacks: *const vk::AllocationCallbacks<'_>,
) {
    // SAFETY: as above.
    unsafe {
        let device = &BlockSource::of(device).device;
        (device.fp_v1_0().free_memory)(device.handle(), memory, callbacks);
    }
}

unsafe extern "system" fn map_block(
    device: vk::Device,
    memory: vk::DeviceMemory,
    offset: vk::DeviceSize,
    size: vk::DeviceSize,
    flags: vk::MemoryMapFlags,
    data: *mut *mut c_void,
) -> vk::Result {
    // SAFETY: as above.
    unsafe {
        let source = BlockSource::of(device);
        let real = source.device.fp_v1_0().map_memory;
        let code = real(source.device.handle(), memory, offset, size, flags, data);
        source.noted("vkMapMemory", code)
    }
}

unsafe extern "system" fn unmap_block(device: vk::Device, memory: vk::DeviceMemory) {
    // SAFETY: as above.
    unsafe {
        let device = &BlockSource::of(device).device;
        (device.fp_v1_0().unmap_memory)(device.handle(), memory);
    }
}
