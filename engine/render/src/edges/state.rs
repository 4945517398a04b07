//! The edges and outlines of a renderer, and the data kept for them.

use cull::{LeafIndex, LeafRange};
use gpu::{Frame, StencilTarget};
use occlusion::{CulledScene, MeshDrawId};
use scene::MeshId;

use super::options::{EdgeMode, EdgeOptions, ObjectOutline};
use crate::error::Error;
use crate::resources::edge_meshes::EdgeMeshes;
use crate::resources::geometry::Geometry;

/// The edges and outlines of a renderer.
#[derive(Default)]
pub(crate) struct Edges {
    pub(crate) options: EdgeOptions,
    pub(crate) outlines: Vec<ObjectOutline>,
    /// The edges of meshes, while edges or outlines are drawn.
    pub(crate) meshes: Option<EdgeMeshes>,
    /// The stencil for marks of outlined objects, which fits the target.
    pub(super) stencil: Option<StencilTarget>,
    /// The leaves of a view, kept to allocate nothing in the steady state.
    pub(super) ranges: Vec<LeafRange>,
}

impl Edges {
    /// Returns true if edges or outlines are drawn.
    pub(crate) fn has_draws(&self) -> bool {
        self.options.mode != EdgeMode::Off || !self.outlines.is_empty()
    }

    /// Drops the images of the former target.
    pub(crate) fn resized(&mut self) {
        self.stencil = None;
    }

    /// Takes meshes that were added and are being uploaded.
    pub(crate) fn take(&mut self, geometry: &Geometry, added: &[MeshId]) {
        let Some(meshes) = &mut self.meshes else { return };
        let coming = geometry.uploads.meshes().filter(|(mesh, ..)| added.contains(mesh));
        coming.for_each(|(id, mesh, place)| meshes.add(id, mesh, place));
    }

    /// Records the upload of what changed since the last frame, before anything of `frame` reads
    /// it.
    pub(crate) fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &CulledScene,
        geometry: &Geometry,
    ) -> Result<(), Error> {
        let Some(meshes) = &mut self.meshes else { return Ok(()) };
        let draw_of = |leaf: &LeafIndex| {
            let object = scene.hierarchy().leaf_objects().get(leaf.0 as usize);
            object.map_or(MeshDrawId::NONE, |object| geometry.draw_of(*object))
        };
        meshes.upload(frame, scene.leaves(), &scene.passes().scatter, draw_of)
    }

    /// Notes that the frame of the last upload was submitted.
    pub(crate) fn submitted(&mut self) {
        if let Some(meshes) = &mut self.meshes {
            meshes.submitted();
        }
    }
}
