//! A descriptor set with one texture, for pipelines of a host.

use ash::vk;

use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::ownership::of_device;
use crate::memory::dynamic_texture::DynamicTexture;

/// A set with one combined image and sampler at binding 0, for fragment shaders. A host binds it in
/// its own commands for pipelines whose layout has such a set.
///
/// The set refers to the texture, whose contents may change. Both may be dropped while a frame uses
/// them.
pub struct TextureSet {
    device: Device,
    layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    raw: vk::DescriptorSet,
}

of_device!(TextureSet: "a descriptor set (`TextureSet`)");

impl TextureSet {
    /// Creates the set for `texture`.
    ///
    /// # Errors
    /// A texture of another device; no memory, or a failed call.
    pub fn new(device: &Device, texture: &DynamicTexture, name: &str) -> Result<Self, Error> {
        device.check(texture, "a descriptor set (`TextureSet`)")?;
        let kind = vk::DescriptorType::COMBINED_IMAGE_SAMPLER;
        let bindings = [vk::DescriptorSetLayoutBinding::default()
            .descriptor_type(kind)
            .descriptor_count(1)
            .stage_flags(vk::ShaderStageFlags::FRAGMENT)];
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: a plain layout.
        let layout =
            unsafe { device.raw().create_descriptor_set_layout(&info, device.callbacks()) }
                .called("vkCreateDescriptorSetLayout")?;
        device.name(layout, name);
        let sizes = [vk::DescriptorPoolSize { ty: kind, descriptor_count: 1 }];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: a plain pool.
        let pool = unsafe { device.raw().create_descriptor_pool(&info, device.callbacks()) }
            .called("vkCreateDescriptorPool")
            .inspect_err(|_| device.retire(Retired::SetLayout(layout)))?;
        device.name(pool, name);
        // From here on, dropping the set frees both.
        let mut set = Self { device: device.clone(), layout, pool, raw: vk::DescriptorSet::null() };
        let layouts = [layout];
        let info =
            vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: the pool has room for one set of this layout.
        let sets = unsafe { device.raw().allocate_descriptor_sets(&info) }
            .called("vkAllocateDescriptorSets")?;
        set.raw = sets.first().copied().unwrap_or_default();
        device.name(set.raw, name);
        let images = [texture.sampled().descriptor];
        let writes = [vk::WriteDescriptorSet::default()
            .dst_set(set.raw)
            .descriptor_type(kind)
            .image_info(&images)];
        // SAFETY: no commands use the set yet; the image and the sampler are alive.
        unsafe { device.raw().update_descriptor_sets(&writes, &[]) };
        Ok(set)
    }

    /// Returns the descriptor set.
    pub fn raw(&self) -> vk::DescriptorSet {
        self.raw
    }
}

impl Drop for TextureSet {
    fn drop(&mut self) {
        self.device.retire(Retired::DescriptorPool(self.pool));
        self.device.retire(Retired::SetLayout(self.layout));
    }
}
