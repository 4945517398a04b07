//! Images: each has one view and its own memory.

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::memory::allocation::{allocate, allocate_lazily, free};
use crate::memory::device_memory::{MemoryOwner, MemoryRequest};
use crate::record::access::{Access, LayoutChange};

/// An image with a view of the whole image and its memory.
pub(crate) struct Image {
    device: Device,
    pub(crate) raw: vk::Image,
    pub(crate) view: vk::ImageView,
    allocation: Option<Allocation>,
}

/// The formats of an image.
#[derive(Clone, Copy)]
pub(crate) struct ImageFormats {
    /// The format of the memory.
    pub(crate) memory: vk::Format,
    /// The format of the view.
    pub(crate) view: vk::Format,
}

impl ImageFormats {
    /// Returns one format for memory and view.
    pub(crate) fn same(format: vk::Format) -> Self {
        Self { memory: format, view: format }
    }
}

impl Image {
    /// Creates an image; the size must be within the device's limits.
    pub(crate) fn new(
        device: &Device,
        name: &str,
        size: [u32; 2],
        formats: ImageFormats,
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> Result<Self, Error> {
        Self::layered(device, name, size, 1, formats, usage, aspect)
    }

    /// Creates an image with a number of layers, within the device's limits. The view is an array
    /// view if there are several layers.
    pub(crate) fn layered(
        device: &Device,
        name: &str,
        size: [u32; 2],
        layers: u32,
        formats: ImageFormats,
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> Result<Self, Error> {
        let ImageFormats { memory, view } = formats;
        let both = [memory, view];
        let mut list = vk::ImageFormatListCreateInfo::default().view_formats(&both);
        let mut info = plain_image(memory, size, 1, layers).usage(usage);
        if memory != view {
            info = info.flags(vk::ImageCreateFlags::MUTABLE_FORMAT).push_next(&mut list);
        }
        let mut view = plain_view(view, aspect, 1, layers);
        if layers > 1 {
            view = view.view_type(vk::ImageViewType::TYPE_2D_ARRAY);
        }
        Self::with_view(device, name, &info, view)
    }

    /// Creates an image of one layer with a number of samples per pixel that the device can draw
    /// to. A transient attachment takes memory only when it is stored, if the device has such
    /// memory (as tilers do).
    pub(crate) fn multisampled(
        device: &Device,
        name: &str,
        size: [u32; 2],
        samples: vk::SampleCountFlags,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> Result<Self, Error> {
        let info = plain_image(format, size, 1, 1).usage(usage).samples(samples);
        Self::with_view(device, name, &info, plain_view(format, aspect, 1, 1))
    }

    /// Creates a 2D array of colours with a number of levels and layers, all within the device's
    /// limits.
    pub(crate) fn array(
        device: &Device,
        name: &str,
        size: [u32; 2],
        levels: u32,
        layers: u32,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<Self, Error> {
        let info = plain_image(format, size, levels, layers).usage(usage);
        let view = plain_view(format, vk::ImageAspectFlags::COLOR, levels, layers)
            .view_type(vk::ImageViewType::TYPE_2D_ARRAY);
        Self::with_view(device, name, &info, view)
    }

    /// Creates a 2D array of depths, within the device's limits.
    pub(crate) fn depth_array(
        device: &Device,
        name: &str,
        size: [u32; 2],
        layers: u32,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<Self, Error> {
        let info = plain_image(format, size, 1, layers).usage(usage);
        let view = plain_view(format, vk::ImageAspectFlags::DEPTH, 1, layers)
            .view_type(vk::ImageViewType::TYPE_2D_ARRAY);
        Self::with_view(device, name, &info, view)
    }

    /// Creates an image of three dimensions, within the device's limits.
    pub(crate) fn volume(
        device: &Device,
        name: &str,
        size: [u32; 3],
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<Self, Error> {
        let [width, height, depth] = size;
        let info = plain_image(format, [width, height], 1, 1)
            .image_type(vk::ImageType::TYPE_3D)
            .extent(vk::Extent3D { width, height, depth })
            .usage(usage);
        let view = plain_view(format, vk::ImageAspectFlags::COLOR, 1, 1)
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
        let is_transient = info.usage.contains(vk::ImageUsageFlags::TRANSIENT_ATTACHMENT);
        let owner = MemoryOwner::Image(raw);
        let location = MemoryLocation::GpuOnly;
        let request = MemoryRequest { name, owner, requirements, location };
        let lazily = is_transient.then(|| allocate_lazily(device, &request));
        let memory = match lazily.flatten() {
            Some(memory) => Ok(memory),
            None => allocate(device, &request),
        };
        let made =
            memory.and_then(|memory| match bind_and_view(device, &memory, view.image(raw)) {
                Ok(view) => Ok((view, memory)),
                Err(error) => {
                    free(device, memory);
                    Err(error)
                }
            });
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
    size: [u32; 2],
    levels: u32,
    layers: u32,
) -> vk::ImageCreateInfo<'a> {
    let [width, height] = size;
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
    level_count: u32,
    layer_count: u32,
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
    memory: &Allocation,
    view: vk::ImageViewCreateInfo<'_>,
) -> Result<vk::ImageView, Error> {
    // SAFETY: fresh memory that fits the image's requirements; the view is created after binding.
    unsafe {
        device
            .raw()
            .bind_image_memory(view.image, memory.memory(), memory.offset())
            .called("vkBindImageMemory")?;
        device.raw().create_image_view(&view, device.callbacks()).called("vkCreateImageView")
    }
}

/// A view of the depths of an image with a stencil, for shaders that read depths.
pub(crate) struct DepthView {
    device: Device,
    pub(crate) raw: vk::ImageView,
}

impl DepthView {
    /// Creates a view of an image of `format`.
    pub(crate) fn new(
        device: &Device,
        image: vk::Image,
        format: vk::Format,
    ) -> Result<Self, Error> {
        let view = plain_view(format, vk::ImageAspectFlags::DEPTH, 1, 1).image(image);
        // SAFETY: a live image of this format, with depths.
        let raw = unsafe { device.raw().create_image_view(&view, device.callbacks()) }
            .called("vkCreateImageView")?;
        device.name(raw, "depths beside a stencil");
        Ok(Self { device: device.clone(), raw })
    }
}

impl Drop for DepthView {
    fn drop(&mut self) {
        self.device.retire(Retired::ImageView(self.raw));
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        if let Some(allocation) = self.allocation.take() {
            self.device.retire(Retired::Image(self.raw, self.view, allocation));
        }
    }
}
