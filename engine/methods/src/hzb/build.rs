//! The depth pyramid: the farthest depth under each texel, at every level up to 4x4 texels.
//!
//! The pyramid is one storage buffer: a tight copy of the depth image, followed by level after
//! level. Each level is half as large, rounded up, so that no pixel of an odd size is lost. A
//! compute pass builds three levels at a time without shared memory or barriers: each thread reads
//! its own 8x8 texels.

use bytemuck::{Pod, Zeroable};
use gpu::{
    Access, Buffer, BufferSlice, Commands, ComputePipeline, Device, MemoryBarrier, MemoryKind,
    StorageLayout, Target, vk,
};

use occlusion::{Error, Rect, ShaderSet};

/// The number of levels that one dispatch builds.
const LEVELS_A_DISPATCH: usize = 3;

/// Texels along each side of a workgroup's block of the third level: `local_size` of the shader.
const GROUP: u32 = 8;

/// The side of the last level in texels: a test reads up to 4x4 texels of one level.
const LAST_SIDE: u32 = 4;

/// The place of a level of a depth pyramid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HzbLevel {
    /// The offset of its first texel from the first texel of level 0.
    pub start: u64,
    /// The size in texels.
    pub size: [u32; 2],
}

impl HzbLevel {
    fn texels(self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }
}

/// Returns the levels over an image of `size` pixels, beginning with level 0, the image. Each level
/// has half the texels of the previous one in both directions, rounded up; the last has at most
/// 4x4.
pub fn hzb_levels(size: [u32; 2]) -> impl Iterator<Item = HzbLevel> + Clone {
    let base = HzbLevel { start: 0, size: size.map(|side| side.max(1)) };
    std::iter::successors(Some(base), |level| {
        level.size.into_iter().any(|side| side > LAST_SIDE).then(|| HzbLevel {
            start: level.start + level.texels(),
            size: level.size.map(|side| side.div_ceil(2)),
        })
    })
}

fn bytes_of(size: [u32; 2]) -> u64 {
    4 * hzb_levels(size).map(HzbLevel::texels).sum::<u64>()
}

/// The pass that builds the depth pyramid of a target. Owns the pyramid's buffer.
pub struct HzbPass {
    pipeline: ComputePipeline,
    depths: Buffer,
}

/// The push constants of `pyramid_build.comp`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    size: [u32; 2],
    start: u32,
    levels: u32,
}

const _: () = assert!(size_of::<Constants>() == 16);

impl HzbPass {
    /// Compiles the pass for areas of up to `size` pixels.
    pub fn new(device: &Device, shaders: &ShaderSet, size: [u32; 2]) -> Result<Self, Error> {
        Self::check(device, size)?;
        let size_bytes = bytes_of(size);
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::TRANSFER_SRC;
        let storage = StorageLayout::new::<Constants>(1);
        let shader = shaders.find("pyramid_build.comp")?;
        Ok(Self {
            pipeline: ComputePipeline::new(device, "pyramid build", shader, storage)?,
            depths: Buffer::new(device, "depth pyramid", size_bytes, usage, MemoryKind::Device)?,
        })
    }

    /// Checks that the device can hold the pyramid of an area of `size` pixels.
    pub fn check(device: &Device, size: [u32; 2]) -> Result<(), Error> {
        let wanted = bytes_of(size);
        let limit = device.adapter().limits.max_storage_buffer_range.into();
        if wanted > limit {
            let what = "the depth pyramid in bytes".to_owned();
            return Err(gpu::Error::TooLarge { what, wanted, limit }.into());
        }
        Ok(())
    }

    /// Returns all levels, with a 32-bit float per texel, laid out as in [`hzb_levels`].
    pub fn depths(&self) -> BufferSlice {
        self.depths.whole()
    }

    /// Builds all levels from the present depth of `target` in `area`, which is at most as large in
    /// each direction as the size given to [`HzbPass::new`]. Outside of rendering. Compute shaders
    /// and copies may read [`HzbPass::depths`] afterwards.
    pub fn record(&self, commands: &Commands, target: &mut Target, area: Rect) {
        let between = MemoryBarrier::between;
        // Earlier frames may still read or copy the pyramid.
        let earlier = [Access::ComputeRead, Access::ComputeWrite, Access::CopyRead];
        commands.barrier(between(&earlier, &[Access::CopyWrite, Access::ComputeWrite]));
        target.copy_depth_to(commands, area.origin, area.size, self.depths.whole());
        let readable = [Access::ComputeRead, Access::ComputeWrite, Access::CopyRead];
        commands.barrier(between(&[Access::CopyWrite], &readable));
        let levels = hzb_levels(area.size);
        for (number, level) in levels.clone().enumerate().step_by(LEVELS_A_DISPATCH) {
            let above = levels.clone().skip(number + 1).take(LEVELS_A_DISPATCH).count();
            if above == 0 {
                break;
            }
            commands.bind_compute(&self.pipeline, &[self.depths.whole()]);
            let start = level.start as u32; // below a quarter of maxStorageBufferRange, 32 bits
            let constants = Constants { size: level.size, start, levels: above as u32 };
            commands.push_compute_constants(&self.pipeline, &constants);
            let blocks = level.size.map(|side| side.div_ceil(1 << LEVELS_A_DISPATCH));
            let groups = blocks.map(|blocks| blocks.div_ceil(GROUP));
            commands.dispatch([groups[0], groups[1], 1]);
            commands.barrier(between(&[Access::ComputeWrite], &readable));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the texels of a level that a rectangle of pixels touches.
    fn touched(first: u32, last: u32, level: usize) -> std::ops::RangeInclusive<u32> {
        first >> level..=last >> level
    }

    #[test]
    fn levels_follow_each_other_and_end_at_four() {
        let sizes = |size| hzb_levels(size).map(|level| level.size).collect::<Vec<_>>();
        assert_eq!(sizes([1, 1]), [[1, 1]]);
        assert_eq!(sizes([4, 4]), [[4, 4]]);
        assert_eq!(sizes([5, 1]), [[5, 1], [3, 1]]);
        assert_eq!(sizes([333, 7])[..3], [[333, 7], [167, 4], [84, 2]]);
        assert_eq!(sizes([1280, 720]).last(), Some(&[3, 2]));
        for size in [[1, 1], [9, 4], [333, 7], [641, 363], [4096, 4096]] {
            let levels: Vec<HzbLevel> = hzb_levels(size).collect();
            for pair in levels.windows(2) {
                assert_eq!(pair[1].start, pair[0].start + pair[0].texels());
            }
        }
    }

    #[test]
    fn every_rectangle_fits_in_some_level_and_is_covered_there() {
        for size in [1, 2, 3, 5, 8, 31, 100, 333] {
            let levels: Vec<HzbLevel> = hzb_levels([size, 1]).collect();
            for first in 0..size {
                for last in first..size {
                    let fits = |level: &usize| (last >> level) - (first >> level) < LAST_SIDE;
                    let level = (0..levels.len()).find(fits).expect("the last level fits");
                    let texels = touched(first, last, level);
                    assert!(*texels.end() < levels[level].size[0], "in the level");
                    // Texel t covers the pixels from t << level on, 1 << level of them.
                    assert!(texels.start() << level <= first);
                    assert!((texels.end() + 1) << level > last);
                }
            }
        }
    }
}
