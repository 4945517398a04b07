//! Images: one view, memory of their own.

use ash::vk;
use gpu_allocator::MemoryLocation;

use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::memory::buffer::{allocate, free};
use crate::record::access::{Access, LayoutChange};

/// An image, its view of all of it, and its memory.
pub(crate) struct Image {
    device: Device,
    pub(crate) raw: vk::Image,
    pub(crate) view: vk::ImageView,
    allocation: Option<gpu_allocator::vulkan::Allocation>,
}

impl Image {
    /// Creates an image of this size. The first format is for its memory and the second for its
    /// view; the size is within the device's limits.
    pub(crate) fn new(
        device: &Device,
        name: &str,
        size: [u32; 2],
        formats: [vk::Format; 2],
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> Result<Self, Error> {
        Self::layered(device, name, (size, 1), formats, usage, aspect)
    }

    /// Creates the same with so many layers, within the device's limits. The view is that of an
    /// array if they are more than one.
    pub(crate) fn layered(
        device: &Device,
        name: &str,
        (size, layers): ([u32; 2], u32),
        [format, view_format]: [vk::Format; 2],
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> Result<Self, Error> {
        let formats = [format, view_format];
        let mut list = vk::ImageFormatListCreateInfo::default().view_formats(&formats);
        let mut info = plain_image(format, size, [1, layers]).usage(usage);
        if format != view_format {
            info = info.flags(vk::ImageCreateFlags::MUTABLE_FORMAT).push_next(&mut list);
        }
        let mut view = plain_view(view_format, aspect, [1, layers]);
        if layers > 1 {
            view = view.view_type(vk::ImageViewType::TYPE_2D_ARRAY);
        }
        Self::with_view(device, name, &info, view)
    }

    /// Creates an image of one layer with so many samples per pixel, which the device draws to.
    pub(crate) fn multisampled(
        device: &Device,
        name: &str,
        (size, samples): ([u32; 2], vk::SampleCountFlags),
        format: vk::Format,
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> Result<Self, Error> {
        let info = plain_image(format, size, [1, 1]).usage(usage).samples(samples);
        Self::with_view(device, name, &info, plain_view(format, aspect, [1, 1]))
    }

    /// Creates a 2D array of colours with so many levels and layers, all within the device's
    /// limits.
    pub(crate) fn array(
        device: &Device,
        name: &str,
        size: [u32; 2],
        levels_and_layers: [u32; 2],
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<Self, Error> {
        let info = plain_image(format, size, levels_and_layers).usage(usage);
        let view = plain_view(format, vk::ImageAspectFlags::COLOR, levels_and_layers)
            .view_type(vk::ImageViewType::TYPE_2D_ARRAY);
        Self::with_view(device, name, &info, view)
    }

    /// Creates a 2D array of depths, within the device's limits.
    pub(crate) fn depth_array(
        device: &Device,
        name: &str,
        (size, layers): ([u32; 2], u32),
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<Self, Error> {
        let info = plain_image(format, size, [1, layers]).usage(usage);
        let view = plain_view(format, vk::ImageAspectFlags::DEPTH, [1, layers])
            .view_type(vk::ImageViewType::TYPE_2D_ARRAY);
        Self::with_view(device, name, &info, view)
    }

    /// Creates an image of three dimensions, within the device's limits.
    pub(crate) fn volume(
        device: &Device,
        name: &str,
        [width, height, depth]: [u32; 3],
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<Self, Error> {
        let info = plain_image(format, [width, height], [1, 1])
            .image_type(vk::ImageType::TYPE_3D)
            .extent(vk::Extent3D { width, height, depth })
            .usage(usage);
        let view = plain_view(format, vk::ImageAspectFlags::COLOR, [1, 1])
            .view_type(vk::ImageViewType::TYPE_3D);
        Self::with_view(device, name, &info, view)
    }

    fn with_view(
        device: &Device,
        name: &str,
        info: &vk::ImageCreateInfo<'_>,
        view: vk::ImageViewCreateInfo<'_>,
    ) -> Result<Self, Error> {
        // SAFETY: the size is within the limits, checked by the caller.
        let raw = unsafe { device.raw().create_image(info, device.callbacks()) }
            .called("vkCreateImage")?;
        device.name(raw, name);
        // SAFETY: just made.
        let requirements = unsafe { device.raw().get_image_memory_requirements(raw) };
        let made = allocate(device, name, requirements, MemoryLocation::GpuOnly, false).and_then(
            |memory| match bind_and_view(device, &memory, view.image(raw)) {
                Ok(view) => Ok((view, memory)),
                Err(error) => {
                    free(device, memory);
                    Err(error)
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
                unsafe { device.raw().destroy_image(raw, device.callbacks()) };
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

fn plain_image<'a>(
    format: vk::Format,
    [width, height]: [u32; 2],
    [levels, layers]: [u32; 2],
) -> vk::ImageCreateInfo<'a> {
    vk::ImageCreateInfo::default()
        .image_type(vk::ImageType::TYPE_2D)
        .format(format)
        .extent(vk::Extent3D { width, height, depth: 1 })
        .mip_levels(levels)
        .array_layers(layers)
        .samples(vk::SampleCountFlags::TYPE_1)
}

fn plain_view<'a>(
    format: vk::Format,
    aspect_mask: vk::ImageAspectFlags,
    [level_count, layer_count]: [u32; 2],
) -> vk::ImageViewCreateInfo<'a> {
    let whole =
        vk::ImageSubresourceRange { aspect_mask, level_count, layer_count, ..Default::default() };
    vk::ImageViewCreateInfo::default()
        .view_type(vk::ImageViewType::TYPE_2D)
        .format(format)
        .subresource_range(whole)
}

fn bind_and_view(
    device: &Device,
    memory: &gpu_allocator::vulkan::Allocation,
    view: vk::ImageViewCreateInfo<'_>,
) -> Result<vk::ImageView, Error> {
    // SAFETY: fresh memory that fits the image's requirements; the view is made after binding.
    unsafe {
        device
            .raw()
            .bind_image_memory(view.image, memory.memory(), memory.offset())
            .called("vkBindImageMemory")?;
        device.raw().create_image_view(&view, device.callbacks()).called("vkCreateImageView")
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        if let Some(allocation) = self.allocation.take() {
            self.device.retire(Retired::Image(self.raw, self.view, allocation));
        }
    }
}
