//! The geometry of objects for section planes.

use cull::{LeafIndex, ObjectId};
use gpu::IndirectDraw;
use occlusion::MeshDrawId;
use scene::{MeshId, unpack_unorm};

use super::super::{Geometry, NO_MESH};
use crate::resources::instance::Instance;

impl Geometry {
    pub(crate) fn mesh_of(&self, object: ObjectId) -> Option<MeshId> {
        let mesh = self.object_meshes.get(object.0 as usize).filter(|mesh| **mesh != NO_MESH);
        mesh.copied().map(MeshId)
    }

    /// Returns the vertex shader's data of an object.
    pub(crate) fn instance(&self, object: ObjectId) -> Option<&Instance> {
        self.object_instances.get(object.0 as usize)
    }

    /// Returns true if a mesh is not drawn at the positions of its vertices: in a pose, or as
    /// sprites.
    pub(crate) fn changes_shape(&self, mesh: MeshId) -> bool {
        let surfaces = self.surfaces.as_ref();
        self.is_skinned(mesh) || surfaces.is_some_and(|surfaces| surfaces.is_of_sprites(mesh))
    }

    /// Returns the draw of a mesh, or of a coarser level, for a leaf.
    pub(crate) fn leaf_draw(&self, draw: MeshDrawId, leaf: LeafIndex) -> Option<IndirectDraw> {
        let mesh = self.mesh_draws.get(draw.0 as usize)?;
        Some(IndirectDraw { first_instance: leaf.0, instance_count: 1, ..mesh.draw })
    }

    /// Returns the linear colour of an object where it is cut open: the colour of its mesh without
    /// textures, which is the colour of its first material, times its tint.
    pub(crate) fn section_colour(&self, object: ObjectId) -> [f32; 3] {
        const WHITE: [f32; 3] = [1.0; 3];
        let (Some(mesh), Some(instance)) = (self.mesh_of(object), self.instance(object)) else {
            return WHITE;
        };
        let vertex = self.section_meshes.as_ref().map_or(u32::MAX, |meshes| meshes.colour(mesh));
        let [red, green, blue, share] = unpack_unorm(vertex);
        let [r, g, b, _] = match &self.surfaces {
            None => instance.tail.map(f32::from_bits),
            Some(_) => unpack_unorm(instance.tail[2] >> 8),
        };
        let tint = [r, g, b];
        let own = [red, green, blue];
        std::array::from_fn(|part| own[part] * (1.0 + (tint[part] - 1.0) * share))
    }

    /// Returns the number of objects whose material is masked.
    pub(crate) fn masked_objects(&self) -> usize {
        let Some(surfaces) = &self.surfaces else { return 0 };
        let meshes = self.object_meshes.iter().filter(|mesh| **mesh != NO_MESH);
        meshes.filter(|mesh| surfaces.has_holes(MeshId(**mesh))).count()
    }
}
