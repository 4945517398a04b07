//! The skinning pass: computes the vertices of skinned meshes, before anything of the frame reads
//! them.

use bytemuck::{Pod, Zeroable};
use gpu::{Access, BufferSlice, Commands, ComputePipeline, Device, MemoryBarrier, StorageLayout};

use occlusion::{Error, ShaderSet};

/// The pass that writes the vertices of meshes, morphed and skinned, into their places among all
/// others.
pub(crate) struct SkinningPass {
    pipeline: ComputePipeline,
}

/// The buffers of the pass: reads mesh data and poses; writes positions, normals and tangents.
#[derive(Clone, Copy)]
pub(crate) struct SkinningIo {
    /// The [`Vertex`](scene::Vertex)es of all meshes.
    pub(crate) vertices: BufferSlice,
    /// The [`SurfaceVertex`](scene::SurfaceVertex)es, of the same vertices.
    pub(crate) surfaces: BufferSlice,
    /// The vertices at rest, joints, weights and morph targets, as 32-bit values.
    pub(crate) mesh_data: BufferSlice,
    /// The poses of this frame, as 32-bit values.
    pub(crate) poses: BufferSlice,
}

/// One mesh; mirrors `skinning.comp`. Places are numbers of values.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct SkinningJob {
    pub(crate) vertex_count: u32,
    pub(crate) first_vertex: u32,
    /// In the mesh data: the vertices at rest.
    pub(crate) rest: u32,
    /// In the mesh data: the joints and weights of each vertex.
    pub(crate) skin: u32,
    /// Groups of four joints per vertex; 0 without a skin.
    pub(crate) joint_sets: u32,
    /// In the poses: the rows of each joint.
    pub(crate) joints: u32,
    /// In the poses: the targets with a weight.
    pub(crate) targets: u32,
    pub(crate) target_count: u32,
}

const _: () = assert!(size_of::<SkinningJob>() == 32);

/// Values of a vertex at rest.
pub(crate) const REST_VALUES: u32 = 7;

const GROUP_THREADS: u32 = 64;

/// The most workgroups: more do not make it faster, and every device allows 65535.
const GROUPS_MAX: u32 = 4096;

impl SkinningPass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// A failed call.
    pub(crate) fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let storage = StorageLayout::new::<SkinningJob>(4);
        let name = "skinning.comp";
        Ok(Self { pipeline: ComputePipeline::new(device, name, shaders.find(name)?, storage)? })
    }

    /// Skins meshes, each at most once. Commands that were recorded before, in this frame or an
    /// earlier one, still read the old vertices: one queue runs them all.
    pub(crate) fn record(
        &self,
        commands: &Commands,
        io: &SkinningIo,
        jobs: impl Iterator<Item = SkinningJob>,
    ) {
        let between = MemoryBarrier::between;
        commands.pass("skin meshes", |commands| {
            let before = [Access::AttributeRead, Access::ComputeWrite];
            commands.barrier(between(&before, &[Access::ComputeWrite]));
            let buffers = [io.vertices, io.surfaces, io.mesh_data, io.poses];
            commands.bind_compute(&self.pipeline, &buffers);
            for job in jobs {
                commands.push_compute_constants(&self.pipeline, &job);
                let groups = job.vertex_count.div_ceil(GROUP_THREADS);
                commands.dispatch([groups.clamp(1, GROUPS_MAX), 1, 1]);
            }
            commands.barrier(between(&[Access::ComputeWrite], &[Access::AttributeRead]));
        });
    }
}
