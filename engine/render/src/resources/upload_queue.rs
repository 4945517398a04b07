//! The queue of meshes and textures to upload: some bytes per frame, in the order of their
//! addition. So the textures of a mesh's material are always complete when the mesh is.

use std::collections::VecDeque;

use gpu::{Access, BufferSlice, Frame, MemoryBarrier, TextureArray, TextureRows};
use scene::{MeshId, PreparedMesh, PreparedTexture, SurfaceVertex, Texels, TextureId, Vertex};

use crate::error::Error;
use crate::resources::mesh_slots::MeshPlace;
use crate::resources::volume_meshes::ADJACENCY_PER_INDEX;
use crate::shading::surfaces::{SurfaceTextures, TexturePlace, TextureStorage};

/// The arrays that meshes and textures are copied to.
#[derive(Clone, Copy)]
pub(crate) struct UploadTargets<'a> {
    pub(crate) vertices: BufferSlice,
    /// The surfaces, if the scene has surfaces.
    pub(crate) surfaces: Option<BufferSlice>,
    pub(crate) indices: BufferSlice,
    /// The triangles with adjacency, if the renderer draws shadow volumes.
    pub(crate) adjacency: Option<BufferSlice>,
    /// The textures, if the scene has textures.
    pub(crate) textures: Option<&'a SurfaceTextures>,
}

/// A mesh or a texture that is not completely on the GPU.
enum PendingUpload {
    Mesh {
        id: MeshId,
        mesh: PreparedMesh,
        place: MeshPlace,
        /// The triangles with adjacency of each draw, for shadow volumes.
        adjacency: Vec<Vec<u32>>,
    },
    Texture {
        id: TextureId,
        texture: PreparedTexture,
        place: TexturePlace,
        levels: Vec<Vec<u8>>,
        /// True if no frame has used it yet.
        is_new: bool,
    },
}

/// Bytes with a common destination.
struct Section<'a> {
    bytes: &'a [u8],
    to: Destination,
}

#[derive(Clone, Copy)]
enum Destination {
    Array(BufferSlice),
    Level { place: TexturePlace, level: u32, row_bytes: usize },
}

/// A copy in a frame.
#[derive(Clone, Copy)]
enum QueuedCopy {
    Buffer {
        from: BufferSlice,
        to: BufferSlice,
    },
    Rows {
        from: BufferSlice,
        place: TexturePlace,
        rows: TextureRows,
    },
    /// The mip maps of a texture whose rows are complete.
    Levels(TexturePlace),
}

/// The queue of meshes and textures.
pub(crate) struct UploadQueue {
    /// The highest number of bytes per frame, except for a single row of a texture.
    frame_bytes: usize,
    queue: VecDeque<PendingUpload>,
    /// The bytes of the first item that frames have copied.
    copied: usize,
    /// The number of completed items and the copied bytes of the next one, for when the newest
    /// frame is submitted.
    recorded: (usize, usize),
    arrived: Vec<MeshId>,
    copies: Vec<QueuedCopy>,
}

impl UploadQueue {
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

    /// Sets the highest number of bytes per frame, except for a single row of a texture.
    pub(crate) fn set_frame_bytes(&mut self, frame_bytes: usize) {
        self.frame_bytes = frame_bytes.max(1);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// Adds a mesh, with the triangles with adjacency of each of its draws, if there are any.
    pub(crate) fn push_mesh(
        &mut self,
        id: MeshId,
        mesh: PreparedMesh,
        place: MeshPlace,
        adjacency: Vec<Vec<u32>>,
    ) {
        self.queue.push_back(PendingUpload::Mesh { id, mesh, place, adjacency });
    }

    pub(crate) fn meshes(&self) -> impl Iterator<Item = (MeshId, &PreparedMesh, &MeshPlace)> {
        self.queue.iter().filter_map(|pending| match pending {
            PendingUpload::Mesh { id, mesh, place, .. } => Some((*id, mesh, place)),
            PendingUpload::Texture { .. } => None,
        })
    }

    /// Removes the triangles with adjacency from all meshes in the queue: they are on the GPU, or
    /// are not needed.
    pub(crate) fn drop_adjacency(&mut self) {
        for pending in &mut self.queue {
            if let PendingUpload::Mesh { adjacency, .. } = pending {
                adjacency.clear();
            }
        }
    }

    /// Adds a texture, with the mip maps that the device does not generate.
    pub(crate) fn push_texture(
        &mut self,
        id: TextureId,
        texture: PreparedTexture,
        place: TexturePlace,
        levels: Vec<Vec<u8>>,
    ) {
        self.queue.push_back(PendingUpload::Texture { id, texture, place, levels, is_new: true });
    }

    /// Removes a mesh.
    pub(crate) fn cancel_mesh(&mut self, mesh: MeshId) {
        self.cancel(|pending| matches!(pending, PendingUpload::Mesh { id, .. } if *id == mesh));
    }

    /// Removes a texture.
    pub(crate) fn cancel_texture(&mut self, texture: TextureId) {
        self.cancel(
            |pending| matches!(pending, PendingUpload::Texture { id, .. } if *id == texture),
        );
    }

    fn cancel(&mut self, is_gone: impl Fn(&PendingUpload) -> bool) {
        if self.queue.front().is_some_and(&is_gone) {
            self.copied = 0;
        }
        self.queue.retain(|pending| !is_gone(pending));
    }

    /// Records the copies of a frame, after everything that may read the old contents. They count
    /// once the frame is [submitted](UploadQueue::submitted).
    pub(crate) fn record(
        &mut self,
        frame: &mut Frame<'_>,
        targets: UploadTargets<'_>,
    ) -> Result<(), Error> {
        self.plan_copies(frame, targets)?;
        if self.copies.is_empty() {
            return Ok(());
        }
        let array = |place| targets.textures.and_then(|textures| textures.array(place));
        frame.commands().pass("stream meshes and textures", |commands| {
            self.new_images(targets).for_each(|image| commands.open_texture(image));
            commands.barrier(MemoryBarrier::between(&[Access::Any], &[Access::CopyWrite]));
            for copy in &self.copies {
                match *copy {
                    QueuedCopy::Buffer { from, to } => commands.copy_buffer(from, to),
                    QueuedCopy::Rows { from, place, rows } => {
                        if let Some(array) = array(place) {
                            commands.write_texture(array, rows, from);
                        }
                    }
                    QueuedCopy::Levels(place) => {
                        if let Some(array) = array(place) {
                            commands.make_texture_levels(array, place.layer);
                        }
                    }
                }
            }
            commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::Any]));
        });
        Ok(())
    }

    /// Returns the images of textures with their own images that no frame has used. The next frame
    /// must open them even if it does not copy to them, since its draws may sample them.
    fn new_images<'a>(&self, targets: UploadTargets<'a>) -> impl Iterator<Item = &'a TextureArray> {
        let has_own = |textures: &&SurfaceTextures| textures.storage() == TextureStorage::Bindless;
        let textures = targets.textures.filter(has_own);
        self.queue.iter().filter_map(move |pending| match pending {
            PendingUpload::Texture { place, is_new: true, .. } => textures?.array(*place),
            _ => None,
        })
    }

    /// Chooses the copies of a frame, and writes their data to its memory.
    fn plan_copies(
        &mut self,
        frame: &mut Frame<'_>,
        targets: UploadTargets<'_>,
    ) -> Result<(), Error> {
        let Self { frame_bytes, queue, copied, recorded, copies, .. } = self;
        *recorded = (0, *copied);
        copies.clear();
        let mut left = *frame_bytes;
        for pending in &*queue {
            let mut begin = 0;
            for Section { bytes, to } in pending.sections(targets) {
                let first = recorded.1.saturating_sub(begin).min(bytes.len());
                let wanted = bytes.len() - first;
                let count = to.bytes_within(left, wanted, copies.is_empty());
                if count > 0 {
                    let from = frame.uploads().push(&bytes[first..first + count])?;
                    copies.push(to.copy(from, first, count));
                }
                // Later items must not overtake the rest of this one.
                left = if count < wanted { 0 } else { left.saturating_sub(count) };
                (begin, recorded.1) = (begin + bytes.len(), recorded.1 + count);
            }
            if recorded.1 < begin {
                break;
            }
            if let PendingUpload::Texture { place, .. } = pending {
                copies.push(QueuedCopy::Levels(*place));
            }
            *recorded = (recorded.0 + 1, 0);
        }
        Ok(())
    }

    /// Notes that the frame of the last [`UploadQueue::record`] was submitted.
    pub(crate) fn submitted(&mut self) {
        let (whole, copied) = std::mem::take(&mut self.recorded);
        self.arrived.extend(self.queue.drain(..whole).filter_map(|pending| match pending {
            PendingUpload::Mesh { id, .. } => Some(id),
            PendingUpload::Texture { .. } => None,
        }));
        self.copied = copied;
        for pending in &mut self.queue {
            if let PendingUpload::Texture { is_new, .. } = pending {
                *is_new = false;
            }
        }
    }

    /// Takes the meshes that are complete for all frames from now on.
    pub(crate) fn take_arrived(&mut self) -> Vec<MeshId> {
        std::mem::take(&mut self.arrived)
    }
}

impl PendingUpload {
    /// Returns the bytes of the mesh or the texture, with the destination of each part.
    fn sections(&self, targets: UploadTargets<'_>) -> impl Iterator<Item = Section<'_>> {
        let of_mesh = match self {
            Self::Mesh { mesh, place, adjacency, .. } => {
                Some(sections_of_mesh(mesh, place, adjacency, targets))
            }
            Self::Texture { .. } => None,
        };
        let of_texture = match self {
            Self::Mesh { .. } => None,
            Self::Texture { texture, place, levels, .. } => {
                Some(sections_of_texture(texture, *place, levels))
            }
        };
        of_mesh.into_iter().flatten().chain(of_texture.into_iter().flatten())
    }
}

fn sections_of_mesh<'a>(
    mesh: &'a PreparedMesh,
    place: &'a MeshPlace,
    adjacency: &'a [Vec<u32>],
    targets: UploadTargets<'_>,
) -> impl Iterator<Item = Section<'a>> {
    let first = u64::from(place.vertices.start);
    let section = |bytes, array: BufferSlice, begin: u64| {
        let to = array.part(begin, array.size_bytes.saturating_sub(begin));
        Section { bytes, to: Destination::Array(to) }
    };
    let bytes = bytemuck::cast_slice(&mesh.mesh().vertices);
    let vertices = section(bytes, targets.vertices, first * size_of::<Vertex>() as u64);
    let surface = mesh.surface().zip(targets.surfaces).map(|(surface, array)| {
        let bytes = bytemuck::cast_slice(&surface.vertices);
        section(bytes, array, first * size_of::<SurfaceVertex>() as u64)
    });
    let levels = mesh.levels().iter().map(|level| &level.indices);
    let parts = std::iter::once(&mesh.mesh().indices).chain(levels).zip(&place.indices);
    let indices = parts.map(move |(part, place)| {
        let begin = u64::from(place.start) * size_of::<u32>() as u64;
        section(bytemuck::cast_slice(part), targets.indices, begin)
    });
    let adjacency = adjacency.iter().zip(&place.indices).filter_map(move |(values, place)| {
        let begin = ADJACENCY_PER_INDEX as u64 * u64::from(place.start) * size_of::<u32>() as u64;
        Some(section(bytemuck::cast_slice(values), targets.adjacency?, begin))
    });
    std::iter::once(vertices).chain(surface).chain(indices).chain(adjacency)
}

fn sections_of_texture<'a>(
    texture: &'a PreparedTexture,
    place: TexturePlace,
    levels: &'a Vec<Vec<u8>>,
) -> impl Iterator<Item = Section<'a>> {
    let image = texture.image();
    let (whole, levels) = match &image.texels {
        Texels::Rgba8(whole) => (Some(whole), levels),
        Texels::Blocks { levels, .. } => (None, levels),
    };
    (0..).zip(whole.into_iter().chain(levels)).map(move |(level, bytes)| {
        let row_bytes = image.row_bytes(level);
        Section { bytes, to: Destination::Level { place, level, row_bytes } }
    })
}

impl Destination {
    /// Returns the number of bytes to copy, out of `wanted`, if `left` may be copied. Textures are
    /// copied in whole rows, at least one if nothing else is copied.
    fn bytes_within(self, left: usize, wanted: usize, is_first: bool) -> usize {
        match self {
            Self::Array(_) => left.min(wanted),
            Self::Level { row_bytes, .. } => {
                let rows = (left / row_bytes).max(usize::from(is_first));
                (rows * row_bytes).min(wanted)
            }
        }
    }

    fn copy(self, from: BufferSlice, first: usize, count: usize) -> QueuedCopy {
        match self {
            Self::Array(array) => {
                QueuedCopy::Buffer { from, to: array.part(first as u64, count as u64) }
            }
            Self::Level { place, level, row_bytes } => {
                let layer = place.layer;
                let [first, count] = [first, count].map(|bytes| (bytes / row_bytes) as u32);
                QueuedCopy::Rows { from, place, rows: TextureRows { layer, level, first, count } }
            }
        }
    }
}
