//! Reads meshes back for section planes, since renderers keep no meshes on the CPU.

use gpu::{Buffer, Device};
use scene::Vertex;

use super::SectionMeshes;
use crate::error::Error;
use crate::resources::geometry::Geometry;
use crate::resources::limits::check_memory;
use crate::resources::mesh_slots::Residency;
use crate::resources::volume_meshes::copied_back;

/// The memory that stays for each vertex (bytes).
const BYTES_PER_VERTEX: usize = size_of::<glam::Vec3>();

/// The most memory for each vertex, and for each index, while the shell of a mesh is found: its
/// positions, and tables of places, triangles and edges while they grow (bytes).
const SHELL_BYTES_PER_VERTEX: usize = 96;
const SHELL_BYTES_PER_INDEX: usize = 64;

/// The most memory for the shaders of the passes that cut, of which there are copies while they are
/// compiled (bytes).
const SHADER_BYTES: usize = 2 << 20;

/// Refuses meshes for whose points and shells there is no memory.
fn check_room(geometry: &Geometry) -> Result<(), Error> {
    let mut kept_bytes = 0;
    let mut shell_bytes = 0;
    for (mesh, _, place) in geometry.meshes.placed() {
        let vertices = place.vertices.len();
        let indices = place.draws(mesh).map(|(_, range)| range.len()).max().unwrap_or(0);
        kept_bytes += vertices * BYTES_PER_VERTEX;
        shell_bytes =
            shell_bytes.max(vertices * SHELL_BYTES_PER_VERTEX + indices * SHELL_BYTES_PER_INDEX);
    }
    check_memory("the meshes that section planes cut", kept_bytes + shell_bytes + SHADER_BYTES, 1)
}

/// Reads the meshes that the GPU holds. Waits for copies.
pub(crate) fn read_meshes(device: &Device, geometry: &Geometry) -> Result<SectionMeshes, Error> {
    check_room(geometry)?;
    let [vertices, indices] = [&geometry.vertices, &geometry.indices].map(Buffer::whole);
    let vertices = copied_back(device, vertices)?;
    let indices = copied_back(device, indices)?;
    let mut all = SectionMeshes::default();
    for (mesh, residency, place) in geometry.meshes.placed() {
        // Poses and sprites change the shape of a mesh.
        if residency == Residency::Uploading || geometry.changes_shape(mesh) {
            continue;
        }
        let range = place.vertices.start as usize..place.vertices.end as usize;
        all.add_vertices(mesh, vertices.read::<Vertex>(range));
        let triangles = place
            .draws(mesh)
            .map(|(id, range)| (id, indices.read::<u32>(range.start as usize..range.end as usize)));
        all.add_shells(mesh, triangles);
    }
    for (mesh, prepared, place) in geometry.uploads.meshes() {
        all.add(mesh, prepared, place);
    }
    Ok(all)
}
