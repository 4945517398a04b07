//! The Vulkan functions that a lying loader returns instead of the real ones.

use std::ffi::CStr;
use std::mem::transmute;

use ash::vk;
use gpu::RequiredFeature;

use super::attachments::calls_that_attach;
use super::barriers::calls_that_write;
use super::counted_calls::counted_calls;
use super::draw_calls::calls_that_draw;
use super::lies::lies;
use super::memory::calls_of_memory;
use super::representative::that_pretend;
use super::{Function, device_proc_addr, due, injected, portability, real};

/// The call that asks whether a device can show frames in a window. It is counted.
pub const CALL_THAT_ASKS_A_WINDOW: &CStr = c"vkGetPhysicalDeviceSurfaceSupportKHR";

/// The calls that reset queries on the CPU and by commands. They are counted.
pub const CALLS_THAT_RESET: [&CStr; 2] = [c"vkResetQueryPool", c"vkCmdResetQueryPool"];

/// Returns all replacements.
pub(super) fn replacements() -> Vec<(&'static CStr, Function)> {
    // SAFETY: all are function pointers, and the caller knows the type by the name.
    let that_lie = unsafe {
        [
            (
                c"vkAcquireNextImageKHR",
                transmute::<vk::PFN_vkAcquireNextImageKHR, Function>(acquire_image),
            ),
            (c"vkQueuePresentKHR", transmute::<vk::PFN_vkQueuePresentKHR, Function>(queue_present)),
            (
                c"vkGetPhysicalDeviceSurfaceCapabilitiesKHR",
                transmute::<vk::PFN_vkGetPhysicalDeviceSurfaceCapabilitiesKHR, Function>(
                    surface_state,
                ),
            ),
            (
                CALL_THAT_ASKS_A_WINDOW,
                transmute::<vk::PFN_vkGetPhysicalDeviceSurfaceSupportKHR, Function>(
                    surface_support,
                ),
            ),
            (
                c"vkGetDeviceProcAddr",
                transmute::<vk::PFN_vkGetDeviceProcAddr, Function>(device_proc_addr),
            ),
            (
                c"vkEnumerateInstanceVersion",
                transmute::<vk::PFN_vkEnumerateInstanceVersion, Function>(instance_version),
            ),
            (
                c"vkEnumeratePhysicalDevices",
                transmute::<vk::PFN_vkEnumeratePhysicalDevices, Function>(physical_devices),
            ),
            (
                c"vkGetPhysicalDeviceProperties",
                transmute::<vk::PFN_vkGetPhysicalDeviceProperties, Function>(properties),
            ),
            (
                c"vkGetPhysicalDeviceFeatures2",
                transmute::<vk::PFN_vkGetPhysicalDeviceFeatures2, Function>(features),
            ),
            (
                c"vkGetPhysicalDeviceQueueFamilyProperties",
                transmute::<vk::PFN_vkGetPhysicalDeviceQueueFamilyProperties, Function>(families),
            ),
            (
                c"vkGetPhysicalDeviceFormatProperties",
                transmute::<vk::PFN_vkGetPhysicalDeviceFormatProperties, Function>(format),
            ),
            (CALLS_THAT_RESET[0], transmute::<vk::PFN_vkResetQueryPool, Function>(reset_queries)),
            (
                CALLS_THAT_RESET[1],
                transmute::<vk::PFN_vkCmdResetQueryPool, Function>(command_to_reset_queries),
            ),
        ]
    };
    let counted = [counted_calls(), calls_that_draw(), calls_that_write()].concat();
    let instances = portability::calls_that_create_instances();
    let first = that_pretend()
        .into_iter()
        .chain(instances)
        .chain(calls_that_attach())
        .chain(calls_of_memory());
    first.chain(that_lie).chain(lies()).chain(counted).collect()
}

fn lacks(what: RequiredFeature) -> bool {
    injected(|injected| injected.lacks == Some(what))
}

unsafe extern "system" fn instance_version(version: *mut u32) -> vk::Result {
    // SAFETY: here and in all functions below: the type belongs to the function, and the caller
    // passes valid arguments for it, so all pointers are valid.
    unsafe {
        let code =
            real::<vk::PFN_vkEnumerateInstanceVersion>(c"vkEnumerateInstanceVersion")(version);
        *version = injected(|injected| injected.loader_version).unwrap_or(*version);
        code
    }
}

unsafe extern "system" fn physical_devices(
    instance: vk::Instance,
    count: *mut u32,
    devices: *mut vk::PhysicalDevice,
) -> vk::Result {
    if let Some(code) = due(c"vkEnumeratePhysicalDevices") {
        return code;
    }
    // SAFETY: as above.
    unsafe {
        if injected(|injected| injected.has_no_devices) || portability::is_hidden() {
            *count = 0;
            return vk::Result::SUCCESS;
        }
        let real = real::<vk::PFN_vkEnumeratePhysicalDevices>(c"vkEnumeratePhysicalDevices");
        real(instance, count, devices)
    }
}

unsafe extern "system" fn properties(
    physical: vk::PhysicalDevice,
    properties: *mut vk::PhysicalDeviceProperties,
) {
    // SAFETY: as above.
    unsafe {
        let name = c"vkGetPhysicalDeviceProperties";
        real::<vk::PFN_vkGetPhysicalDeviceProperties>(name)(physical, properties);
        if lacks(RequiredFeature::Vulkan13) {
            (*properties).api_version = vk::make_api_version(0, 1, 2, 200);
        }
        if lacks(RequiredFeature::StorageBuffers) {
            (*properties).limits.max_per_stage_descriptor_storage_buffers = 6;
        }
        if injected(|injected| injected.has_one_sample) {
            (*properties).limits.framebuffer_depth_sample_counts = vk::SampleCountFlags::TYPE_1;
        }
        if let Some(most) = injected(|injected| injected.most_draws) {
            (*properties).limits.max_draw_indirect_count = most;
        }
        if let Some(count) = injected(|injected| injected.stage_storage_buffers) {
            (*properties).limits.max_per_stage_descriptor_storage_buffers = count;
        }
    }
}

unsafe extern "system" fn features(
    physical: vk::PhysicalDevice,
    features: *mut vk::PhysicalDeviceFeatures2<'_>,
) {
    // SAFETY: as above; the first member of a structure in the chain names its type.
    unsafe {
        let name = c"vkGetPhysicalDeviceFeatures2";
        real::<vk::PFN_vkGetPhysicalDeviceFeatures2>(name)(physical, features);
        let core = &mut (*features).features;
        if lacks(RequiredFeature::MultiDrawIndirect) {
            core.multi_draw_indirect = vk::FALSE;
        }
        if lacks(RequiredFeature::DrawIndirectFirstInstance) {
            core.draw_indirect_first_instance = vk::FALSE;
        }
        if injected(|injected| injected.is_imprecise) {
            core.occlusion_query_precise = vk::FALSE;
        }
        if let Some(hide) = injected(|injected| injected.hides) {
            hide(core);
        }
        let mut next = (*features).p_next.cast::<vk::BaseOutStructure<'_>>();
        while let Some(structure) = next.as_mut() {
            match structure.s_type {
                vk::StructureType::PHYSICAL_DEVICE_CONDITIONAL_RENDERING_FEATURES_EXT => {
                    let conditional =
                        &mut *next.cast::<vk::PhysicalDeviceConditionalRenderingFeaturesEXT<'_>>();
                    if injected(|injected| injected.is_unconditional) {
                        conditional.conditional_rendering = vk::FALSE;
                    }
                }
                vk::StructureType::PHYSICAL_DEVICE_REPRESENTATIVE_FRAGMENT_TEST_FEATURES_NV => {
                    type Kind<'a> = vk::PhysicalDeviceRepresentativeFragmentTestFeaturesNV<'a>;
                    (*next.cast::<Kind<'_>>()).representative_fragment_test = vk::TRUE;
                }
                vk::StructureType::PHYSICAL_DEVICE_FAULT_FEATURES_EXT => {
                    let faults = &mut *next.cast::<vk::PhysicalDeviceFaultFeaturesEXT<'_>>();
                    faults.device_fault = vk::TRUE;
                }
                vk::StructureType::PHYSICAL_DEVICE_PORTABILITY_SUBSET_FEATURES_KHR => {
                    type Subset<'a> = vk::PhysicalDevicePortabilitySubsetFeaturesKHR<'a>;
                    portability::fill(&mut *next.cast::<Subset<'_>>());
                }
                vk::StructureType::PHYSICAL_DEVICE_SWAPCHAIN_MAINTENANCE_1_FEATURES_EXT => {
                    let fences =
                        &mut *next.cast::<vk::PhysicalDeviceSwapchainMaintenance1FeaturesEXT<'_>>();
                    if injected(|injected| injected.is_fenceless) {
                        fences.swapchain_maintenance1 = vk::FALSE;
                    }
                }
                vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_2_FEATURES => {
                    let more = &mut *next.cast::<vk::PhysicalDeviceVulkan12Features<'_>>();
                    if lacks(RequiredFeature::TimelineSemaphore) {
                        more.timeline_semaphore = vk::FALSE;
                    }
                    if injected(|injected| injected.resets_by_commands) {
                        more.host_query_reset = vk::FALSE;
                    }
                    if injected(|injected| injected.has_no_draw_counts) {
                        more.draw_indirect_count = vk::FALSE;
                    }
                    if injected(|injected| injected.has_no_indexing) {
                        more.shader_sampled_image_array_non_uniform_indexing = vk::FALSE;
                    }
                }
                vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_3_FEATURES => {
                    let more = &mut *next.cast::<vk::PhysicalDeviceVulkan13Features<'_>>();
                    if lacks(RequiredFeature::DynamicRendering) {
                        more.dynamic_rendering = vk::FALSE;
                    }
                    if lacks(RequiredFeature::Synchronization2) {
                        more.synchronization2 = vk::FALSE;
                    }
                }
                _ => {}
            }
            next = (*next).p_next;
        }
    }
}

unsafe extern "system" fn families(
    physical: vk::PhysicalDevice,
    count: *mut u32,
    families: *mut vk::QueueFamilyProperties,
) {
    // SAFETY: as above; the real function filled in `count` of them.
    unsafe {
        let name = c"vkGetPhysicalDeviceQueueFamilyProperties";
        real::<vk::PFN_vkGetPhysicalDeviceQueueFamilyProperties>(name)(physical, count, families);
        if lacks(RequiredFeature::GraphicsQueue) && !families.is_null() {
            for family in std::slice::from_raw_parts_mut(families, *count as usize) {
                family.queue_flags &= !vk::QueueFlags::GRAPHICS;
            }
        }
    }
}

unsafe extern "system" fn format(
    physical: vk::PhysicalDevice,
    format: vk::Format,
    properties: *mut vk::FormatProperties,
) {
    // SAFETY: as above.
    unsafe {
        let name = c"vkGetPhysicalDeviceFormatProperties";
        real::<vk::PFN_vkGetPhysicalDeviceFormatProperties>(name)(physical, format, properties);
        if lacks(RequiredFeature::Depth32) && format == vk::Format::D32_SFLOAT {
            (*properties).optimal_tiling_features = vk::FormatFeatureFlags::empty();
        }
    }
}

unsafe extern "system" fn reset_queries(
    device: vk::Device,
    pool: vk::QueryPool,
    first: u32,
    count: u32,
) {
    due(CALLS_THAT_RESET[0]);
    // SAFETY: as above.
    unsafe { real::<vk::PFN_vkResetQueryPool>(CALLS_THAT_RESET[0])(device, pool, first, count) }
}

unsafe extern "system" fn command_to_reset_queries(
    commands: vk::CommandBuffer,
    pool: vk::QueryPool,
    first: u32,
    count: u32,
) {
    due(CALLS_THAT_RESET[1]);
    // SAFETY: as above.
    unsafe {
        real::<vk::PFN_vkCmdResetQueryPool>(CALLS_THAT_RESET[1])(commands, pool, first, count)
    }
}

unsafe extern "system" fn acquire_image(
    device: vk::Device,
    swapchain: vk::SwapchainKHR,
    bound_ns: u64,
    semaphore: vk::Semaphore,
    fence: vk::Fence,
    index: *mut u32,
) -> vk::Result {
    let name = c"vkAcquireNextImageKHR";
    match due(name) {
        Some(code) if code != vk::Result::SUBOPTIMAL_KHR => code,
        // SAFETY: as above.
        due => unsafe {
            let real = real::<vk::PFN_vkAcquireNextImageKHR>(name);
            let code = real(device, swapchain, bound_ns, semaphore, fence, index);
            if code == vk::Result::SUCCESS { due.unwrap_or(code) } else { code }
        },
    }
}

unsafe extern "system" fn queue_present(
    queue: vk::Queue,
    info: *const vk::PresentInfoKHR<'_>,
) -> vk::Result {
    let name = c"vkQueuePresentKHR";
    let is_done_all_the_same = |code: &vk::Result| {
        [
            vk::Result::SUBOPTIMAL_KHR,
            vk::Result::ERROR_OUT_OF_DATE_KHR,
            vk::Result::ERROR_SURFACE_LOST_KHR,
        ]
        .contains(code)
    };
    match due(name) {
        Some(code) if !is_done_all_the_same(&code) => code,
        // SAFETY: as above.
        due => unsafe {
            let code = real::<vk::PFN_vkQueuePresentKHR>(name)(queue, info);
            due.unwrap_or(code)
        },
    }
}

unsafe extern "system" fn surface_state(
    physical: vk::PhysicalDevice,
    surface: vk::SurfaceKHR,
    state: *mut vk::SurfaceCapabilitiesKHR,
) -> vk::Result {
    let name = c"vkGetPhysicalDeviceSurfaceCapabilitiesKHR";
    if let Some(code) = due(name) {
        return code;
    }
    // SAFETY: as above.
    unsafe {
        let real = real::<vk::PFN_vkGetPhysicalDeviceSurfaceCapabilitiesKHR>(name);
        let code = real(physical, surface, state);
        if injected(|injected| injected.is_minimised) {
            (*state).current_extent = vk::Extent2D::default();
        }
        code
    }
}

unsafe extern "system" fn surface_support(
    physical: vk::PhysicalDevice,
    family: u32,
    surface: vk::SurfaceKHR,
    presents: *mut vk::Bool32,
) -> vk::Result {
    let name = CALL_THAT_ASKS_A_WINDOW;
    if let Some(code) = due(name) {
        return code;
    }
    // SAFETY: as above.
    unsafe {
        let real = real::<vk::PFN_vkGetPhysicalDeviceSurfaceSupportKHR>(name);
        let code = real(physical, family, surface, presents);
        if injected(|injected| injected.is_blind) {
            *presents = vk::FALSE;
        }
        code
    }
}
