//! The state of a scene's surfaces on another device, after the first was lost.

use cull::{Aabb, Hierarchy, ObjectId};
use scene::LightId;

use super::super::SurfaceResources;
use crate::error::Error;
use crate::kept_scene::KeptScene;
use crate::resources::upload_queue::UploadQueue;

impl SurfaceResources {
    /// Brings surfaces that were uploaded as the kept scene began into the state that they have in
    /// `lost`. Added textures are put into the queue. The lights of objects must be found again.
    pub(crate) fn restore(
        &mut self,
        lost: &Self,
        kept: &KeptScene,
        hierarchy: &Hierarchy,
        uploads: &mut UploadQueue,
    ) -> Result<(), Error> {
        self.textures.restore(&lost.textures);
        for (id, texture) in &kept.textures {
            let Some(place) = self.textures.place_again(*id, texture)? else { continue };
            self.material_slots.place_texture(*id, Some(place));
            let texture = self.textures.ready(texture.clone());
            let levels = self.levels_by_cpu(place, &texture);
            uploads.push_texture(*id, texture, place, levels);
        }
        self.mesh_materials.clone_from(&lost.mesh_materials);
        self.material_slots.restore(&lost.material_slots);
        self.exposure = lost.exposure;
        self.transparent.clone_from(&lost.transparent);
        for (id, light) in (0..).map(LightId).zip(&lost.table.lights) {
            self.replace_light(hierarchy, id, *light);
        }
        self.table.restore_free(&lost.table);
        for transparent in 0..self.transparent.leaf_objects().len() as u32 {
            let node = self.transparent.node_of(ObjectId(transparent));
            let bounds = node.map_or(Aabb::EMPTY, |node| self.transparent.bounds(node));
            self.find_lights(self.first_transparent_slot + transparent, &bounds);
        }
        Ok(())
    }
}
