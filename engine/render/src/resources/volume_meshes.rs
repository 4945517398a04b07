//! Meshes in the form that shadow volumes are extruded from: the triangles of each draw with
//! adjacency. Only renderers that draw volumes have them. They are built from the meshes on the
//! GPU.

use ::shadows::{Enclosure, VolumeMesh, VolumeSource};
use glam::Vec3;
use gpu::{Access, Buffer, BufferSlice, Device, IndirectDraw, MemoryBarrier, MemoryKind, vk};
use occlusion::MeshDrawId;
use scene::{Mesh, MeshId, PreparedMesh, Vertex};

use crate::error::Error;
use crate::passes::VolumePath;
use crate::resources::geometry::Geometry;
use crate::resources::limits::{check_storage, room};
use crate::resources::mesh_slots::{MeshPlace, Residency};
use crate::resources::skinned_meshes::SkinnedMeshes;

/// The number of values of a triangle with adjacency, per value of the triangle. Its offset is
/// twice the offset of the triangle's indices, so it needs no allocation of its own.
pub(crate) const ADJACENCY_PER_INDEX: usize = 2;

/// The triangles with adjacency of all meshes that cast volumes.
pub(crate) struct VolumeMeshes {
    adjacency: Buffer,
    // By `MeshDrawId`.
    draws: Vec<VolumeDraw>,
}

/// The triangles of one draw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct VolumeDraw {
    triangles: u32,
    pub(crate) enclosure: Enclosure,
}

impl VolumeDraw {
    fn of(volumes: &VolumeMesh, changes_shape: bool) -> Self {
        let triangles = volumes.triangles().len() as u32;
        // A mesh that is closed at rest may be folded inside out in a pose.
        let enclosure = if changes_shape { Enclosure::None } else { volumes.enclosure() };
        Self { triangles, enclosure }
    }

    /// Returns the draw of the triangles with adjacency, from the `draw` of the triangles.
    pub(crate) fn draw(&self, draw: IndirectDraw) -> IndirectDraw {
        IndirectDraw {
            index_count: 6 * self.triangles,
            first_index: ADJACENCY_PER_INDEX as u32 * draw.first_index,
            ..draw
        }
    }
}

/// The vertices and triangles of meshes, copied back from the GPU.
pub(super) struct Contents {
    vertices: Buffer,
    pub(super) indices: Buffer,
    mesh_data: Option<Buffer>,
}

impl VolumeMeshes {
    /// Builds the volumes of all meshes that cast volumes. Waits for copies.
    pub(crate) fn new(
        device: &Device,
        geometry: &Geometry,
        skinned_meshes: Option<&SkinnedMeshes>,
    ) -> Result<Self, Error> {
        let [vertices, indices] = [&geometry.vertices, &geometry.indices].map(Buffer::whole);
        let index_count = indices.size_bytes as usize / size_of::<u32>();
        if VolumePath::of(device) == VolumePath::Compute {
            const SIMPLER: &str = "use simpler meshes, or shadow maps";
            let vertex_bytes = size_of::<Vertex>() as u64;
            let count = vertices.size_bytes / vertex_bytes;
            check_storage(device, "vertices with shadow volumes", count, vertex_bytes, SIMPLER)?;
            let count = (ADJACENCY_PER_INDEX * index_count) as u64;
            check_storage(device, "indices of shadow volumes", count, 4, SIMPLER)?;
        }
        let mut adjacency =
            room("the triangles of shadow volumes", ADJACENCY_PER_INDEX * index_count)?;
        adjacency.resize(ADJACENCY_PER_INDEX * index_count, 0);
        let mut draws = vec![VolumeDraw::default(); geometry.mesh_draws().len()];
        let contents = Contents::copied_back(device, geometry, skinned_meshes)?;
        let mut put = |id: MeshDrawId, first: u32, volumes: &VolumeMesh, changes_shape: bool| {
            let place = ADJACENCY_PER_INDEX * first as usize;
            let values = volumes.triangles().as_flattened();
            if let (Some(there), Some(draw)) =
                (adjacency.get_mut(place..place + values.len()), draws.get_mut(id.0 as usize))
            {
                there.copy_from_slice(values);
                *draw = VolumeDraw::of(volumes, changes_shape);
            }
        };
        for (mesh, residency, place) in geometry.meshes.placed() {
            if !geometry.casts_volumes(mesh) || residency == Residency::Uploading {
                continue;
            }
            let (positions, motions) = contents.vertices_of(mesh, place, skinned_meshes);
            for (id, indices) in place.draws(mesh) {
                let triangles =
                    contents.indices.read::<u32>(indices.start as usize..indices.end as usize);
                if let Some(volumes) = volume_mesh(&positions, &motions, triangles) {
                    put(id, indices.start, &volumes, !motions.is_empty());
                }
            }
        }
        for (mesh, prepared, place) in geometry.uploads.meshes() {
            for ((id, indices), volumes) in place.draws(mesh).zip(volumes_of(prepared)) {
                if let Some(volumes) = volumes.filter(|_| geometry.casts_volumes(mesh)) {
                    put(id, indices.start, &volumes, false);
                }
            }
        }
        let usage = vk::BufferUsageFlags::INDEX_BUFFER | vk::BufferUsageFlags::STORAGE_BUFFER;
        Ok(Self { adjacency: device.upload("adjacency", &adjacency, usage)?, draws })
    }

    /// Returns the triangles with adjacency of all draws.
    pub(crate) fn adjacency(&self) -> BufferSlice {
        self.adjacency.whole()
    }

    /// Returns the triangles of a draw, if it casts volumes.
    pub(crate) fn get(&self, draw: MeshDrawId) -> Option<&VolumeDraw> {
        self.draws.get(draw.0 as usize).filter(|draw| draw.triangles > 0)
    }

    /// Takes a mesh that is being uploaded. Returns the values to upload for each of its draws.
    pub(crate) fn add(
        &mut self,
        id: MeshId,
        mesh: &PreparedMesh,
        place: &MeshPlace,
    ) -> Vec<Vec<u32>> {
        let mut values = Vec::with_capacity(place.indices.len());
        for ((id, _), volumes) in place.draws(id).zip(volumes_of(mesh)) {
            if let (Some(draw), Some(volumes)) = (self.draws.get_mut(id.0 as usize), &volumes) {
                *draw = VolumeDraw::of(volumes, false);
            }
            let triangles = volumes.as_ref().map_or(&[][..], VolumeMesh::triangles);
            values.push(triangles.as_flattened().to_vec());
        }
        values
    }

    /// Removes a draw.
    pub(crate) fn remove(&mut self, draw: MeshDrawId) {
        if let Some(draw) = self.draws.get_mut(draw.0 as usize) {
            *draw = VolumeDraw::default();
        }
    }
}

impl Contents {
    /// Copies the meshes of a renderer back, and waits for the copy.
    pub(super) fn copied_back(
        device: &Device,
        geometry: &Geometry,
        skinned_meshes: Option<&SkinnedMeshes>,
    ) -> Result<Self, Error> {
        Ok(Self {
            vertices: copied_back(device, geometry.vertices.whole())?,
            indices: copied_back(device, geometry.indices.whole())?,
            mesh_data: skinned_meshes
                .map(|skinned_mesh| copied_back(device, skinned_mesh.mesh_data()))
                .transpose()?,
        })
    }

    /// Returns the positions of a mesh, at rest, and their motions if it is skinned.
    pub(super) fn vertices_of(
        &self,
        mesh: MeshId,
        place: &MeshPlace,
        skinned_meshes: Option<&SkinnedMeshes>,
    ) -> (Vec<Vec3>, Vec<u32>) {
        if let (Some(data), Some(state)) =
            (&self.mesh_data, skinned_meshes.and_then(|all| all.of_mesh(mesh)))
        {
            return state.at_rest(data.read(0..data.size_bytes() as usize / size_of::<u32>()));
        }
        let vertices = place.vertices.start as usize..place.vertices.end as usize;
        let vertices = self.vertices.read::<Vertex>(vertices).iter();
        (vertices.map(|vertex| vertex.position.into()).collect(), Vec::new())
    }
}

/// Copies a buffer to a new buffer that the CPU can read.
pub(crate) fn copied_back(device: &Device, from: BufferSlice) -> Result<Buffer, Error> {
    let usage = vk::BufferUsageFlags::TRANSFER_DST;
    let to = Buffer::new(device, "meshes", from.size_bytes, usage, MemoryKind::ReadBack)?;
    device.run_once("copy meshes back", |commands| {
        let between = MemoryBarrier::between;
        commands.barrier(between(&[Access::Any], &[Access::CopyRead]));
        commands.copy_buffer(from, to.whole());
        commands.barrier(between(&[Access::CopyWrite], &[Access::HostRead]));
    })?;
    Ok(to)
}

/// Returns the volumes of a mesh and of its coarser levels.
fn volumes_of(mesh: &PreparedMesh) -> impl Iterator<Item = Option<VolumeMesh>> {
    let of_mesh: &Mesh = mesh.mesh();
    let positions: Vec<Vec3> =
        of_mesh.vertices.iter().map(|vertex| vertex.position.into()).collect();
    let levels = mesh.levels().iter().map(|level| &level.indices);
    let all = std::iter::once(&of_mesh.indices).chain(levels);
    all.map(move |indices| volume_mesh(&positions, &[], indices))
}

/// Returns the volumes of triangles that have been validated.
fn volume_mesh(positions: &[Vec3], motions: &[u32], triangles: &[u32]) -> Option<VolumeMesh> {
    let volumes = VolumeMesh::new(&VolumeSource { positions, triangles, motions });
    volumes.inspect_err(|error| tracing::error!("a mesh casts no shadow volumes: {error}")).ok()
}
