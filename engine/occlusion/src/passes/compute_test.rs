//! The compute tester: tests boxes without rasterising them.
//!
//! A grid of 8x8-pixel cells holds the farthest depth in each cell. A workgroup tests one box:
//! first against the cells that it may cover, then against the pixels of each cell that does not
//! decide. This tester suits boxes that cover many pixels, since a rasteriser on a CPU visits every
//! pixel.
//!
//! The tester never reports a box as hidden if [`ProxyPass`](crate::ProxyPass) would find a visible
//! sample; the proof is in `compute_test.comp`.

use bytemuck::{Pod, Zeroable};
use cull::{CullView, DepthConvention, ProjectionKind};
use gpu::{
    Access, Buffer, BufferSlice, Commands, ComputePipeline, Device, MemoryBarrier, MemoryKind,
    StorageLayout, Target, vk,
};

use crate::error::Error;
use crate::rect::Rect;
use crate::shader_set::ShaderSet;

/// Pixels along each side of a cell, as in the shaders.
const CELL: u32 = 8;

/// Cells per workgroup of `depth_grid.comp`.
const GRID_GROUP: u32 = 64;

/// The margin in pixels for rounding, in addition to the sub-pixel grid of the rasteriser.
const SLACK_PIXELS: f32 = 1.0 / 64.0;

/// The pass that tests boxes against a depth image in compute shaders. Owns a copy of the depth.
pub struct ComputeTest {
    grid_pipeline: ComputePipeline,
    test_pipeline: ComputePipeline,
    depths: Option<DepthGrid>,
    reach_pixels: f32,
    most_groups: u32,
}

/// The depth of an image, and the farthest depth per cell.
struct DepthGrid {
    depths: Buffer,
    cells: Buffer,
}

/// The buffers of a test: boxes are read, results are written.
#[derive(Clone, Copy)]
pub struct ComputeTestIo {
    /// [`ProxyBox`](crate::ProxyBox)es that are already enlarged and lie wholly beyond the near
    /// plane.
    pub boxes: BufferSlice,
    /// A 32-bit result per box: 1 if it may be visible, else 0.
    pub results: BufferSlice,
    /// The index of the first box of these tests, and of its result.
    pub first: u32,
    /// The number of tests.
    pub count: u32,
}

/// The push constants of `depth_grid.comp`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct GridConstants {
    size: [u32; 2],
    sign: f32,
}

/// The push constants of `compute_test.comp`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct TestConstants {
    origin: [f32; 3],
    near: f32,
    forward: [f32; 3],
    first: u32,
    right: [f32; 3],
    reach_pixels: f32,
    down: [f32; 3],
    sign: f32,
    depth_terms: [f32; 2],
    has_eye: u32,
    coordinate: f32,
    size: [u32; 2],
}

const _: () = assert!(size_of::<GridConstants>() == 12 && size_of::<TestConstants>() == 88);

impl ComputeTest {
    /// Compiles the passes for depths with this number of samples per pixel. Each of several
    /// samples may lie anywhere in its pixel, so tests compare with the farthest sample.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        samples: vk::SampleCountFlags,
    ) -> Result<Self, Error> {
        let limits = &device.adapter().limits;
        let pipeline = |name, shader, storage| {
            ComputePipeline::new(device, name, shaders.find(shader)?, storage).map_err(Error::from)
        };
        let grid_layout = StorageLayout::new::<GridConstants>(2);
        let test_layout = StorageLayout::new::<TestConstants>(4);
        let snapping = 0.5_f32.powi(limits.sub_pixel_precision_bits.min(24) as i32);
        let off_centre = if samples == vk::SampleCountFlags::TYPE_1 { 0.0 } else { 0.5 };
        Ok(Self {
            grid_pipeline: pipeline("depth grid", "depth_grid.comp", grid_layout)?,
            test_pipeline: pipeline("compute test", "compute_test.comp", test_layout)?,
            depths: None,
            reach_pixels: snapping + SLACK_PIXELS + off_centre,
            most_groups: limits.max_compute_work_group_count[0].max(1),
        })
    }

    /// Compiles the passes like [`ComputeTest::new`], with room for depths of `size` pixels.
    ///
    /// # Errors
    /// The errors of [`ComputeTest::new`] and [`ComputeTest::resize`].
    pub fn sized(
        device: &Device,
        shaders: &ShaderSet,
        samples: vk::SampleCountFlags,
        size: [u32; 2],
    ) -> Result<Self, Error> {
        let mut test = Self::new(device, shaders, samples)?;
        test.resize(device, size)?;
        Ok(test)
    }

    /// Makes room for depths of `size` pixels, unless there is room already. Before this every box
    /// may show.
    ///
    /// # Errors
    /// An image whose depth is larger than a storage buffer may be, or has more cells than one
    /// dispatch takes; no memory.
    pub fn resize(&mut self, device: &Device, size: [u32; 2]) -> Result<(), Error> {
        let bytes = |size| product(size).saturating_mul(4);
        let has_room = |depths: &DepthGrid| {
            depths.depths.size_bytes() >= bytes(size)
                && depths.cells.size_bytes() >= bytes(cells(size))
        };
        if self.depths.as_ref().is_some_and(has_room) {
            return Ok(());
        }
        Self::check(device, size)?;
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let buffer = |name, size, usage| {
            Buffer::new(device, name, bytes(size), storage | usage, MemoryKind::Device)
        };
        self.depths = Some(DepthGrid {
            depths: buffer("tested depth", size, vk::BufferUsageFlags::TRANSFER_DST)?,
            cells: buffer("depth grid", cells(size), vk::BufferUsageFlags::empty())?,
        });
        Ok(())
    }

    /// Checks that the device can test in areas of up to `size` pixels.
    ///
    /// # Errors
    /// An image whose depth is larger than a storage buffer may be, or has more cells than one
    /// dispatch takes.
    pub fn check(device: &Device, size: [u32; 2]) -> Result<(), Error> {
        Ok(check_size(size, &device.adapter().limits)?)
    }

    /// Copies the present depth of `target` in `area`, for all tests until the next call. `area` is
    /// at most as large in each direction as the size given to [`ComputeTest::resize`]. Outside of
    /// rendering. The caller prepares the target again before drawing to it.
    pub fn record_grid(
        &self,
        commands: &Commands,
        target: &mut Target,
        area: Rect,
        depth: DepthConvention,
    ) {
        let Some(grid) = &self.depths else { return };
        let between = MemoryBarrier::between;
        // Earlier tests, of this frame or another, must have read the old contents.
        commands
            .barrier(between(&[Access::ComputeRead], &[Access::CopyWrite, Access::ComputeWrite]));
        target.copy_depth_to(commands, area.origin, area.size, grid.depths.whole());
        commands.barrier(between(&[Access::CopyWrite], &[Access::ComputeRead]));
        commands.bind_compute(&self.grid_pipeline, &[grid.depths.whole(), grid.cells.whole()]);
        let constants = GridConstants { size: area.size, sign: depth.sign() };
        commands.push_compute_constants(&self.grid_pipeline, &constants);
        // One dispatch is enough: this was checked for the largest area.
        commands.dispatch([grid_groups(area.size) as u32, 1, 1]);
        commands.barrier(between(&[Access::ComputeWrite], &[Access::ComputeRead]));
    }

    /// Tests boxes in `view`, the view that the depth was drawn with. Outside of rendering, after
    /// [`ComputeTest::record_grid`]. Earlier reads of the results must be over; a barrier from
    /// [`Access::ComputeWrite`] to the next use must follow.
    pub fn record_tests(&self, commands: &Commands, io: &ComputeTestIo, view: &CullView) {
        let Some(grid) = &self.depths else {
            // Without a depth any box may show.
            let bytes = |results: u32| u64::from(results) * 4;
            return commands.fill(io.results.part(bytes(io.first), bytes(io.count)), 1);
        };
        let buffers = [io.boxes, grid.depths.whole(), grid.cells.whole(), io.results];
        let mut constants = self.constants(view);
        let end = io.first.saturating_add(io.count);
        for first in (io.first..end).step_by(self.most_groups as usize) {
            constants.first = first;
            commands.bind_compute(&self.test_pipeline, &buffers);
            commands.push_compute_constants(&self.test_pipeline, &constants);
            commands.dispatch([(end - first).min(self.most_groups), 1, 1]);
        }
    }

    fn constants(&self, view: &CullView) -> TestConstants {
        let rays = &view.rays;
        let pixel = |axis: usize| 2.0 / view.size[axis] as f32;
        let sign = view.depth.sign();
        TestConstants {
            origin: rays.origin.to_array(),
            near: rays.near,
            forward: rays.middle.to_array(),
            first: 0,
            right: (rays.right * pixel(0)).to_array(),
            reach_pixels: self.reach_pixels,
            down: (rays.down * pixel(1)).to_array(),
            sign,
            depth_terms: rays.depth.map(|term| sign * term),
            has_eye: u32::from(rays.kind == ProjectionKind::Perspective),
            coordinate: rays.coordinate,
            size: view.size,
        }
    }
}

fn product(size: [u32; 2]) -> u64 {
    let [width, height] = size;
    u64::from(width) * u64::from(height)
}

/// Returns the number of cells along each side of `size` pixels.
fn cells(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.div_ceil(CELL))
}

/// Returns the number of workgroups of `depth_grid.comp` for `size` pixels.
fn grid_groups(size: [u32; 2]) -> u64 {
    product(cells(size)).div_ceil(u64::from(GRID_GROUP))
}

fn check_size(size: [u32; 2], limits: &vk::PhysicalDeviceLimits) -> Result<(), gpu::Error> {
    let refuse = |what: &str, wanted, limit| {
        if wanted > limit {
            Err(gpu::Error::TooLarge { what: what.to_owned(), wanted, limit })
        } else {
            Ok(())
        }
    };
    let most_bytes = u64::from(limits.max_storage_buffer_range);
    let most_groups = u64::from(limits.max_compute_work_group_count[0]);
    let bytes = product(size).saturating_mul(4);
    refuse("the depth for the compute tester in bytes", bytes, most_bytes)?;
    refuse("the workgroups for the compute tester", grid_groups(size), most_groups)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_refused_that_a_buffer_or_a_dispatch_does_not_hold() {
        let limits = |range, groups| vk::PhysicalDeviceLimits {
            max_storage_buffer_range: range,
            max_compute_work_group_count: [groups; 3],
            ..Default::default()
        };
        let check = |size, limits| check_size(size, &limits).map_err(|error| error.to_string());
        // 256 x 256 cells of 64 pixels, 64 to a group.
        assert_eq!(check([2048, 2048], limits(u32::MAX, 1024)), Ok(()));
        assert!(check([2049, 2048], limits(u32::MAX, 1024)).unwrap_err().contains("workgroups"));
        assert_eq!(check([16384, 16384], limits(u32::MAX, 65536)), Ok(()));
        assert!(check([16384, 16384], limits(u32::MAX, 65535)).unwrap_err().contains("65536"));
        assert!(check([64, 64], limits(16383, 65535)).unwrap_err().contains("bytes"));
        assert!(check([u32::MAX; 2], limits(u32::MAX, 65535)).is_err());
    }
}
