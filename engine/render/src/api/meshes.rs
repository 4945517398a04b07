//! Meshes that come and go while the renderer runs.

use occlusion::ScenePartsMut;
use scene::{MeshId, PreparedMesh};

use crate::error::Error;
use crate::renderer::Renderer;
use crate::resources::mesh_slots::Residency;

impl Renderer {
    /// Adds meshes, and returns their ids in the same order: all of them, or none. An id may have
    /// belonged to a mesh that was removed. There must be room ([`RendererOptions::spare`]).
    ///
    /// Nothing waits: each frame copies some bytes
    /// ([`RendererOptions::upload_bytes_per_frame`]) of what was added first. Objects can have a
    /// mesh at once, and are drawn once it is [resident](Renderer::is_resident). Until then they
    /// hide nothing.
    ///
    /// Meshes for transparent objects and skinned ones cannot be added.
    ///
    /// # Errors
    /// [`Error::Mesh`] for a mesh without a surface in a scene with surfaces or the other way
    /// round, for a material that the scene lacks or that blends; [`Error::CapacityExceeded`].
    ///
    /// [`RendererOptions::spare`]: crate::RendererOptions::spare
    /// [`RendererOptions::upload_bytes_per_frame`]: crate::RendererOptions::upload_bytes_per_frame
    pub fn add_meshes(&mut self, meshes: Vec<PreparedMesh>) -> Result<Vec<MeshId>, Error> {
        let geometry = &mut self.passes.gpu_scene.geometry;
        for (index, mesh) in meshes.iter().enumerate() {
            geometry.check_mesh(mesh).map_err(|reason| Error::Mesh { index, reason })?;
        }
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
        self.passes.edges.take(&self.passes.gpu_scene.geometry, &added);
        Ok(added)
    }

    /// Removes meshes: all of them, or none. Frames on their way still draw them; their room is
    /// free at once.
    ///
    /// # Errors
    /// [`Error::Mesh`] for one that is not there or named twice, that an object has, that is
    /// skinned or one of sprites.
    pub fn remove_meshes(&mut self, meshes: &[MeshId]) -> Result<(), Error> {
        let geometry = &mut self.passes.gpu_scene.geometry;
        for (index, mesh) in meshes.iter().enumerate() {
            let is_new = !meshes[..index].contains(mesh);
            let checked = geometry.meshes.check_removal(*mesh);
            let checked = checked.and(if is_new { Ok(()) } else { Err("it is named twice") });
            checked.map_err(|reason| Error::Mesh { index, reason })?;
        }
        for mesh in meshes {
            geometry.remove_mesh(*mesh, self.scene.parts_mut().leaves);
        }
        Ok(())
    }

    /// Returns true if a mesh is on the GPU, so that its objects are drawn.
    pub fn is_resident(&self, mesh: MeshId) -> bool {
        let residency = self.passes.gpu_scene.geometry.meshes.residency(mesh);
        matches!(residency, Residency::Resident | Residency::Kept)
    }

    /// Returns true while some mesh is on its way to the GPU: each frame brings it closer.
    pub fn is_uploading(&self) -> bool {
        !self.passes.gpu_scene.geometry.uploads.is_empty()
    }

    /// Draws the objects of meshes that the last frame completed, from the next one on.
    pub(crate) fn show_arrived(&mut self) {
        let ScenePartsMut { hierarchy, leaves, .. } = self.scene.parts_mut();
        if self.passes.gpu_scene.geometry.show_arrived(hierarchy, leaves) {
            self.revision.advance();
            self.passes.shadows.forget();
        }
    }
}
