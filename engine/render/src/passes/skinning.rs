//! The skinning pass: computes the vertices of skinned meshes before their first draw in a frame.
//! Some are computed only if a result on the GPU says that they are drawn.

use bytemuck::{Pod, Zeroable};
use gpu::{Access, BufferSlice, Commands, ComputePipeline, Device, MemoryBarrier, StorageLayout};

use occlusion::{Error, ShaderSet};

/// The pass that writes morphed and skinned vertices to the places of their meshes among all
/// vertices.
pub(crate) struct SkinningPass {
    pipeline: ComputePipeline,
}

/// The buffers of the pass. Mesh data and poses are read; positions, normals and tangents are
/// written.
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
    /// A flag per pose, which the shader sets; `None` if the flags are not read.
    pub(crate) written: Option<BufferSlice>,
}

/// The job of one mesh; mirrors `skinning.comp`. Offsets count 32-bit values.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct SkinningJob {
    pub(crate) vertex_count: u32,
    pub(crate) first_vertex: u32,
    /// The offset of the vertices at rest in the mesh data.
    pub(crate) rest: u32,
    /// The offset of the joints and weights of each vertex in the mesh data.
    pub(crate) skin: u32,
    /// The number of groups of four joints per vertex; 0 without a skin.
    pub(crate) joint_sets: u32,
    /// The offset of the rows of each joint in the poses.
    pub(crate) joints: u32,
    /// The offset of the targets with a weight in the poses.
    pub(crate) targets: u32,
    pub(crate) target_count: u32,
    /// The index of the result that decides, or [`NOTHING`].
    pub(crate) result: u32,
    pub(crate) threshold_samples: u32,
    /// The index of the flag, or [`NOTHING`].
    pub(crate) flag: u32,
}

const _: () = assert!(size_of::<SkinningJob>() == 44);

/// Stands for no list, no result or no flag; mirrors `skinning.comp`.
pub(crate) const NOTHING: u32 = u32::MAX;

/// The number of values of a vertex at rest.
pub(crate) const REST_VALUES: u32 = 7;

const GROUP_THREADS: u32 = 64;

/// The highest number of workgroups. More are not faster, and every device allows 65535.
const GROUPS_MAX: u32 = 4096;

/// The skinning of a mesh that may depend on a result.
#[derive(Clone, Copy)]
pub(crate) struct PredicatedJob {
    /// The results that decide; `None` if the mesh is skinned in any case.
    pub(crate) results: Option<BufferSlice>,
    pub(crate) job: SkinningJob,
}

impl SkinningPass {
    /// Compiles the pass.
    pub(crate) fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let storage = StorageLayout::new::<SkinningJob>(6);
        let name = "skinning.comp";
        Ok(Self { pipeline: ComputePipeline::new(device, name, shaders.find(name)?, storage)? })
    }

    /// Skins meshes, each at most once. With `results`, a job runs only if its result says so.
    /// Commands that were recorded earlier, in this frame or another, still read the old vertices,
    /// since all run on one queue.
    pub(crate) fn record(
        &self,
        commands: &Commands,
        io: &SkinningIo,
        jobs: impl Iterator<Item = PredicatedJob>,
    ) {
        let between = MemoryBarrier::between;
        commands.pass("skin meshes", |commands| {
            // The flags have just been cleared.
            let before = [Access::AttributeRead, Access::ComputeWrite, Access::CopyWrite];
            commands.barrier(between(&before, &[Access::ComputeWrite]));
            let mut bound = None;
            for PredicatedJob { results, job } in jobs {
                // A buffer must be bound even if it is not used.
                let results = results.unwrap_or(io.mesh_data);
                if bound.replace(results) != Some(results) {
                    let written = io.written.unwrap_or(io.vertices);
                    let SkinningIo { vertices, surfaces, mesh_data, poses, .. } = *io;
                    let buffers = [vertices, surfaces, mesh_data, poses, results, written];
                    commands.bind_compute(&self.pipeline, &buffers);
                }
                commands.push_compute_constants(&self.pipeline, &job);
                let groups = job.vertex_count.div_ceil(GROUP_THREADS);
                commands.dispatch([groups.clamp(1, GROUPS_MAX), 1, 1]);
            }
            // The next round writes other results to the buffers just read.
            let next = [
                Access::AttributeRead,
                Access::CopyWrite,
                Access::CopyRead,
                Access::FragmentWrite,
                Access::ComputeWrite,
            ];
            commands.barrier(between(&[Access::ComputeWrite, Access::ComputeRead], &next));
        });
    }
}
