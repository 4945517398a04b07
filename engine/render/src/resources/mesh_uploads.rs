//! Meshes on their way to the GPU: some bytes with each frame, the first that came first.

use std::collections::VecDeque;

use gpu::{Access, BufferSlice, Frame, MemoryBarrier};
use scene::{MeshId, PreparedMesh, SurfaceVertex, Vertex};

use crate::error::Error;
use crate::resources::mesh_slots::MeshPlace;

/// The arrays that meshes are copied to.
#[derive(Clone, Copy)]
pub(crate) struct MeshArrays {
    pub(crate) vertices: BufferSlice,
    /// The surfaces of a scene that has them.
    pub(crate) surfaces: Option<BufferSlice>,
    pub(crate) indices: BufferSlice,
}

/// A mesh that is not on the GPU as a whole.
struct PendingMesh {
    id: MeshId,
    mesh: PreparedMesh,
    place: MeshPlace,
}

/// The queue of meshes.
pub(crate) struct MeshUploads {
    /// The most bytes of a frame.
    frame_bytes: usize,
    queue: VecDeque<PendingMesh>,
    /// The bytes of the first mesh that frames have copied.
    copied: usize,
    /// The whole meshes and the bytes of the next one, once the newest frame is submitted.
    recorded: (usize, usize),
    arrived: Vec<MeshId>,
    copies: Vec<[BufferSlice; 2]>,
}

impl MeshUploads {
    /// Creates an empty queue.
    pub(crate) fn new(frame_bytes: usize) -> Self {
        Self {
            frame_bytes: frame_bytes.max(1),
            queue: VecDeque::new(),
            copied: 0,
            recorded: (0, 0),
            arrived: Vec::new(),
            copies: Vec::new(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    pub(crate) fn push(&mut self, id: MeshId, mesh: PreparedMesh, place: MeshPlace) {
        self.queue.push_back(PendingMesh { id, mesh, place });
    }

    /// Forgets a mesh.
    pub(crate) fn cancel(&mut self, id: MeshId) {
        if self.queue.front().is_some_and(|first| first.id == id) {
            self.copied = 0;
        }
        self.queue.retain(|pending| pending.id != id);
    }

    /// Records the copies of a frame, behind everything that may read what lay there. They count
    /// once the frame is [submitted](MeshUploads::submitted).
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn record(&mut self, frame: &mut Frame<'_>, to: MeshArrays) -> Result<(), Error> {
        let Self { frame_bytes, queue, copied, recorded, copies, .. } = self;
        *recorded = (0, *copied);
        copies.clear();
        let mut left = *frame_bytes;
        for pending in &*queue {
            let mut begin = 0;
            for (bytes, array) in pending.sections(to) {
                let first = recorded.1.saturating_sub(begin).min(bytes.len());
                let count = left.min(bytes.len() - first);
                if count > 0 {
                    let from = frame.uploads().push(&bytes[first..first + count])?;
                    copies.push([from, array.part(first as u64, count as u64)]);
                }
                (begin, left, recorded.1) = (begin + bytes.len(), left - count, recorded.1 + count);
            }
            if recorded.1 < begin {
                break;
            }
            *recorded = (recorded.0 + 1, 0);
        }
        if copies.is_empty() {
            return Ok(());
        }
        frame.commands().pass("upload meshes", |commands| {
            commands.barrier(MemoryBarrier::between(&[Access::Any], &[Access::CopyWrite]));
            copies.iter().for_each(|[from, to]| commands.copy_buffer(*from, *to));
            commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::Any]));
        });
        Ok(())
    }

    /// Notes that the frame of the last [`MeshUploads::record`] was submitted.
    pub(crate) fn submitted(&mut self) {
        let (whole, copied) = std::mem::take(&mut self.recorded);
        self.arrived.extend(self.queue.drain(..whole).map(|pending| pending.id));
        self.copied = copied;
    }

    /// Takes the meshes that are whole for all frames from now on.
    pub(crate) fn take_arrived(&mut self) -> Vec<MeshId> {
        std::mem::take(&mut self.arrived)
    }
}

impl PendingMesh {
    /// Returns the bytes of the mesh, and the part of the arrays that each run of them goes to.
    fn sections(&self, to: MeshArrays) -> impl Iterator<Item = (&[u8], BufferSlice)> {
        let Self { mesh, place, .. } = self;
        let first = u64::from(place.vertices.start);
        let behind = |array: BufferSlice, bytes: u64| {
            array.part(bytes, array.size_bytes.saturating_sub(bytes))
        };
        let vertices = bytemuck::cast_slice(&mesh.mesh().vertices);
        let vertices = (vertices, behind(to.vertices, first * size_of::<Vertex>() as u64));
        let surface = mesh.surface().zip(to.surfaces).map(|(surface, array)| {
            let bytes: &[u8] = bytemuck::cast_slice(&surface.vertices);
            (bytes, behind(array, first * size_of::<SurfaceVertex>() as u64))
        });
        let levels = mesh.levels().iter().map(|level| &level.indices);
        let indices = std::iter::once(&mesh.mesh().indices).chain(levels).zip(&place.indices);
        let indices = indices.map(move |(indices, place)| {
            let bytes: &[u8] = bytemuck::cast_slice(indices);
            (bytes, behind(to.indices, u64::from(place.start) * size_of::<u32>() as u64))
        });
        std::iter::once(vertices).chain(surface).chain(indices)
    }
}
