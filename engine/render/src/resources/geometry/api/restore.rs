//! The state of a renderer's geometry on another device, after the first was lost.

use std::ops::Range;

use cull::{Aabb, Hierarchy, LeafIndex, ObjectId};
use occlusion::{LeafTable, MeshDrawId};
use scene::{Mesh, MeshId, Scene};

use super::super::Geometry;
use crate::error::Error;
use crate::kept_scene::KeptScene;
use crate::resources::instance::with_lights;
use crate::resources::mesh_slots::Residency;

impl Geometry {
    /// Returns true if a renderer without changes was created from `scene`, as far as the sizes and
    /// boxes of its parts tell.
    pub(crate) fn is_of(&self, scene: &Scene) -> bool {
        let meshes = scene.meshes.iter().zip(&self.mesh_bounds).zip((0..).map(MeshId));
        let is_same_mesh = |((mesh, bounds), id): ((&Mesh, &Aabb), MeshId)| {
            let place = self.meshes.place(id);
            let vertices = place.map_or(0, |place| place.vertices.len());
            let indices = place.and_then(|place| place.indices.first()).map_or(0, Range::len);
            let is_kept = self.meshes.residency(id) == Residency::Kept;
            mesh.bounds == *bounds
                && mesh.vertices.len() == vertices
                && (is_kept || mesh.indices.len() == indices)
        };
        let objects = self.object_meshes.iter().zip(&scene.objects);
        self.meshes.of_scene() == scene.meshes.len()
            && self.object_meshes.len() >= scene.objects.len()
            && self.surfaces.is_some() == scene.surfaces.is_some()
            && meshes.into_iter().all(is_same_mesh)
            && objects.into_iter().all(|(mesh, object)| *mesh == object.mesh.0)
    }

    /// Brings geometry that was uploaded as the kept scene began into the state that it has in
    /// `lost`. `hierarchy` is already that of `lost`. All of it is uploaded with the next changes.
    pub(crate) fn restore(
        &mut self,
        lost: &Self,
        kept: &KeptScene,
        hierarchy: &Hierarchy,
        leaves: &mut LeafTable,
    ) -> Result<(), Error> {
        self.meshes.clone_from(&lost.meshes);
        self.mesh_draws.clone_from(&lost.mesh_draws);
        self.mesh_bounds.clone_from(&lost.mesh_bounds);
        self.lods.clone_from(&lost.lods);
        self.owners.clone_from(&lost.owners);
        self.object_meshes.clone_from(&lost.object_meshes);
        self.object_lods.clone_from(&lost.object_lods);
        self.object_instances.clone_from(&lost.object_instances);
        self.waiting.clone_from(&lost.waiting);
        // A leaf's draw is counted by its mesh, so no leaf has one while meshes change.
        let all_leaves = (0..).map(LeafIndex).zip(hierarchy.leaf_objects());
        for (leaf, _) in all_leaves.clone() {
            leaves.mark_dirty(leaf, MeshDrawId::NONE);
        }
        for (id, draw) in (0..).map(MeshDrawId).zip(&*self.mesh_draws) {
            leaves.set_mesh_draw(id, *draw);
        }
        if let (Some(surfaces), Some(lost)) = (&mut self.surfaces, &lost.surfaces) {
            surfaces.restore(lost, kept, hierarchy, &mut self.uploads)?;
        }
        for (id, mesh) in &kept.meshes {
            if let Some(place) = self.meshes.place(*id) {
                self.uploads.push_mesh(*id, mesh.clone(), place.clone(), Vec::new());
            }
        }
        for object in (0..self.object_meshes.len() as u32).map(ObjectId) {
            self.find_lights(hierarchy, object);
        }
        // Numbers of lights that `lost` had not found yet are not those of its instances.
        if let Some(surfaces) = &self.surfaces {
            for (slot, instance) in (0..).zip(&mut self.object_instances) {
                let count = surfaces.light_lists.count(slot);
                instance.tail[2] = with_lights(instance.tail[2], count);
            }
        }
        for (leaf, object) in all_leaves {
            leaves.mark_dirty(leaf, self.draw_of(*object));
        }
        Ok(())
    }
}
