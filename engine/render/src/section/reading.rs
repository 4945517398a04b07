//! Reads meshes back for section planes, since renderers keep no meshes on the CPU.

use gpu::{Buffer, Device};
use scene::Vertex;

use super::SectionMeshes;
use crate::error::Error;
use crate::resources::geometry::Geometry;
use crate::resources::mesh_slots::Residency;
use crate::resources::volume_meshes::copied_back;

/// Reads the meshes that the GPU holds. Waits for copies.
pub(crate) fn read_meshes(device: &Device, geometry: &Geometry) -> Result<SectionMeshes, Error> {
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
