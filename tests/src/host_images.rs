//! The images, buffers and command buffers of a host, made by plain Vulkan.

use ash::vk;

use crate::host_device::Host;

/// An image with its view and memory. Destroyed by [`OwnImage::destroy`].
pub struct OwnImage {
    /// The image.
    pub image: vk::Image,
    /// A view of the whole image.
    pub view: vk::ImageView,
    /// The format.
    pub format: vk::Format,
    /// The usage that the image was created with.
    pub usage: vk::ImageUsageFlags,
    size: [u32; 2],
    memory: vk::DeviceMemory,
}

/// A buffer in memory that the CPU reads. Destroyed by [`OwnBuffer::destroy`].
pub struct OwnBuffer {
    /// The buffer.
    pub buffer: vk::Buffer,
    memory: vk::DeviceMemory,
    size_bytes: u64,
}

impl OwnImage {
    /// Creates an image of one level and layer.
    pub fn new(
        host: &Host,
        size: [u32; 2],
        format: vk::Format,
        samples: vk::SampleCountFlags,
        usage: vk::ImageUsageFlags,
    ) -> Self {
        let [width, height] = size;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(samples)
            .usage(usage);
        let aspect_mask = match format {
            vk::Format::D16_UNORM | vk::Format::X8_D24_UNORM_PACK32 | vk::Format::D32_SFLOAT => {
                vk::ImageAspectFlags::DEPTH
            }
            vk::Format::D24_UNORM_S8_UINT | vk::Format::D32_SFLOAT_S8_UINT => {
                vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL
            }
            _ => vk::ImageAspectFlags::COLOR,
        };
        let part = vk::ImageSubresourceRange {
            aspect_mask,
            level_count: 1,
            layer_count: 1,
            ..Default::default()
        };
        // SAFETY: plain objects of the host's own device, bound before the view is made.
        unsafe {
            let image = host.device.create_image(&info, None).unwrap();
            let needs = host.device.get_image_memory_requirements(image);
            let memory = allocate(host, needs, vk::MemoryPropertyFlags::empty());
            host.device.bind_image_memory(image, memory, 0).unwrap();
            let view = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(part);
            let view = host.device.create_image_view(&view, None).unwrap();
            Self { image, view, format, usage, size, memory }
        }
    }

    /// Records a copy of the image to `to`: from the layout of a transfer source, and back. With
    /// several samples per pixel, the mean is written to `resolved` first.
    pub fn record_copy(
        &self,
        host: &Host,
        commands: vk::CommandBuffer,
        resolved: Option<&Self>,
        to: &OwnBuffer,
    ) {
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            layer_count: 1,
            ..Default::default()
        };
        let [width, height] = self.size;
        let extent = vk::Extent3D { width, height, depth: 1 };
        let read = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        let written = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        let transfer = vk::PipelineStageFlags::TRANSFER;
        let none = vk::DependencyFlags::empty();
        use vk::AccessFlags as A;
        // SAFETY: the image is in the layout that the caller names, and has no other user.
        unsafe {
            let mut image = self.image;
            if let Some(resolved) = resolved {
                let transition = |old_layout, new_layout, before, after| {
                    let barrier = change(resolved.image, old_layout, new_layout, before, after);
                    let device = &host.device;
                    let all = [barrier];
                    device.cmd_pipeline_barrier(commands, transfer, transfer, none, &[], &[], &all);
                };
                let undefined = vk::ImageLayout::UNDEFINED;
                transition(undefined, written, A::TRANSFER_READ, A::TRANSFER_WRITE);
                let region = vk::ImageResolve::default()
                    .src_subresource(layers)
                    .dst_subresource(layers)
                    .extent(extent);
                let from = image;
                let to = resolved.image;
                host.device.cmd_resolve_image(commands, from, read, to, written, &[region]);
                transition(written, read, A::TRANSFER_WRITE, A::TRANSFER_READ);
                image = resolved.image;
            }
            let region =
                vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent);
            host.device.cmd_copy_image_to_buffer(commands, image, read, to.buffer, &[region]);
            let visible = vk::MemoryBarrier::default()
                .src_access_mask(A::TRANSFER_WRITE)
                .dst_access_mask(A::HOST_READ | A::TRANSFER_WRITE);
            let after = vk::PipelineStageFlags::HOST | transfer;
            host.device.cmd_pipeline_barrier(commands, transfer, after, none, &[visible], &[], &[]);
        }
    }

    /// Destroys the object. The GPU must not use it any more.
    pub fn destroy(self, host: &Host) {
        // SAFETY: created by this host, and no longer used, as the caller promises.
        unsafe {
            host.device.destroy_image_view(self.view, None);
            host.device.destroy_image(self.image, None);
            host.device.free_memory(self.memory, None);
        }
    }
}

impl OwnBuffer {
    /// Creates a buffer that images are copied to.
    pub fn new(host: &Host, size_bytes: u64) -> Self {
        Self::of(host, size_bytes, vk::BufferUsageFlags::TRANSFER_DST)
    }

    /// Creates a buffer with these bytes.
    pub fn filled(host: &Host, bytes: &[u8], usage: vk::BufferUsageFlags) -> Self {
        let new = Self::of(host, bytes.len() as u64, usage);
        let flags = vk::MemoryMapFlags::empty();
        // SAFETY: mapped, written, and unmapped again, before the first read.
        unsafe {
            let to = host.device.map_memory(new.memory, 0, new.size_bytes, flags).unwrap();
            to.cast::<u8>().copy_from_nonoverlapping(bytes.as_ptr(), bytes.len());
            host.device.unmap_memory(new.memory);
        }
        new
    }

    fn of(host: &Host, size_bytes: u64, usage: vk::BufferUsageFlags) -> Self {
        let info = vk::BufferCreateInfo::default().size(size_bytes).usage(usage);
        let mapped = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        // SAFETY: plain objects of the host's own device.
        unsafe {
            let buffer = host.device.create_buffer(&info, None).unwrap();
            let needs = host.device.get_buffer_memory_requirements(buffer);
            let memory = allocate(host, needs, mapped);
            host.device.bind_buffer_memory(buffer, memory, 0).unwrap();
            Self { buffer, memory, size_bytes }
        }
    }

    /// Returns the bytes. The GPU must not use the buffer any more.
    pub fn bytes(&self, host: &Host) -> Vec<u8> {
        let flags = vk::MemoryMapFlags::empty();
        // SAFETY: mapped, read, and unmapped again, without a write meanwhile.
        unsafe {
            let bytes = host.device.map_memory(self.memory, 0, self.size_bytes, flags).unwrap();
            let copy = std::slice::from_raw_parts(bytes.cast(), self.size_bytes as usize).to_vec();
            host.device.unmap_memory(self.memory);
            copy
        }
    }

    /// Destroys the object. The GPU must not use it any more.
    pub fn destroy(self, host: &Host) {
        // SAFETY: created by this host, and no longer used, as the caller promises.
        unsafe {
            host.device.destroy_buffer(self.buffer, None);
            host.device.free_memory(self.memory, None);
        }
    }
}

/// Returns a barrier for the whole of a colour image.
fn change(
    image: vk::Image,
    old: vk::ImageLayout,
    new: vk::ImageLayout,
    before: vk::AccessFlags,
    after: vk::AccessFlags,
) -> vk::ImageMemoryBarrier<'static> {
    vk::ImageMemoryBarrier::default()
        .image(image)
        .old_layout(old)
        .new_layout(new)
        .src_access_mask(before)
        .dst_access_mask(after)
        .subresource_range(vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            level_count: 1,
            layer_count: 1,
            ..Default::default()
        })
}

fn allocate(
    host: &Host,
    needs: vk::MemoryRequirements,
    wanted: vk::MemoryPropertyFlags,
) -> vk::DeviceMemory {
    // SAFETY: the host's own physical device.
    let there = unsafe { host.instance.get_physical_device_memory_properties(host.physical) };
    let kinds = (0..there.memory_type_count).find(|kind| {
        let flags = there.memory_types[*kind as usize].property_flags;
        needs.memory_type_bits & 1 << kind != 0 && flags.contains(wanted)
    });
    let info = vk::MemoryAllocateInfo::default()
        .allocation_size(needs.size)
        .memory_type_index(kinds.unwrap());
    // SAFETY: a memory type that fits.
    unsafe { host.device.allocate_memory(&info, None) }.unwrap()
}
