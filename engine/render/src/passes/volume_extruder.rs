//! The compute pass that extrudes shadow volumes into a list of vertices, for devices without
//! geometry shaders.

use bytemuck::{Pod, Zeroable};
use gpu::{
    Access, Buffer, BufferSlice, Commands, ComputePipeline, Device, Frame, IndirectDraw,
    MemoryBarrier, MemoryKind, StorageLayout, vk,
};
use occlusion::{Error, ShaderSet};

use super::volume_constants::VolumeConstants;
use super::volumes::VolumeIo;

/// The number of triangles that are extruded at once. Their volumes take 24 MiB.
const BATCH_TRIANGLES: u32 = 1 << 16;

/// The highest number of casters that are extruded at once. Every device allows 65535 workgroups.
const BATCH_CASTERS: usize = 1 << 15;

/// The highest number of vertices per triangle: two caps, and three sides of two triangles.
const VERTICES_PER_TRIANGLE: u64 = 24;

const GROUP_THREADS: u32 = 64;

/// A run of triangles of a caster; mirrors `volume_extrude.comp`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct ExtrusionJob {
    first_index: u32,
    triangle_count: u32,
    first_vertex: u32,
    instance: u32,
}

const _: () = assert!(size_of::<ExtrusionJob>() == 16);

/// Jobs on the GPU that are extruded at once.
pub(super) struct Batch {
    jobs: BufferSlice,
    count: u32,
    /// The number of triangles of the largest job.
    most_triangles: u32,
}

/// The compute pass, and the list that it writes.
pub(super) struct Extruder {
    pipeline: ComputePipeline,
    extruded: Buffer,
    /// An indirect draw of the list.
    draw: Buffer,
}

impl Batch {
    /// Uploads jobs, of which there must be at least one.
    pub(super) fn upload(frame: &mut Frame<'_>, jobs: &[ExtrusionJob]) -> Result<Self, Error> {
        let most_triangles = jobs.iter().map(|job| job.triangle_count).max().unwrap_or_default();
        let slice = frame.uploads().push(jobs)?;
        Ok(Self { jobs: slice, count: jobs.len() as u32, most_triangles })
    }
}

impl Extruder {
    /// Compiles the pass.
    pub(super) fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let storage = StorageLayout::new::<VolumeConstants>(6);
        let name = "volume_extrude.comp";
        let pipeline = ComputePipeline::new(device, name, shaders.find(name)?, storage)?;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let size_bytes = u64::from(BATCH_TRIANGLES) * VERTICES_PER_TRIANGLE * 16;
        let vertex = usage | vk::BufferUsageFlags::VERTEX_BUFFER;
        let memory = MemoryKind::Device;
        let extruded = Buffer::new(device, "extruded volumes", size_bytes, vertex, memory)?;
        let indirect =
            usage | vk::BufferUsageFlags::INDIRECT_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let draw = Buffer::new(device, "draw of volumes", 16, indirect, memory)?;
        Ok(Self { pipeline, extruded, draw })
    }

    /// Splits draws of triangles with adjacency into batches that fit into the list.
    pub(super) fn batches(draws: impl Iterator<Item = IndirectDraw>) -> Vec<Vec<ExtrusionJob>> {
        let mut batches = Vec::new();
        let mut batch = Vec::new();
        let mut room = BATCH_TRIANGLES;
        for draw in draws {
            let mut first_index = draw.first_index;
            let mut left = draw.index_count / 6;
            while left > 0 {
                if room == 0 || batch.len() == BATCH_CASTERS {
                    batches.push(std::mem::take(&mut batch));
                    room = BATCH_TRIANGLES;
                }
                let triangle_count = left.min(room);
                batch.push(ExtrusionJob {
                    first_index,
                    triangle_count,
                    first_vertex: draw.vertex_offset as u32,
                    instance: draw.first_instance,
                });
                first_index += 6 * triangle_count;
                left -= triangle_count;
                room -= triangle_count;
            }
        }
        if !batch.is_empty() {
            batches.push(batch);
        }
        batches
    }

    /// Extrudes a batch, outside of rendering, and replaces the previous batch.
    pub(super) fn extrude(
        &self,
        commands: &Commands,
        io: &VolumeIo,
        batch: &Batch,
        constants: &VolumeConstants,
    ) {
        let between = MemoryBarrier::between;
        let draw = self.draw.whole();
        let used = [Access::IndirectRead, Access::AttributeRead];
        commands.barrier(between(&used, &[Access::CopyWrite, Access::ComputeWrite]));
        // One instance, without vertices yet.
        commands.fill(draw, 0);
        commands.barrier(between(&[Access::CopyWrite], &[Access::CopyWrite]));
        commands.fill(draw.part(4, 4), 1);
        commands.barrier(between(&[Access::CopyWrite], &[Access::ComputeWrite]));
        let extruded = self.extruded.whole();
        let buffers = [io.instances, io.vertices, io.adjacency, batch.jobs, extruded, draw];
        commands.bind_compute(&self.pipeline, &buffers);
        commands.push_compute_constants(&self.pipeline, constants);
        commands.dispatch([batch.most_triangles.div_ceil(GROUP_THREADS), batch.count, 1]);
        commands.barrier(between(&[Access::ComputeWrite], &used));
    }

    /// Draws the extruded batch, inside a rendering. `all` holds the count of all draws.
    pub(super) fn draw(&self, commands: &Commands, all: BufferSlice) {
        commands.bind_geometry(self.extruded.whole(), None);
        commands.draw_all_unindexed_indirect(self.draw.whole(), all);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_hold_all_triangles_and_fit() {
        let draw = |triangles: u32, first_index| IndirectDraw {
            index_count: 6 * triangles,
            instance_count: 1,
            first_index,
            vertex_offset: 7,
            first_instance: 9,
        };
        let sizes = [10, 0, BATCH_TRIANGLES - 5, 3 * BATCH_TRIANGLES, 1];
        let batches = Extruder::batches(sizes.iter().map(|triangles| draw(*triangles, 60)));
        let of = |batch: &Vec<ExtrusionJob>| batch.iter().map(|job| job.triangle_count).sum();
        let counts: Vec<u32> = batches.iter().map(of).collect();
        assert_eq!(counts.iter().sum::<u32>(), sizes.iter().sum::<u32>());
        assert!(counts.iter().all(|count| *count <= BATCH_TRIANGLES), "{counts:?}");
        let second: Vec<u32> = batches[1].iter().map(|job| job.first_index).collect();
        assert_eq!(second[0], 60 + 6 * (BATCH_TRIANGLES - 10), "it goes on where it was split");
        let many = Extruder::batches((0..2 * BATCH_CASTERS).map(|_| draw(1, 0)));
        assert_eq!(many.len(), 2);
    }
}
