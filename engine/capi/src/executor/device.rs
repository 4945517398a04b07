//! The device of a host: its requirements and its adoption.

use std::ffi::{CStr, CString, c_char};

use gpu::ash;
use gpu::{
    Device, DeviceOptions, Entry, FeatureStructures, Features, HostDevice, Purpose,
    RequiredFeature, Requirements, vk,
};

use super::queue::{AntumbraQueueDesc, host_queue};
use crate::error::{AntumbraResult, Failure};
use crate::layout::{Versioned, layout, pointers, versioned};
use crate::pointers::{read, slice};
use crate::table::handle;

/// The type of `vkGetInstanceProcAddr`.
pub type AntumbraInstanceProcAddr =
    Option<unsafe extern "system" fn(vk::Instance, *const c_char) -> vk::PFN_vkVoidFunction>;

pointers!(AntumbraInstanceProcAddr);

/// A device of a host, which was adopted, or one that the library opened.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraDevice {
    /// The number of the handle; 0 for none.
    pub id: u64,
}
handle!(AntumbraDevice = "device");

/// A physical device of a host.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraAdapterDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The version of Vulkan in the `VkApplicationInfo` of the instance, at least 1.3. Default:
    /// `VK_API_VERSION_1_3`.
    pub api_version: u32,
    /// Required: `vkGetInstanceProcAddr`, through which the instance was made.
    pub instance_proc_addr: AntumbraInstanceProcAddr,
    /// Required: the instance.
    pub instance: vk::Instance,
    /// Required: the physical device.
    pub physical_device: vk::PhysicalDevice,
}
layout!(AntumbraAdapterDesc: struct_size, api_version, instance_proc_addr, instance,
    physical_device);

versioned!(AntumbraAdapterDesc: 5, required: [instance_proc_addr, instance, physical_device], defaults: {api_version: vk::API_VERSION_1_3});

/// The features of a device, in structs of the host. Null counts as a struct with all features off:
/// `antumbra_requirements` then turns none of them on, and `antumbra_device_adopt` refuses the
/// device if one of them is needed. Features that the host turned on by other structs, such as
/// `VkPhysicalDeviceDynamicRenderingFeatures`, are set in these structs for the adoption.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraFeatures {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// Must be 0.
    pub reserved: u32,
    /// The features of Vulkan 1.0, of which some are needed. Default: null.
    pub core: *mut vk::PhysicalDeviceFeatures,
    /// The features of Vulkan 1.2, with their `sType`; a renderer needs some. Default: null.
    pub vulkan_12: *mut vk::PhysicalDeviceVulkan12Features<'static>,
    /// The features of Vulkan 1.3, with their `sType`, of which some are needed. Default: null.
    pub vulkan_13: *mut vk::PhysicalDeviceVulkan13Features<'static>,
    /// The features of `VK_EXT_conditional_rendering`, with their `sType`. Never needed. Default:
    /// null.
    pub conditional_rendering: *mut vk::PhysicalDeviceConditionalRenderingFeaturesEXT<'static>,
}
layout!(AntumbraFeatures: struct_size, reserved, core, vulkan_12, vulkan_13,
    conditional_rendering);

versioned!(AntumbraFeatures: 6, required: [], defaults: {});

/// The largest number of extensions that the library requests.
pub const ANTUMBRA_EXTENSIONS_MAX: usize = 8;

/// The requirements of the library on a physical device, besides features.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraRequirements {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The lowest version of Vulkan for instance and device.
    pub api_version: u32,
    /// The flags of the queue family whose command buffers are recorded into, or that a renderer
    /// submits to.
    pub queue_flags: vk::QueueFlags,
    /// The first queue family with these flags; `UINT32_MAX` if there is none.
    pub queue_family: u32,
    /// The number of extensions to turn on, all of which the device has.
    pub extension_count: u32,
    /// Is 0.
    pub reserved: u32,
    /// The names of the extensions, valid as long as the library is loaded.
    pub extensions: [*const c_char; ANTUMBRA_EXTENSIONS_MAX],
}
layout!(AntumbraRequirements: struct_size, api_version, queue_flags, queue_family,
    extension_count, reserved, extensions);

versioned!(AntumbraRequirements: 7, required: [], defaults: {});

/// A device that a host created and still owns.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraDeviceDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The queue family of the command buffers that are recorded into, or of `queue`. Default: 0,
    /// the first one.
    pub queue_family: u32,
    /// Required: the physical device.
    pub adapter: *const AntumbraAdapterDesc,
    /// Required: the device.
    pub device: vk::Device,
    /// Required: the features that are on.
    pub features: *const AntumbraFeatures,
    /// The names of the extensions that are on, and `VK_EXT_debug_utils` if the instance has it:
    /// then all Vulkan objects get names for debuggers. Names that the library does not know are
    /// ignored. Default: null, with an `extension_count` of 0.
    pub extensions: *const *const c_char,
    /// The number of extensions. Default: 0.
    pub extension_count: usize,
    /// The callbacks for the host memory of Vulkan objects, called on any thread until the device
    /// and everything that was created on it are destroyed. Default: null, for none.
    pub allocation_callbacks: *const vk::AllocationCallbacks<'static>,
    /// The pipeline cache. Default: `VK_NULL_HANDLE`, for a cache of the library.
    pub pipeline_cache: vk::PipelineCache,
    /// The queue that a renderer submits to, of the family `queue_family`. Default: null, for a
    /// device on which scenes are recorded into command buffers of the host.
    pub queue: *const AntumbraQueueDesc,
    /// The most bytes of Vulkan memory that the library allocates on the device, in blocks that
    /// buffers and images share. What does not fit fails with `ANTUMBRA_RESULT_NO_MEMORY`. Default:
    /// 0, for no bound but that of the device.
    pub memory_budget_bytes: u64,
}
layout!(AntumbraDeviceDesc: struct_size, queue_family, adapter, device, features, extensions,
    extension_count, allocation_callbacks, pipeline_cache, queue, memory_budget_bytes);

versioned!(AntumbraDeviceDesc: 7, required: [adapter, device, features], defaults: {});

/// The instance of a host with its functions.
struct Adapter {
    entry: Entry,
    instance: ash::Instance,
    physical_device: vk::PhysicalDevice,
    api_version: u32,
}

impl Adapter {
    /// Loads the functions of an instance.
    ///
    /// # Safety
    /// The handles are valid, and the function belongs to their loader.
    unsafe fn load(desc: &AntumbraAdapterDesc) -> Result<Self, Failure> {
        let AntumbraAdapterDesc { api_version, instance, physical_device, .. } = *desc;
        let Some(get_instance_proc_addr) = desc.instance_proc_addr else {
            return Err(Failure::null("adapter.instance_proc_addr"));
        };
        if api_version < vk::API_VERSION_1_3 {
            let message = "adapter.api_version must be VK_API_VERSION_1_3 at least, as in the \
                           VkApplicationInfo of the instance";
            return Err(Failure::argument(message));
        }
        // SAFETY: the caller's promise.
        unsafe {
            let entry = Entry::from_static_fn(ash::StaticFn { get_instance_proc_addr });
            let instance = ash::Instance::load(entry.static_fn(), instance);
            Ok(Self { entry, instance, physical_device, api_version })
        }
    }
}

/// Returns the requirements of a part of the engine, and turns on the features that it needs or can
/// use.
///
/// # Safety
/// As the rules of the interface, for handles and structs of Vulkan, too.
pub(crate) unsafe fn require(
    adapter: &AntumbraAdapterDesc,
    features: &AntumbraFeatures,
    purpose: Purpose,
) -> Result<AntumbraRequirements, Failure> {
    // SAFETY: the caller's promise.
    let needs = unsafe {
        let adapter = Adapter::load(adapter)?;
        Requirements::of(&adapter.instance, adapter.physical_device, purpose)?
    };
    needs.check()?;
    let on = needs.features().structures();
    // SAFETY: the caller's promise.
    unsafe {
        turn_on(features.core, &raw const on.core)?;
        turn_on(features.vulkan_12, &raw const on.vulkan_12)?;
        turn_on(features.vulkan_13, &raw const on.vulkan_13)?;
        turn_on(features.conditional_rendering, &raw const on.conditional)?;
    }
    let names = needs.extensions();
    let mut extensions = [std::ptr::null(); ANTUMBRA_EXTENSIONS_MAX];
    for (place, name) in extensions.iter_mut().zip(&names) {
        *place = name.as_ptr();
    }
    Ok(AntumbraRequirements {
        api_version: needs.api_version,
        queue_flags: needs.queue_flags,
        queue_family: needs.queue_family.unwrap_or(u32::MAX),
        extension_count: names.len().min(ANTUMBRA_EXTENSIONS_MAX) as u32,
        extensions,
        ..AntumbraRequirements::INIT
    })
}

/// Adopts the device of a host.
///
/// # Safety
/// As [`gpu::Device::adopt`].
pub(crate) unsafe fn adopt(desc: &AntumbraDeviceDesc) -> Result<Device, Failure> {
    // SAFETY: the caller's promises, here and below.
    let (adapter, structs, names) = unsafe {
        let adapter = Adapter::load(&read("desc.adapter", desc.adapter)?)?;
        let structs = read("desc.features", desc.features)?;
        (adapter, structs, slice("desc.extensions", desc.extensions, desc.extension_count)?)
    };
    // SAFETY: as above.
    let features = unsafe { features_of(&structs) }?;
    let purpose = if desc.queue.is_null() { Purpose::Executor } else { Purpose::Renderer };
    check_structs(&structs, features, purpose)?;
    let mut extensions = Vec::with_capacity(names.len());
    for (number, name) in names.iter().enumerate() {
        if name.is_null() {
            return Err(Failure::null(format_args!("desc.extensions[{number}]")));
        }
        // SAFETY: as above.
        extensions.push(CString::from(unsafe { CStr::from_ptr(*name) }));
    }
    // SAFETY: as above.
    let queue = unsafe { host_queue(desc.queue) }?;
    let callbacks = desc.allocation_callbacks;
    let has_cache = desc.pipeline_cache != vk::PipelineCache::null();
    // SAFETY: as above.
    unsafe {
        Ok(Device::adopt(HostDevice {
            device: ash::Device::load(adapter.instance.fp_v1_0(), desc.device),
            entry: adapter.entry,
            instance: adapter.instance,
            physical_device: adapter.physical_device,
            queue_family: desc.queue_family,
            api_version: adapter.api_version,
            extensions,
            features,
            allocation_callbacks: (!callbacks.is_null()).then(|| *callbacks),
            pipeline_cache: has_cache.then_some(desc.pipeline_cache),
            queue,
            options: DeviceOptions {
                memory_budget_bytes: (desc.memory_budget_bytes > 0)
                    .then_some(desc.memory_budget_bytes),
                ..DeviceOptions::default()
            },
            owner: None,
        })?)
    }
}

/// Returns the features that are on in the structs of a host.
///
/// # Safety
/// The pointers are null, or point to structs of their types.
unsafe fn features_of(features: &AntumbraFeatures) -> Result<Features, Failure> {
    let mut on = FeatureStructures::default();
    // SAFETY: the caller's promise.
    unsafe {
        turn_on(&raw mut on.core, features.core)?;
        turn_on(&raw mut on.vulkan_12, features.vulkan_12)?;
        turn_on(&raw mut on.vulkan_13, features.vulkan_13)?;
        turn_on(&raw mut on.conditional, features.conditional_rendering)?;
    }
    Ok(Features::from(&on))
}

/// A pointer in [`AntumbraFeatures`].
struct FeaturePointer {
    field: &'static str,
    /// The type that it points to, by its name in C.
    struct_name: &'static str,
    is_null: fn(&AntumbraFeatures) -> bool,
    /// Copies the struct that it points to.
    copy: fn(&FeatureStructures, &mut FeatureStructures),
}

/// The pointers to structs that have required features.
const FEATURE_POINTERS: [FeaturePointer; 3] = [
    FeaturePointer {
        field: "core",
        struct_name: "VkPhysicalDeviceFeatures",
        is_null: |features| features.core.is_null(),
        copy: |from, to| to.core = from.core,
    },
    FeaturePointer {
        field: "vulkan_12",
        struct_name: "VkPhysicalDeviceVulkan12Features",
        is_null: |features| features.vulkan_12.is_null(),
        copy: |from, to| to.vulkan_12 = from.vulkan_12,
    },
    FeaturePointer {
        field: "vulkan_13",
        struct_name: "VkPhysicalDeviceVulkan13Features",
        is_null: |features| features.vulkan_13.is_null(),
        copy: |from, to| to.vulkan_13 = from.vulkan_13,
    },
];

/// Refuses a null pointer to a struct with required features. Without this check the host would
/// read that its device lacks them.
fn check_structs(
    features: &AntumbraFeatures,
    on: Features,
    purpose: Purpose,
) -> Result<(), Failure> {
    let required = RequiredFeature::ALL.into_iter().filter(|feature| feature.is_for(purpose));
    let required =
        required.map(RequiredFeature::features).fold(Features::default(), Features::union);
    let missing = required.without(on).structures();
    for pointer in FEATURE_POINTERS.iter().filter(|pointer| (pointer.is_null)(features)) {
        let mut of_pointer = FeatureStructures::default();
        (pointer.copy)(&missing, &mut of_pointer);
        let names: Vec<&str> = Features::from(&of_pointer).names().collect();
        if !names.is_empty() {
            let message = format_args!(
                "desc.features.{} is null, which counts as all features off, and {} must be on: \
                 pass the {} that the device was created with",
                pointer.field,
                names.join(", "),
                pointer.struct_name
            );
            return Err(Failure::new(AntumbraResult::BadPointer, message));
        }
    }
    Ok(())
}

/// A struct of features.
///
/// # Safety
/// Between the bytes `FIRST` and `END` there is nothing but `VkBool32`s; if `FIRST` is above 0, the
/// struct begins with an `sType`.
unsafe trait FeatureBits {
    const FIRST: usize;
    const END: usize;
}

/// Declares the features of a struct, up to its last one.
macro_rules! feature_bits {
    ($type:ty, $head:expr, $last:ident) => {
        // SAFETY: as the specification of Vulkan says. Padding may follow the last one.
        unsafe impl FeatureBits for $type {
            const FIRST: usize = $head;
            const END: usize = std::mem::offset_of!($type, $last) + size_of::<vk::Bool32>();
        }
    };
}
const CHAIN_HEAD: usize = size_of::<vk::BaseOutStructure<'_>>();
feature_bits!(vk::PhysicalDeviceFeatures, 0, inherited_queries);
feature_bits!(vk::PhysicalDeviceVulkan12Features<'_>, CHAIN_HEAD, subgroup_broadcast_dynamic_id);
feature_bits!(vk::PhysicalDeviceVulkan13Features<'_>, CHAIN_HEAD, maintenance4);
feature_bits!(
    vk::PhysicalDeviceConditionalRenderingFeaturesEXT<'_>,
    CHAIN_HEAD,
    inherited_conditional_rendering
);

/// Turns on the features in `target` that are on in `source`, unless a pointer is null.
///
/// # Safety
/// Each is null, or points to a struct that has no other user.
unsafe fn turn_on<T: FeatureBits>(target: *mut T, source: *const T) -> Result<(), Failure> {
    if target.is_null() || source.is_null() {
        return Ok(());
    }
    let type_of = |place: *const T| place.cast::<vk::StructureType>();
    // SAFETY: the caller's promise, and the promise of `FeatureBits`.
    unsafe {
        if T::FIRST > 0 && type_of(target).read() != type_of(source).read() {
            let [one, other] =
                [type_of(target), type_of(source)].map(|place| place.read().as_raw());
            return Err(Failure::argument(format_args!(
                "a struct of features has a wrong sType: {one} and {other} should be the same"
            )));
        }
        let bits = |place: *const T| place.cast::<vk::Bool32>();
        let word = size_of::<vk::Bool32>();
        for at in T::FIRST / word..T::END / word {
            if bits(source).add(at).read() == vk::TRUE {
                bits(target).cast_mut().add(at).write(vk::TRUE);
            }
        }
    }
    Ok(())
}
