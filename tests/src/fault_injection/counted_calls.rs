//! The functions that only count their calls and fail if they must.

use std::ffi::{CStr, c_void};
use std::mem::transmute;

use ash::vk;

use super::{Function, due, real};

/// Defines functions that count their calls, fail if they must, and otherwise call the real ones.
macro_rules! counted {
    ($list:ident $functions:ident {
        $($ours:ident $pfn:ident $name:literal ($($argument:ident: $kind:ty),+);)+
    }) => {
        $(
            unsafe extern "system" fn $ours($($argument: $kind),+) -> vk::Result {
                match due($name) {
                    Some(code) => code,
                    // SAFETY: the type belongs to the function; the caller passes valid arguments.
                    None => unsafe { real::<vk::$pfn>($name)($($argument),+) },
                }
            }
        )+

        /// The names of these calls.
        pub const $list: &[&CStr] = &[$($name),+];

        fn $functions() -> Vec<(&'static CStr, Function)> {
            // SAFETY: all are function pointers, and the caller knows the type by the name.
            unsafe { vec![$(($name, transmute::<vk::$pfn, Function>($ours))),+] }
        }
    };
}

type Callbacks<'a> = *const vk::AllocationCallbacks<'a>;

counted! { CALLS_THAT_MAKE calls_that_make {
    allocate_memory PFN_vkAllocateMemory c"vkAllocateMemory" (
        device: vk::Device, info: *const vk::MemoryAllocateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::DeviceMemory);
    map_memory PFN_vkMapMemory c"vkMapMemory" (
        device: vk::Device, memory: vk::DeviceMemory, offset: vk::DeviceSize, size: vk::DeviceSize,
        flags: vk::MemoryMapFlags, data: *mut *mut c_void);
    create_buffer PFN_vkCreateBuffer c"vkCreateBuffer" (
        device: vk::Device, info: *const vk::BufferCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::Buffer);
    bind_buffer_memory PFN_vkBindBufferMemory c"vkBindBufferMemory" (
        device: vk::Device, buffer: vk::Buffer, memory: vk::DeviceMemory, offset: vk::DeviceSize);
    create_image PFN_vkCreateImage c"vkCreateImage" (
        device: vk::Device, info: *const vk::ImageCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::Image);
    bind_image_memory PFN_vkBindImageMemory c"vkBindImageMemory" (
        device: vk::Device, image: vk::Image, memory: vk::DeviceMemory, offset: vk::DeviceSize);
    create_image_view PFN_vkCreateImageView c"vkCreateImageView" (
        device: vk::Device, info: *const vk::ImageViewCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::ImageView);
    create_semaphore PFN_vkCreateSemaphore c"vkCreateSemaphore" (
        device: vk::Device, info: *const vk::SemaphoreCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::Semaphore);
    create_query_pool PFN_vkCreateQueryPool c"vkCreateQueryPool" (
        device: vk::Device, info: *const vk::QueryPoolCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::QueryPool);
    create_command_pool PFN_vkCreateCommandPool c"vkCreateCommandPool" (
        device: vk::Device, info: *const vk::CommandPoolCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::CommandPool);
    allocate_command_buffers PFN_vkAllocateCommandBuffers c"vkAllocateCommandBuffers" (
        device: vk::Device, info: *const vk::CommandBufferAllocateInfo<'_>,
        made: *mut vk::CommandBuffer);
    begin_command_buffer PFN_vkBeginCommandBuffer c"vkBeginCommandBuffer" (
        commands: vk::CommandBuffer, info: *const vk::CommandBufferBeginInfo<'_>);
    end_command_buffer PFN_vkEndCommandBuffer c"vkEndCommandBuffer" (commands: vk::CommandBuffer);
    reset_command_pool PFN_vkResetCommandPool c"vkResetCommandPool" (
        device: vk::Device, pool: vk::CommandPool, flags: vk::CommandPoolResetFlags);
    create_set_layout PFN_vkCreateDescriptorSetLayout c"vkCreateDescriptorSetLayout" (
        device: vk::Device, info: *const vk::DescriptorSetLayoutCreateInfo<'_>,
        callbacks: Callbacks<'_>, made: *mut vk::DescriptorSetLayout);
    create_pipeline_layout PFN_vkCreatePipelineLayout c"vkCreatePipelineLayout" (
        device: vk::Device, info: *const vk::PipelineLayoutCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::PipelineLayout);
    create_descriptor_pool PFN_vkCreateDescriptorPool c"vkCreateDescriptorPool" (
        device: vk::Device, info: *const vk::DescriptorPoolCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::DescriptorPool);
    allocate_descriptor_sets PFN_vkAllocateDescriptorSets c"vkAllocateDescriptorSets" (
        device: vk::Device, info: *const vk::DescriptorSetAllocateInfo<'_>,
        made: *mut vk::DescriptorSet);
    create_shader_module PFN_vkCreateShaderModule c"vkCreateShaderModule" (
        device: vk::Device, info: *const vk::ShaderModuleCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::ShaderModule);
    create_pipeline_cache PFN_vkCreatePipelineCache c"vkCreatePipelineCache" (
        device: vk::Device, info: *const vk::PipelineCacheCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::PipelineCache);
    create_graphics_pipelines PFN_vkCreateGraphicsPipelines c"vkCreateGraphicsPipelines" (
        device: vk::Device, cache: vk::PipelineCache, count: u32,
        infos: *const vk::GraphicsPipelineCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::Pipeline);
    create_compute_pipelines PFN_vkCreateComputePipelines c"vkCreateComputePipelines" (
        device: vk::Device, cache: vk::PipelineCache, count: u32,
        infos: *const vk::ComputePipelineCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::Pipeline);
    create_device PFN_vkCreateDevice c"vkCreateDevice" (
        physical: vk::PhysicalDevice, info: *const vk::DeviceCreateInfo<'_>,
        callbacks: Callbacks<'_>, made: *mut vk::Device);
}}

counted! { CALLS_THAT_RUN calls_that_run {
    queue_submit PFN_vkQueueSubmit2 c"vkQueueSubmit2" (
        queue: vk::Queue, count: u32, infos: *const vk::SubmitInfo2<'_>, fence: vk::Fence);
    wait_semaphores PFN_vkWaitSemaphores c"vkWaitSemaphores" (
        device: vk::Device, info: *const vk::SemaphoreWaitInfo<'_>, bound_ns: u64);
    semaphore_value PFN_vkGetSemaphoreCounterValue c"vkGetSemaphoreCounterValue" (
        device: vk::Device, semaphore: vk::Semaphore, value: *mut u64);
    device_wait_idle PFN_vkDeviceWaitIdle c"vkDeviceWaitIdle" (device: vk::Device);
}}

counted! { CALLS_THAT_SHOW calls_that_show {
    create_swapchain PFN_vkCreateSwapchainKHR c"vkCreateSwapchainKHR" (
        device: vk::Device, info: *const vk::SwapchainCreateInfoKHR<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::SwapchainKHR);
    swapchain_images PFN_vkGetSwapchainImagesKHR c"vkGetSwapchainImagesKHR" (
        device: vk::Device, swapchain: vk::SwapchainKHR, count: *mut u32, images: *mut vk::Image);
    surface_formats PFN_vkGetPhysicalDeviceSurfaceFormatsKHR
        c"vkGetPhysicalDeviceSurfaceFormatsKHR" (
        physical: vk::PhysicalDevice, surface: vk::SurfaceKHR, count: *mut u32,
        formats: *mut vk::SurfaceFormatKHR);
    surface_modes PFN_vkGetPhysicalDeviceSurfacePresentModesKHR
        c"vkGetPhysicalDeviceSurfacePresentModesKHR" (
        physical: vk::PhysicalDevice, surface: vk::SurfaceKHR, count: *mut u32,
        modes: *mut vk::PresentModeKHR);
    create_fence PFN_vkCreateFence c"vkCreateFence" (
        device: vk::Device, info: *const vk::FenceCreateInfo<'_>, callbacks: Callbacks<'_>,
        made: *mut vk::Fence);
}}

counted! { CALLS_THAT_WAIT_FOR_PRESENTS calls_that_wait_for_presents {
    wait_for_fences PFN_vkWaitForFences c"vkWaitForFences" (
        device: vk::Device, count: u32, fences: *const vk::Fence, all: vk::Bool32, bound_ns: u64);
    fence_status PFN_vkGetFenceStatus c"vkGetFenceStatus" (device: vk::Device, fence: vk::Fence);
}}

counted! { CALLS_THAT_SAVE calls_that_save {
    pipeline_cache_data PFN_vkGetPipelineCacheData c"vkGetPipelineCacheData" (
        device: vk::Device, cache: vk::PipelineCache, size: *mut usize, data: *mut c_void);
}}

counted! { CALLS_THAT_START calls_that_start {
    create_instance PFN_vkCreateInstance c"vkCreateInstance" (
        info: *const vk::InstanceCreateInfo<'_>, callbacks: Callbacks<'_>, made: *mut vk::Instance);
    create_messenger PFN_vkCreateDebugUtilsMessengerEXT c"vkCreateDebugUtilsMessengerEXT" (
        instance: vk::Instance, info: *const vk::DebugUtilsMessengerCreateInfoEXT<'_>,
        callbacks: Callbacks<'_>, made: *mut vk::DebugUtilsMessengerEXT);
}}

counted! { CALLS_THAT_OPEN_WINDOWS calls_that_open_windows {
    create_xcb_surface PFN_vkCreateXcbSurfaceKHR c"vkCreateXcbSurfaceKHR" (
        instance: vk::Instance, info: *const vk::XcbSurfaceCreateInfoKHR<'_>,
        callbacks: Callbacks<'_>, made: *mut vk::SurfaceKHR);
}}

/// Returns the replacements of all these functions.
pub(super) fn counted_calls() -> Vec<(&'static CStr, Function)> {
    [
        calls_that_make(),
        calls_that_run(),
        calls_that_show(),
        calls_that_wait_for_presents(),
        calls_that_save(),
        calls_that_start(),
        calls_that_open_windows(),
    ]
    .concat()
}
