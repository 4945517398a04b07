//! Images and buffers of a host in plain Vulkan.

use std::error::Error;

use ash::vk;

use crate::SIZE;
use crate::ash_device::AshDevice;

/// An image of one level, with its view.
pub struct AshImage {
    /// The image.
    pub raw: vk::Image,
    /// Its view.
    pub view: vk::ImageView,
    /// Its format.
    pub format: vk::Format,
    /// Its usage.
    pub usage: vk::ImageUsageFlags,
    memory: vk::DeviceMemory,
}

/// A buffer in memory that the CPU sees.
pub struct AshBuffer {
    /// The buffer.
    pub raw: vk::Buffer,
    memory: vk::DeviceMemory,
    size_bytes: u64,
}

impl AshImage {
    /// Creates an image of the size of the walk.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        host: &AshDevice,
        format: vk::Format,
        aspect: vk::ImageAspectFlags,
        usage: vk::ImageUsageFlags,
    ) -> Result<Self, Box<dyn Error>> {
        let [width, height] = SIZE;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        // SAFETY: plain objects of the host's own device, bound before the view is made.
        unsafe {
            let raw = host.raw.create_image(&info, None)?;
            let needs = host.raw.get_image_memory_requirements(raw);
            let memory = allocate(host, needs, vk::MemoryPropertyFlags::DEVICE_LOCAL)?;
            host.raw.bind_image_memory(raw, memory, 0)?;
            let view = vk::ImageViewCreateInfo::default()
                .image(raw)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(vk::ImageSubresourceRange {
                    aspect_mask: aspect,
                    level_count: 1,
                    layer_count: 1,
                    ..Default::default()
                });
            let view = host.raw.create_image_view(&view, None)?;
            Ok(Self { raw, view, format, usage, memory })
        }
    }

    /// Destroys it. The GPU is done with it.
    pub fn destroy(self, host: &AshDevice) {
        // SAFETY: made by this host, which says that it is no longer used.
        unsafe {
            host.raw.destroy_image_view(self.view, None);
            host.raw.destroy_image(self.raw, None);
            host.raw.free_memory(self.memory, None);
        }
    }
}

impl AshBuffer {
    /// Creates a buffer with these contents.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        host: &AshDevice,
        contents: &[u8],
        usage: vk::BufferUsageFlags,
    ) -> Result<Self, Box<dyn Error>> {
        use vk::MemoryPropertyFlags as P;
        let size_bytes = contents.len() as u64;
        let info = vk::BufferCreateInfo::default().size(size_bytes).usage(usage);
        // SAFETY: plain objects of the host's own device; nothing else has the memory mapped.
        unsafe {
            let raw = host.raw.create_buffer(&info, None)?;
            let needs = host.raw.get_buffer_memory_requirements(raw);
            let memory = allocate(host, needs, P::HOST_VISIBLE | P::HOST_COHERENT)?;
            host.raw.bind_buffer_memory(raw, memory, 0)?;
            let mapped = host.raw.map_memory(memory, 0, size_bytes, vk::MemoryMapFlags::empty())?;
            mapped.cast::<u8>().copy_from(contents.as_ptr(), contents.len());
            host.raw.unmap_memory(memory);
            Ok(Self { raw, memory, size_bytes })
        }
    }

    /// Returns the contents. The GPU is done writing them.
    ///
    /// # Errors
    /// A failed call.
    pub fn bytes(&self, host: &AshDevice) -> Result<Vec<u8>, vk::Result> {
        let mut bytes = vec![0; self.size_bytes as usize];
        let flags = vk::MemoryMapFlags::empty();
        // SAFETY: mapped, read, and unmapped again, while nobody writes.
        unsafe {
            let mapped = host.raw.map_memory(self.memory, 0, self.size_bytes, flags)?;
            bytes.as_mut_ptr().copy_from(mapped.cast(), bytes.len());
            host.raw.unmap_memory(self.memory);
        }
        Ok(bytes)
    }

    /// Destroys it. The GPU is done with it.
    pub fn destroy(self, host: &AshDevice) {
        // SAFETY: made by this host, which says that it is no longer used.
        unsafe {
            host.raw.destroy_buffer(self.raw, None);
            host.raw.free_memory(self.memory, None);
        }
    }
}

fn allocate(
    host: &AshDevice,
    needs: vk::MemoryRequirements,
    wanted: vk::MemoryPropertyFlags,
) -> Result<vk::DeviceMemory, Box<dyn Error>> {
    // SAFETY: the host's own physical device.
    let there = unsafe { host.instance.raw.get_physical_device_memory_properties(host.physical) };
    let fits = |(place, kind): &(usize, &vk::MemoryType)| {
        needs.memory_type_bits & 1 << place != 0 && kind.property_flags.contains(wanted)
    };
    let kinds = there.memory_types_as_slice().iter().enumerate();
    let (place, _) = kinds.into_iter().find(fits).ok_or("no memory of this kind")?;
    let info = vk::MemoryAllocateInfo::default()
        .allocation_size(needs.size)
        .memory_type_index(place as u32);
    // SAFETY: a memory type that fits.
    Ok(unsafe { host.raw.allocate_memory(&info, None) }?)
}
