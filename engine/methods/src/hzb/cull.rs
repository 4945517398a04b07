//! The compute passes of the pyramid strategy: one before the pyramid is built, one that tests
//! against it.

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use gpu::{Access, BufferSlice, Commands, ComputePipeline, Device, MemoryBarrier, StorageLayout};

use occlusion::{Error, ShaderSet};

/// The number of threads in a workgroup, `local_size_x` of the shaders.
const GROUP: u32 = 64;

/// The factor on the growth of boxes that covers rounding in the shader.
const GROWTH_SLACK: f32 = 1.0 + 1.0 / 1024.0;

/// The pass that decides about every leaf: in the first phase by the last frame, in the second by
/// the pyramid.
pub(crate) struct HzbCullPass {
    first: ComputePipeline,
    second: ComputePipeline,
}

/// The buffers of the pass. Boxes, leaves and depths are read; the visibility of leaves is read and
/// written; the list of draws and its counters are written.
#[derive(Clone, Copy)]
pub(crate) struct HzbCullIo {
    /// The box of each leaf, a `ProxyBox` that is not enlarged.
    pub(crate) boxes: BufferSlice,
    /// The draw of each leaf.
    pub(crate) leaves: BufferSlice,
    /// A value per leaf, for one view.
    pub(crate) seen: BufferSlice,
    /// Room for a draw per leaf.
    pub(crate) list: BufferSlice,
    /// The [`Counters`] of each phase, zeroed before the first phase.
    pub(crate) counters: BufferSlice,
    /// The depth pyramid.
    pub(crate) depths: BufferSlice,
    /// The number of leaves.
    pub(crate) leaf_count: u32,
    pub(crate) list_kind: ListKind,
}

/// The kind of a list of draws in its buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ListKind {
    /// Only the drawn leaves; their count is on the GPU.
    Compact,
    /// An entry for every leaf, without instances if the leaf is not drawn.
    EveryLeaf,
}

/// The two phases of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// The leaves that were visible in the last frame.
    First,
    /// The leaves that turn out to be visible.
    Second,
}

/// The counts of a phase's draws; mirrors `pyramid.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub(crate) struct Counters {
    pub(crate) draws: u32,
    triangles: [u32; 2],
    unused: u32,
}

const _: () = assert!(size_of::<Counters>() == 16);

impl Counters {
    /// Returns the number of triangles of the drawn objects.
    pub(crate) fn triangles(&self) -> u64 {
        u64::from(self.triangles[0]) | u64::from(self.triangles[1]) << 32
    }
}

/// The push constants; mirrors `pyramid.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    row_x: [f32; 4],
    row_y: [f32; 4],
    row_w: [f32; 4],
    row_depth: [f32; 4],
    origin: [f32; 3],
    leaf_count: u32,
    depth_terms: [f32; 2],
    near: f32,
    phase: u32,
    size: [u32; 2],
    is_compact: u32,
}

const _: () = assert!(size_of::<Constants>() == 108);

impl HzbCullPass {
    /// Compiles both phases.
    pub(crate) fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let phase = |name, shader, buffers| {
            let storage = StorageLayout::new::<Constants>(buffers);
            ComputePipeline::new(device, name, shaders.find(shader)?, storage).map_err(Error::from)
        };
        Ok(Self {
            first: phase("pyramid first", "pyramid_first.comp", 5)?,
            second: phase("pyramid second", "pyramid_second.comp", 6)?,
        })
    }

    /// Decides about all leaves. Outside of rendering. Afterwards indirect draws may read the list
    /// and the counters, and copies may read the counters.
    pub(crate) fn record(
        &self,
        commands: &Commands,
        io: &HzbCullIo,
        view: &CullView,
        phase: Phase,
    ) {
        let between = MemoryBarrier::between;
        let buffers = [io.boxes, io.leaves, io.seen, io.list, io.counters, io.depths];
        let (pipeline, buffers) = match phase {
            Phase::First => (&self.first, &buffers[..5]),
            Phase::Second => (&self.second, &buffers[..]),
        };
        commands.bind_compute(pipeline, buffers);
        commands.push_compute_constants(pipeline, &Constants::new(io, view, phase));
        commands.dispatch([io.leaf_count.div_ceil(GROUP), 1, 1]);
        commands.barrier(between(
            &[Access::ComputeWrite],
            &[Access::IndirectRead, Access::CopyRead, Access::ComputeRead, Access::ComputeWrite],
        ));
    }
}

impl Constants {
    fn new(io: &HzbCullIo, view: &CullView, phase: Phase) -> Self {
        let rays = &view.rays;
        let [growth_m, _] = view.margin.metres();
        let [row_x, row_y] = rays.rows_xy();
        Self {
            row_x: row_x.extend(growth_m * GROWTH_SLACK).to_array(),
            row_y: row_y.extend(rays.coordinate).to_array(),
            row_w: rays.row_w().to_array(),
            row_depth: rays.forward.extend(view.margin.nearest_m()).to_array(),
            origin: rays.origin.to_array(),
            leaf_count: io.leaf_count,
            depth_terms: rays.depth,
            near: rays.near,
            phase: u32::from(phase == Phase::Second),
            size: view.size,
            is_compact: u32::from(io.list_kind == ListKind::Compact),
        }
    }
}
