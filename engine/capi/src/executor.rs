//! The executor in a host's command buffer: the host keeps its device, queue, images, pipelines and
//! draws.

pub mod device;
pub mod device_costs;
pub mod device_open;
pub mod frame;
pub mod lists;
#[cfg(feature = "loaded")]
pub(crate) mod own_device;
pub mod queue;
pub mod quirks;
pub mod scene;
pub mod target;

use gpu::vk;

use crate::layout::{numbers, pointers};

pointers!(
    vk::Buffer,
    vk::CommandBuffer,
    vk::Device,
    vk::Image,
    vk::ImageView,
    vk::Instance,
    vk::PhysicalDevice,
    vk::PipelineCache,
    vk::Queue,
    vk::RenderPass,
    vk::Semaphore
);
numbers!(
    vk::AccessFlags2,
    vk::Format,
    vk::ImageLayout,
    vk::ImageUsageFlags,
    vk::PipelineStageFlags2,
    vk::QueueFlags,
    vk::SampleCountFlags
);
