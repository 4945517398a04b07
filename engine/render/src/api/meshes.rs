//! Meshes that are added and removed while the renderer runs.

use occlusion::ScenePartsMut;
use scene::{MeshId, PreparedMesh};

use crate::error::Error;
use crate::renderer::Renderer;
use crate::resource_errors::MeshError;
use crate::resources::mesh_slots::Residency;

impl Renderer {
    /// Adds meshes, all or none, and returns their ids in the same order. An id may have belonged
    /// to a mesh that was removed. There must be room ([`RendererOptions::spare`]).
    ///
    /// Nothing waits: each frame copies a number of bytes
    /// ([`RendererOptions::upload_bytes_per_frame`]), in the order in which things were added.
    /// Objects can have a mesh at once, and are drawn once it is [resident](Renderer::is_resident).
    /// Until then they hide nothing.
    ///
    /// Meshes for transparent objects and skinned meshes cannot be added.
    ///
    /// # Errors
    /// [`Error::Mesh`] for a mesh without a surface in a scene with surfaces, or the other way
    /// round, and for a material that the scene lacks or that blends; [`Error::CapacityExceeded`].
    ///
    /// [`RendererOptions::spare`]: crate::RendererOptions::spare
    /// [`RendererOptions::upload_bytes_per_frame`]: crate::RendererOptions::upload_bytes_per_frame
    pub fn add_meshes(&mut self, meshes: Vec<PreparedMesh>) -> Result<Vec<MeshId>, Error> {
        let geometry = &mut self.passes.gpu_scene.geometry;
        for (index, mesh) in meshes.iter().enumerate() {
            geometry.check_mesh(mesh).map_err(|reason| Error::Mesh { index, reason })?;
        }
        let kept = self.kept.as_ref().map(|_| meshes.clone());
        let mut added = Vec::with_capacity(meshes.len());
        for mesh in meshes {
            match geometry.add_mesh(mesh, self.scene.parts_mut().leaves) {
                Ok(id) => added.push(id),
                Err(error) => {
                    let leaves = self.scene.parts_mut().leaves;
                    added.into_iter().for_each(|id| geometry.remove_mesh(id, leaves));
                    return Err(error);
                }
            }
        }
        self.has_other_content = true;
        self.passes.edges.take(&self.passes.gpu_scene.geometry, &added);
        if let (Some(all), Some(meshes)) = (&mut self.kept, kept) {
            all.meshes.extend(added.iter().copied().zip(meshes));
        }
        Ok(added)
    }

    /// Removes meshes, all or none. Frames in flight still draw them; their room is free at once.
    ///
    /// # Errors
    /// [`Error::Mesh`] for a mesh that does not exist, is named twice, belongs to an object, is
    /// skinned, or consists of sprites.
    pub fn remove_meshes(&mut self, meshes: &[MeshId]) -> Result<(), Error> {
        let geometry = &mut self.passes.gpu_scene.geometry;
        for (index, mesh) in meshes.iter().enumerate() {
            let is_new = !meshes[..index].contains(mesh);
            let checked = geometry.meshes.check_removal(*mesh);
            let checked = checked.and(if is_new { Ok(()) } else { Err(MeshError::NamedTwice) });
            checked.map_err(|reason| Error::Mesh { index, reason })?;
        }
        self.has_other_content = true;
        for mesh in meshes {
            geometry.remove_mesh(*mesh, self.scene.parts_mut().leaves);
            if let Some(kept) = &mut self.kept {
                kept.meshes.remove(mesh);
            }
        }
        Ok(())
    }

    /// Returns true if a mesh is on the GPU, so that its objects are drawn.
    pub fn is_resident(&self, mesh: MeshId) -> bool {
        let residency = self.passes.gpu_scene.geometry.meshes.residency(mesh);
        matches!(residency, Residency::Resident | Residency::Kept)
    }

    /// Returns true while a mesh is being uploaded. Each frame uploads a part.
    pub fn is_uploading(&self) -> bool {
        !self.passes.gpu_scene.geometry.uploads.is_empty()
    }

    /// Draws, from the next frame on, the objects of meshes that the last frame completed.
    pub(crate) fn show_arrived(&mut self) {
        let ScenePartsMut { hierarchy, leaves, .. } = self.scene.parts_mut();
        if self.passes.gpu_scene.geometry.show_arrived(hierarchy, leaves) {
            self.revision.advance();
            self.passes.shadows.forget();
        }
    }
}
