//! Images: one level, one view, memory of their own.

use ash::vk;
use gpu_allocator::MemoryLocation;

use crate::access::{Access, LayoutChange};
use crate::buffer::{allocate, free};
use crate::deletion::Garbage;
use crate::device::Device;
use crate::error::{Called, Error};

/// An image of one level, its view and its memory.
pub(crate) struct Image {
    device: Device,
    pub(crate) raw: vk::Image,
    pub(crate) view: vk::ImageView,
    allocation: Option<gpu_allocator::vulkan::Allocation>,
}

impl Image {
    /// An image of this size. The formats are that of its memory and that of its view; the size is
    /// within the device's limits.
    pub(crate) fn new(
        device: &Device,
        name: &str,
        size: [u32; 2],
        [format, view_format]: [vk::Format; 2],
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> Result<Self, Error> {
        let formats = [format, view_format];
        let mut list = vk::ImageFormatListCreateInfo::default().view_formats(&formats);
        let mut info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width: size[0], height: size[1], depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        if format != view_format {
            info = info.flags(vk::ImageCreateFlags::MUTABLE_FORMAT).push_next(&mut list);
        }
        // SAFETY: the size is within the limits, checked by the caller.
        let raw = unsafe { device.raw().create_image(&info, None) }.called("vkCreateImage")?;
        device.name(raw, name);
        // SAFETY: just made.
        let requirements = unsafe { device.raw().get_image_memory_requirements(raw) };
        let made = allocate(device, name, requirements, MemoryLocation::GpuOnly, false).and_then(
            |memory| {
                let view = bind_and_view(device, raw, &memory, view_format, aspect);
                match view {
                    Ok(view) => Ok((view, memory)),
                    Err(error) => {
                        free(device, memory);
                        Err(error)
                    }
                }
            },
        );
        match made {
            Ok((view, memory)) => {
                device.name(view, name);
                Ok(Self { device: device.clone(), raw, view, allocation: Some(memory) })
            }
            Err(error) => {
                // SAFETY: never used.
                unsafe { device.raw().destroy_image(raw, None) };
                Err(error)
            }
        }
    }

    pub(crate) fn change(
        &self,
        aspect: vk::ImageAspectFlags,
        from: Access,
        to: Access,
    ) -> LayoutChange {
        LayoutChange::new(self.raw, aspect, from, to)
    }
}

fn bind_and_view(
    device: &Device,
    image: vk::Image,
    memory: &gpu_allocator::vulkan::Allocation,
    format: vk::Format,
    aspect: vk::ImageAspectFlags,
) -> Result<vk::ImageView, Error> {
    let info = vk::ImageViewCreateInfo::default()
        .image(image)
        .view_type(vk::ImageViewType::TYPE_2D)
        .format(format)
        .subresource_range(vk::ImageSubresourceRange {
            aspect_mask: aspect,
            level_count: 1,
            layer_count: 1,
            ..Default::default()
        });
    // SAFETY: fresh memory that fits the image's requirements; the view is made after binding.
    unsafe {
        device
            .raw()
            .bind_image_memory(image, memory.memory(), memory.offset())
            .called("vkBindImageMemory")?;
        device.raw().create_image_view(&info, None).called("vkCreateImageView")
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        if let Some(allocation) = self.allocation.take() {
            self.device.retire(Garbage::Image(self.raw, self.view, allocation));
        }
    }
}
