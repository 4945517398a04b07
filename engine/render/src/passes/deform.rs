//! The deform pass: computes the vertices of skinned meshes, before anything of the frame reads
//! them.

use bytemuck::{Pod, Zeroable};
use gpu::{Access, BufferSlice, Commands, ComputePipeline, Device, MemoryBarrier, StorageLayout};

use occlusion::{Error, ShaderSet};

/// The pass that writes the vertices of meshes, morphed and skinned, into their places among all
/// others.
pub(crate) struct DeformPass {
    pipeline: ComputePipeline,
}

/// The buffers of the pass: reads forms and poses; writes positions, normals and tangents.
#[derive(Clone, Copy)]
pub(crate) struct DeformIo {
    /// The [`Vertex`](scene::Vertex)es of all meshes.
    pub(crate) vertices: BufferSlice,
    /// The [`SurfaceVertex`](scene::SurfaceVertex)es, of the same vertices.
    pub(crate) surfaces: BufferSlice,
    /// Words: the data of the forms.
    pub(crate) forms: BufferSlice,
    /// Words: the poses of this frame.
    pub(crate) poses: BufferSlice,
}

/// One mesh; mirrors `deform.comp`. Places are numbers of words.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Deformation {
    pub(crate) vertex_count: u32,
    pub(crate) first_vertex: u32,
    /// Among the forms: the vertices at rest.
    pub(crate) rest: u32,
    /// Among the forms: the joints and weights of each vertex.
    pub(crate) skin: u32,
    /// Groups of four joints per vertex; 0 without a skin.
    pub(crate) joint_sets: u32,
    /// Among the poses: the rows of each joint.
    pub(crate) joints: u32,
    /// Among the poses: the targets with a weight.
    pub(crate) targets: u32,
    pub(crate) target_count: u32,
}

const _: () = assert!(size_of::<Deformation>() == 32);

/// Words of a vertex at rest.
pub(crate) const REST_WORDS: u32 = 7;

const GROUP_THREADS: u32 = 64;

/// The most workgroups: more do not make it faster, and every device allows 65535.
const GROUPS_MAX: u32 = 4096;

impl DeformPass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// A failed call.
    pub(crate) fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let push_bytes = size_of::<Deformation>() as u32;
        let storage = StorageLayout { buffers: 4, push_bytes, ..StorageLayout::default() };
        let name = "deform.comp";
        Ok(Self { pipeline: ComputePipeline::new(device, name, shaders.find(name)?, storage)? })
    }

    /// Deforms meshes, each at most once. Commands that were recorded before, in this frame or an
    /// earlier one, still read the old form: one queue runs them all.
    pub(crate) fn record(
        &self,
        commands: &Commands,
        io: &DeformIo,
        deformations: impl Iterator<Item = Deformation>,
    ) {
        let between = MemoryBarrier::between;
        commands.pass("skin meshes", |commands| {
            let before = [Access::AttributeRead, Access::ComputeWrite];
            commands.barrier(between(&before, &[Access::ComputeWrite]));
            let buffers = [io.vertices, io.surfaces, io.forms, io.poses];
            commands.bind_compute(&self.pipeline, &buffers);
            for deformation in deformations {
                commands.push_compute_constants(&self.pipeline, &deformation);
                let groups = deformation.vertex_count.div_ceil(GROUP_THREADS);
                commands.dispatch([groups.clamp(1, GROUPS_MAX), 1, 1]);
            }
            commands.barrier(between(&[Access::ComputeWrite], &[Access::AttributeRead]));
        });
    }
}
