//! The descriptor sets of a recording, from pools whose number grows as needed.

use ash::vk;

use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};

/// The number of descriptor sets in a pool; most frames bind a few per pass.
const DESCRIPTOR_SETS: u32 = 256;
/// The number of storage buffers in all sets of a pool.
const DESCRIPTORS: u32 = 1024;
/// The number of textures in all sets of a pool.
const TEXTURE_DESCRIPTORS: u32 = 1024;

/// The descriptor pools of a recording. A frame that needs more sets than a pool has gets another
/// pool, which is kept for later frames.
pub(crate) struct DescriptorPools {
    device: Device,
    name: String,
    pools: Vec<vk::DescriptorPool>,
    /// The index of the pool that sets are allocated from.
    current: usize,
    /// The number of sets allocated from this pool.
    sets: usize,
}

impl DescriptorPools {
    /// Creates the first pool.
    pub(crate) fn new(device: &Device, name: &str) -> Result<Self, Error> {
        let pools = vec![create_descriptor_pool(device, name)?];
        Ok(Self { device: device.clone(), name: name.to_owned(), pools, current: 0, sets: 0 })
    }

    /// Allocates a set that lives until the next [`DescriptorPools::reset`].
    pub(crate) fn allocate(
        &mut self,
        layout: vk::DescriptorSetLayout,
    ) -> Result<vk::DescriptorSet, Error> {
        loop {
            let code = match self.try_allocate(layout) {
                Ok(set) => {
                    self.sets += 1;
                    return Ok(set);
                }
                Err(code) => code,
            };
            let is_full = matches!(
                code,
                vk::Result::ERROR_OUT_OF_POOL_MEMORY | vk::Result::ERROR_FRAGMENTED_POOL
            );
            // If an empty pool has too little room, so has every pool.
            if !is_full || self.sets == 0 {
                return Err(code).called("vkAllocateDescriptorSets");
            }
            if self.current + 1 == self.pools.len() {
                let name = format!("{}, descriptors {}", self.name, self.pools.len());
                self.pools.push(create_descriptor_pool(&self.device, &name)?);
            }
            self.current += 1;
            self.sets = 0;
        }
    }

    fn try_allocate(
        &self,
        layout: vk::DescriptorSetLayout,
    ) -> Result<vk::DescriptorSet, vk::Result> {
        let layouts = [layout];
        let pool = self.pools.get(self.current).copied().unwrap_or_default();
        let info =
            vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        let raw = self.device.raw();
        let mut set = vk::DescriptorSet::null();
        // Calls the function directly, because ash would put the set on the heap.
        let allocate = raw.fp_v1_0().allocate_descriptor_sets;
        // SAFETY: the pool is alive, and the layout belongs to a live pipeline; there is room for
        // the one requested set.
        let code = unsafe { allocate(raw.handle(), &raw const info, &raw mut set) };
        if code == vk::Result::SUCCESS { Ok(set) } else { Err(code) }
    }

    /// Frees all sets. The tick of the commands that bind them must be over.
    pub(crate) fn reset(&mut self) -> Result<(), Error> {
        for pool in self.pools.iter().take(self.current + 1) {
            // SAFETY: nothing uses the sets any more.
            unsafe {
                let none = vk::DescriptorPoolResetFlags::empty();
                self.device.raw().reset_descriptor_pool(*pool, none)
            }
            .called("vkResetDescriptorPool")?;
        }
        self.current = 0;
        self.sets = 0;
        Ok(())
    }
}

impl Drop for DescriptorPools {
    fn drop(&mut self) {
        for pool in &self.pools {
            self.device.retire(Retired::DescriptorPool(*pool));
        }
    }
}

fn create_descriptor_pool(device: &Device, name: &str) -> Result<vk::DescriptorPool, Error> {
    let storage = vk::DescriptorPoolSize {
        ty: vk::DescriptorType::STORAGE_BUFFER,
        descriptor_count: DESCRIPTORS,
    };
    let textures = vk::DescriptorPoolSize {
        ty: vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
        descriptor_count: TEXTURE_DESCRIPTORS,
    };
    let sizes = [storage, textures];
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(DESCRIPTOR_SETS).pool_sizes(&sizes);
    // SAFETY: a plain descriptor pool.
    let pool = unsafe { device.raw().create_descriptor_pool(&info, device.callbacks()) }
        .called("vkCreateDescriptorPool")?;
    device.name(pool, name);
    Ok(pool)
}
