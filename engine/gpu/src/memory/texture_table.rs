//! Tables of textures that shaders access by index.
//!
//! A table is one descriptor set with a long array. Textures are added while frames are in flight
//! and while others are recorded. This only writes descriptors that no command uses, as bindings
//! with `UPDATE_AFTER_BIND`, `UPDATE_UNUSED_WHILE_PENDING` and `PARTIALLY_BOUND` allow
//! (VUID-vkUpdateDescriptorSets-None-03047). So an index is reused only when all frames that may
//! use it are over. Elements without a texture have a white texel: SwiftShader reads all elements
//! in each draw, and would follow pointers to destroyed images.

use std::fmt;
use std::sync::{Arc, Mutex};

use ash::vk;

use crate::core::capabilities::OptionalFeature;
use crate::core::deletion::{Retired, RetiredObject};
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::ownership::of_device;
use crate::core::queue_lock::lock;
use crate::memory::texture_array::{MipGeneration, TextureArray, TextureArrayInfo};
use crate::memory::texture_sampler::{SamplerKind, TextureSampler};
use crate::memory::texture_uploads::TextureUploads;

/// The index of a texture in its table, by which shaders access it: the array element at binding 0
/// of set 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TextureNumber(pub u32);

/// Textures that fragment shaders access by index, for devices with
/// [`OptionalFeature::DescriptorIndexing`].
pub struct TextureTable {
    device: Device,
    name: String,
    pub(crate) layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    pub(crate) set: vk::DescriptorSet,
    /// The number of elements.
    room: u32,
    /// The texel of elements without a texture.
    white: TextureArray,
    textures: Vec<Option<TextureArray>>,
    /// The indices of removed textures that no frame uses any more.
    free: Arc<Mutex<Vec<TextureNumber>>>,
    samplers: Vec<(SamplerKind, Arc<TextureSampler>)>,
}

of_device!(TextureTable: "a table of textures (`TextureTable`)");

/// The index of a removed texture, until no frame uses it.
struct RetiredNumber {
    number: TextureNumber,
    free: Arc<Mutex<Vec<TextureNumber>>>,
    set: vk::DescriptorSet,
    white: vk::DescriptorImageInfo,
}

impl RetiredObject for RetiredNumber {
    fn destroy(self: Box<Self>, device: &ash::Device) {
        // The image is retired after this, and the table and its white texel later still.
        write_elements(device, self.set, self.number.0, &[self.white]);
        lock(&self.free).push(self.number);
    }
}

impl TextureTable {
    /// Creates an empty table with room for `room` textures, clamped to the limit of the device
    /// ([`Adapter::indexed_textures`](crate::Adapter::indexed_textures)). Waits for a copy.
    ///
    /// # Errors
    /// [`Error::Unsupported`] without [`OptionalFeature::DescriptorIndexing`]; no memory; a failed
    /// call.
    pub fn new(device: &Device, name: &str, room: u32) -> Result<Self, Error> {
        device.require(OptionalFeature::DescriptorIndexing, "an image for each texture")?;
        let room = room.min(device.adapter().indexed_textures).max(1);
        let mut white = TextureArray::new(device, &WHITE)?;
        TextureUploads::new(device)?.write(&mut white, 0, &[255; 4])?;
        let mut table = Self {
            device: device.clone(),
            name: name.to_owned(),
            layout: create_layout(device, room)?,
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            room,
            white,
            textures: Vec::new(),
            free: Arc::default(),
            samplers: Vec::new(),
        };
        table.pool = create_pool(device, room)?;
        table.set = allocate_set(device, table.pool, table.layout)?;
        device.name(table.layout, name);
        device.name(table.pool, name);
        device.name(table.set, name);
        let all = vec![table.white.descriptor(); room as usize];
        write_elements(device.raw(), table.set, 0, &all);
        Ok(table)
    }

    /// Creates a texture whose sampler is shared with all textures of the table that are sampled in
    /// the same way. The texture has no index until it is added.
    ///
    /// # Errors
    /// The errors of [`TextureArray::new`].
    pub fn create(&mut self, info: &TextureArrayInfo<'_>) -> Result<TextureArray, Error> {
        let kind = SamplerKind::of(info);
        let known = self.samplers.iter().find(|(there, _)| *there == kind);
        let sampler = match known {
            Some((_, sampler)) => Arc::clone(sampler),
            None => {
                let sampler = Arc::new(TextureSampler::new(&self.device, info)?);
                self.samplers.push((kind, Arc::clone(&sampler)));
                sampler
            }
        };
        TextureArray::with_sampler(&self.device, info, sampler)
    }

    /// Adds a texture and returns its index. Commands recorded before cannot use it. Commands
    /// recorded later can, if the texture was [written](crate::TextureUploads::write) or
    /// [opened](crate::Commands::open_texture) before they run.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if the table is full; [`Error::Foreign`] for a texture of another
    /// device; a failed call.
    pub fn add(&mut self, texture: TextureArray) -> Result<TextureNumber, Error> {
        self.device.check(&texture, "tables of textures (`TextureTable`)")?;
        let freed = lock(&self.free).pop();
        let number = match freed {
            Some(number) => number,
            None => {
                let next = self.textures.len() as u32;
                self.check_room(next)?;
                self.textures.push(None);
                TextureNumber(next)
            }
        };
        write_elements(self.device.raw(), self.set, number.0, &[texture.descriptor()]);
        if let Some(there) = self.textures.get_mut(number.0 as usize) {
            *there = Some(texture);
        }
        Ok(number)
    }

    /// Removes a texture. Nothing that is recorded from now on may sample it; frames in flight
    /// still may.
    pub fn remove(&mut self, number: TextureNumber) {
        let there = self.textures.get_mut(number.0 as usize);
        if let Some(texture) = there.and_then(Option::take) {
            let free = Arc::clone(&self.free);
            let set = self.set;
            let white = self.white.descriptor();
            let retired = RetiredNumber { number, free, set, white };
            self.device.retire(Retired::Other(Box::new(retired)));
            drop(texture);
        }
    }

    /// Returns the texture with this index.
    pub fn texture(&self, number: TextureNumber) -> Option<&TextureArray> {
        self.textures.get(number.0 as usize)?.as_ref()
    }

    /// Returns an error if the table with `count` textures is full.
    fn check_room(&self, count: u32) -> Result<(), Error> {
        if count < self.room {
            return Ok(());
        }
        let what = format!("the number of {}", self.name);
        let wanted = u64::from(count) + 1;
        let limit = self.room.into();
        Err(Error::TooLarge { what, wanted, limit })
    }
}

impl fmt::Debug for TextureTable {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, room, .. } = self;
        write!(to, "{name}: room for {room} textures")
    }
}

impl Drop for TextureTable {
    fn drop(&mut self) {
        self.device.retire(Retired::DescriptorPool(self.pool));
        self.device.retire(Retired::SetLayout(self.layout));
    }
}

const KIND: vk::DescriptorType = vk::DescriptorType::COMBINED_IMAGE_SAMPLER;

/// The description of the white texel for elements without a texture.
const WHITE: TextureArrayInfo<'_> = TextureArrayInfo {
    name: "no texture",
    size: [1; 2],
    layers: 1,
    format: vk::Format::R8G8B8A8_UNORM,
    wrap: [vk::SamplerAddressMode::CLAMP_TO_EDGE; 2],
    magnified: vk::Filter::NEAREST,
    minified: vk::Filter::NEAREST,
    between_levels: None,
    anisotropy: 1.0,
    mip_making: MipGeneration::Cpu,
};

fn create_layout(device: &Device, room: u32) -> Result<vk::DescriptorSetLayout, Error> {
    let bindings = [vk::DescriptorSetLayoutBinding::default()
        .binding(0)
        .descriptor_type(KIND)
        .descriptor_count(room)
        .stage_flags(vk::ShaderStageFlags::FRAGMENT)];
    let flags = [vk::DescriptorBindingFlags::UPDATE_AFTER_BIND
        | vk::DescriptorBindingFlags::UPDATE_UNUSED_WHILE_PENDING
        | vk::DescriptorBindingFlags::PARTIALLY_BOUND];
    let mut flags = vk::DescriptorSetLayoutBindingFlagsCreateInfo::default().binding_flags(&flags);
    let info = vk::DescriptorSetLayoutCreateInfo::default()
        .bindings(&bindings)
        .flags(vk::DescriptorSetLayoutCreateFlags::UPDATE_AFTER_BIND_POOL)
        .push_next(&mut flags);
    // SAFETY: the device has the features of these flags and this number of descriptors, as the
    // caller checked.
    unsafe { device.raw().create_descriptor_set_layout(&info, device.callbacks()) }
        .called("vkCreateDescriptorSetLayout")
}

fn create_pool(device: &Device, room: u32) -> Result<vk::DescriptorPool, Error> {
    let sizes = [vk::DescriptorPoolSize { ty: KIND, descriptor_count: room }];
    let info = vk::DescriptorPoolCreateInfo::default()
        .max_sets(1)
        .pool_sizes(&sizes)
        .flags(vk::DescriptorPoolCreateFlags::UPDATE_AFTER_BIND);
    // SAFETY: a pool for one set.
    unsafe { device.raw().create_descriptor_pool(&info, device.callbacks()) }
        .called("vkCreateDescriptorPool")
}

fn allocate_set(
    device: &Device,
    pool: vk::DescriptorPool,
    layout: vk::DescriptorSetLayout,
) -> Result<vk::DescriptorSet, Error> {
    let layouts = [layout];
    let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
    // SAFETY: the pool is new and has room for this set.
    let sets = unsafe { device.raw().allocate_descriptor_sets(&info) }
        .called("vkAllocateDescriptorSets")?;
    Ok(sets.first().copied().unwrap_or_default())
}

/// Writes descriptors from the element `first` on.
fn write_elements(
    device: &ash::Device,
    set: vk::DescriptorSet,
    first: u32,
    images: &[vk::DescriptorImageInfo],
) {
    let write = vk::WriteDescriptorSet::default()
        .dst_set(set)
        .dst_binding(0)
        .dst_array_element(first)
        .descriptor_type(KIND)
        .image_info(images);
    // SAFETY: no command that runs or is recorded uses the elements: the set is new, the indices
    // were never used, or their last frames are over. No other thread writes the same elements.
    unsafe { device.update_descriptor_sets(&[write], &[]) };
}
