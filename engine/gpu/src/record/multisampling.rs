//! The parts that only a target with several samples per pixel has: the image of averages, and the
//! pass that reads depths.

use ash::vk;
use bytemuck::{Pod, Zeroable};

use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::memory::buffer::BufferSlice;
use crate::memory::image::ImageFormats;
use crate::memory::sampled_texture::{Contents, SampledTexture};
use crate::record::access::{Access, MemoryBarrier};
use crate::record::attachments::{COLOUR_BYTES, COLOUR_FORMAT};
use crate::record::commands::Commands;
use crate::record::pipeline::{ComputePipeline, StorageLayout};
use crate::record::sample_count::SampleCount;
use crate::record::shader::Spirv;
use crate::record::target_image::TargetImage;

/// The number of pixels along each side of a workgroup of `farthest_depths.comp`.
const GROUP: u32 = 8;

/// The averages of several samples per pixel, and the reader of their depths.
pub(super) struct Multisampling {
    device: Device,
    samples: SampleCount,
    /// The image with one colour per pixel, from the last resolve.
    pub(super) average: TargetImage,
    /// True if the averages include the last drawn samples, now or when their rendering ends.
    pub(super) is_resolved: bool,
    farthest_depths: ComputePipeline,
    sampler: vk::Sampler,
}

/// The push constants of `farthest_depths.comp`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    origin: [u32; 2],
    size: [u32; 2],
    samples: u32,
}

const _: () = assert!(size_of::<Constants>() == 20);

impl Multisampling {
    /// Creates both parts for a target of `size` pixels, within the device's limits.
    pub(super) fn new(
        device: &Device,
        size: [u32; 2],
        samples: SampleCount,
        usage: vk::ImageUsageFlags,
        name: &str,
    ) -> Result<Self, Error> {
        let average = TargetImage::new(
            device,
            &format!("{name} average colour"),
            size,
            1,
            ImageFormats { memory: COLOUR_BYTES, view: COLOUR_FORMAT },
            usage,
            vk::ImageAspectFlags::COLOR,
        )?;
        let shader = shaders::FARTHEST_DEPTHS;
        let spirv = Spirv::from_bytes(shader.name, shader.spirv)?;
        let storage = StorageLayout { textures: 1, ..StorageLayout::new::<Constants>(1) };
        let farthest_depths = ComputePipeline::new(device, "farthest depths", &spirv, storage)?;
        let info = vk::SamplerCreateInfo::default();
        // SAFETY: a plain sampler.
        let sampler = unsafe { device.raw().create_sampler(&info, device.callbacks()) }
            .called("vkCreateSampler")?;
        device.name(sampler, name);
        let device = device.clone();
        Ok(Self { device, samples, average, is_resolved: false, farthest_depths, sampler })
    }

    /// Writes the farthest depth of each pixel of an area to a storage buffer, which must be large
    /// enough. For barriers it counts as an [`Access::CopyWrite`]. The depth image must be ready to
    /// be sampled.
    pub(super) fn copy_farthest(
        &self,
        commands: &Commands,
        depth: vk::ImageView,
        origin: [u32; 2],
        size: [u32; 2],
        to: BufferSlice,
    ) {
        let between = MemoryBarrier::between;
        commands.barrier(between(&[Access::CopyWrite], &[Access::ComputeWrite]));
        let contents = Contents::Defined;
        let depth = SampledTexture::new(self.device.id(), depth, self.sampler, contents);
        commands.bind_compute_sampled(&self.farthest_depths, &[to], &[depth]);
        let constants = Constants { origin, size, samples: self.samples.count() };
        commands.push_compute_constants(&self.farthest_depths, &constants);
        let [across, down] = size.map(|side| side.div_ceil(GROUP));
        commands.dispatch([across, down, 1]);
        commands.barrier(between(&[Access::ComputeWrite], &[Access::CopyWrite]));
    }
}

impl Drop for Multisampling {
    fn drop(&mut self) {
        self.device.retire(Retired::Sampler(self.sampler));
    }
}
