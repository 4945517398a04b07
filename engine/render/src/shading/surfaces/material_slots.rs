//! The materials of a scene, materials that are added later, and their places in the table of the
//! shaders.

use gpu::{BufferSlice, Frame};
use occlusion::{ScatterIo, ScatterPass};
use scene::{Alpha, Material, MaterialId, PunctualLight, Surfaces, TextureId};

use crate::error::Error;
use crate::resource_errors::{MaterialError, MeshError};
use crate::resources::spare_capacity::{SpareCapacity, SpareRanges};
use crate::shading::surfaces::marked::Marked;
use crate::shading::surfaces::materials::{Features, MaterialEntry, MaterialTable};
use crate::shading::surfaces::texture_slots::TexturePlace;
use crate::shading::surfaces::texture_transforms::TransformEntry;

/// The place of a material.
#[derive(Clone, Debug, Default)]
struct MaterialSlot {
    /// The material, if there is one.
    material: Option<Material>,
    /// The number of meshes with the material.
    users: u32,
}

/// The places of all materials.
pub(crate) struct MaterialSlots {
    table: MaterialTable,
    slots: Vec<MaterialSlot>,
    ids: SpareRanges,
    dirty: Marked,
}

impl MaterialSlots {
    /// Notes the materials of a scene. Room for more follows, and then the material of meshes
    /// without one.
    pub(crate) fn new(surfaces: &Surfaces, table: MaterialTable, spare: &SpareCapacity) -> Self {
        let slot =
            |material: &Material| MaterialSlot { material: Some(material.clone()), users: 0 };
        let mut slots: Vec<MaterialSlot> = surfaces.materials.iter().map(slot).collect();
        slots.resize(slots.len() + spare.materials as usize, MaterialSlot::default());
        for mesh in &surfaces.meshes {
            if let Some(slot) = slots.get_mut(mesh.material.0 as usize) {
                slot.users += 1;
            }
        }
        let used = surfaces.materials.len() as u32;
        Self {
            ids: SpareRanges::behind("materials", used, spare.materials),
            dirty: Marked::none_of(slots.len()),
            slots,
            table,
        }
    }

    fn material(&self, material: MaterialId) -> Option<&Material> {
        self.slots.get(material.0 as usize)?.material.as_ref()
    }

    /// Returns true if a material is opaque. The material of meshes without one is opaque.
    pub(crate) fn is_opaque(&self, material: MaterialId) -> bool {
        self.material(material).is_none_or(|material| material.alpha == Alpha::Opaque)
    }

    pub(crate) fn is_masked(&self, material: MaterialId) -> bool {
        let alpha = self.material(material).map(|material| &material.alpha);
        matches!(alpha, Some(Alpha::Mask { .. }))
    }

    /// Refuses a material that an added mesh cannot have, with the reason.
    pub(crate) fn check_mesh(&self, material: MaterialId) -> Result<(), MeshError> {
        match self.material(material) {
            None => Err(MeshError::UnknownMaterial),
            Some(material) if material.alpha == Alpha::Blend => Err(MeshError::Transparent),
            Some(_) => Ok(()),
        }
    }

    /// Refuses a material that cannot be added to a scene whose passes have these features, with
    /// the reason.
    pub(crate) fn check(
        &self,
        material: &Material,
        features: &Features,
    ) -> Result<(), MaterialError> {
        if material.alpha == Alpha::Blend {
            return Err(MaterialError::Transparent);
        }
        let checked = material.check(self.table.texture_count());
        checked.map_err(|fault| MaterialError::Broken { fault })?;
        self.table.check(material, features)
    }

    /// Takes a place for a material that was checked. The next frame uploads it.
    pub(crate) fn add(&mut self, material: &Material) -> Result<MaterialId, Error> {
        self.table.check_room(material)?;
        let id = self.ids.take(1)?.start;
        if let Some(slot) = self.slots.get_mut(id as usize) {
            *slot = MaterialSlot { material: Some(material.clone()), users: 0 };
        }
        self.table.set(id, material);
        self.dirty.mark_dirty(id);
        Ok(MaterialId(id))
    }

    /// Notes the place of a texture that is added; `None` for one that is removed.
    pub(crate) fn place_texture(&mut self, texture: TextureId, place: Option<TexturePlace>) {
        self.table.place_texture(texture, place);
    }

    /// Returns the place of a texture, if it is on the GPU.
    pub(crate) fn place(&self, texture: TextureId) -> Option<TexturePlace> {
        self.table.place(texture)
    }

    /// Notes that a light with its picture is added or removed.
    pub(crate) fn count_cookie(&mut self, light: &PunctualLight, change: i32) {
        self.table.count_cookie(light, change);
    }

    /// Refuses the picture of a light if passes with these `features` cannot show it, with the
    /// reason.
    pub(crate) fn check_cookie(
        &self,
        light: &PunctualLight,
        features: &Features,
    ) -> Result<(), &'static str> {
        light.check_cookie(self.table.texture_count())?;
        let Some(picture) = light.cookie else { return Ok(()) };
        match self.place(picture.texture) {
            None => {
                Err("the texture of its picture is not on the GPU: it was removed, or nothing \
                         of the scene that the renderer began with used it")
            }
            Some(place) if features.pictures & place.bit == 0 => {
                Err("pipelines are compiled for pictures only where the scene that the renderer \
                     began with has a light with one, and for textures of `Encoding::Srgb`")
            }
            Some(_) => Ok(()),
        }
    }

    /// Returns true if a material or a light uses a texture.
    pub(crate) fn uses_texture(&self, texture: TextureId) -> bool {
        self.table.uses_texture(texture)
    }

    /// Refuses to remove a material that is used or does not exist, with the reason.
    pub(crate) fn check_removal(&self, material: MaterialId) -> Result<(), MaterialError> {
        match self.slots.get(material.0 as usize) {
            None | Some(MaterialSlot { material: None, .. }) => Err(MaterialError::UnknownMaterial),
            Some(MaterialSlot { users: 1.., .. }) => Err(MaterialError::InUse),
            Some(_) => Ok(()),
        }
    }

    /// Frees the place of a material that no mesh has.
    pub(crate) fn remove(&mut self, material: MaterialId) {
        let slot = self.slots.get_mut(material.0 as usize);
        if let Some(gone) = slot.and_then(|slot| slot.material.take()) {
            self.table.free(&gone);
            self.ids.free(material.0..material.0 + 1);
        }
    }

    /// Refuses to replace a material by one that does not fit its use, with the reason.
    pub(crate) fn check_replacement(
        &self,
        material: MaterialId,
        to: &Material,
    ) -> Result<(), MaterialError> {
        match self.material(material) {
            None => Err(MaterialError::UnknownMaterial),
            Some(before) if [before.alpha, to.alpha] != [Alpha::Opaque; 2] => {
                Err(MaterialError::NotOpaque)
            }
            Some(_) => Ok(()),
        }
    }

    /// Replaces a material by one that was checked. The next frame uploads it. After an error the
    /// former material stays.
    pub(crate) fn replace(&mut self, material: MaterialId, to: &Material) -> Result<(), Error> {
        let slot = self.slots.get_mut(material.0 as usize);
        let Some(there) = slot.and_then(|slot| slot.material.as_mut()) else { return Ok(()) };
        self.table.free(there);
        let room = self.table.check_room(to);
        if room.is_ok() {
            *there = to.clone();
        }
        self.table.set(material.0, there);
        self.dirty.mark_dirty(material.0);
        room
    }

    /// Takes over the materials of `lost`, materials of the same scene. The places of all textures
    /// must be known.
    pub(crate) fn restore(&mut self, lost: &Self) {
        let Self { table, slots, ids, dirty } = self;
        let gone = slots.iter_mut().filter_map(|slot| slot.material.take());
        gone.for_each(|material| table.free(&material));
        for (number, slot) in (0..).zip(&lost.slots) {
            if let Some(material) = &slot.material {
                table.set(number, material);
                dirty.mark_dirty(number);
            }
        }
        slots.clone_from(&lost.slots);
        ids.clone_from(&lost.ids);
    }

    /// Notes that a mesh has another material.
    pub(crate) fn count_user(&mut self, before: u32, now: u32) {
        if let Some(slot) = self.slots.get_mut(before as usize) {
            slot.users = slot.users.saturating_sub(1);
        }
        if let Some(slot) = self.slots.get_mut(now as usize) {
            slot.users += 1;
        }
    }

    /// Records the upload of new materials, before anything of `frame` reads them.
    pub(crate) fn upload_changes(
        &self,
        frame: &mut Frame<'_>,
        scatter: &ScatterPass,
        materials: BufferSlice,
        transforms: BufferSlice,
    ) -> Result<(), Error> {
        let dirty = self.dirty.list();
        if !dirty.is_empty() {
            let entries = dirty.iter().map(|material| self.table.entry(*material));
            let uploads = frame.uploads();
            let leaves = uploads.push(dirty)?;
            let elements = uploads.push_iter(entries)?;
            let element_bytes = size_of::<MaterialEntry>();
            let io = ScatterIo { leaves, elements, array: materials, element_bytes };
            scatter.record(frame.commands(), dirty.len() as u32, [io]);
        }
        let (dirty, entries) = self.table.transforms.dirty();
        if !dirty.is_empty() {
            let uploads = frame.uploads();
            let leaves = uploads.push(dirty)?;
            let elements = uploads.push_iter(entries)?;
            let element_bytes = size_of::<TransformEntry>();
            let io = ScatterIo { leaves, elements, array: transforms, element_bytes };
            scatter.record(frame.commands(), dirty.len() as u32, [io]);
        }
        Ok(())
    }

    /// Notes that the frame of the last [`MaterialSlots::upload_changes`] was submitted.
    pub(crate) fn submitted(&mut self) {
        self.dirty.drain().for_each(drop);
        self.table.transforms.submitted();
    }
}
