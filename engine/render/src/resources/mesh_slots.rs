//! The places of meshes: of the scene's meshes, and of meshes that are added later.

use std::ops::Range;

use gpu::IndirectDraw;
use occlusion::{MeshDraw, MeshDrawId};
use scene::{MeshId, PreparedMesh, Scene};

use crate::error::Error;
use crate::resource_errors::MeshError;
use crate::resources::joined_meshes::JoinedMeshes;
use crate::resources::skinned_meshes::are_skinned;
use crate::resources::spare_capacity::{SpareCapacity, SpareRanges};

/// The state of a place for a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Residency {
    /// The place has no mesh.
    Free,
    /// The mesh is being uploaded; its objects are not drawn.
    Uploading,
    /// The mesh is on the GPU.
    Resident,
    /// The mesh is on the GPU permanently, since it is skinned or consists of sprites.
    Kept,
}

/// The parts of the arrays that a mesh takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshPlace {
    pub(crate) vertices: Range<u32>,
    /// The indices of the mesh and of its coarser levels.
    pub(crate) indices: Vec<Range<u32>>,
    /// The draws of its coarser levels.
    pub(crate) levels: Range<u32>,
}

impl MeshPlace {
    /// Returns the draws of a mesh and of its coarser levels, each with its indices.
    pub(crate) fn draws(&self, id: MeshId) -> impl Iterator<Item = (MeshDrawId, &Range<u32>)> {
        let ids = std::iter::once(id.0).chain(self.levels.clone()).map(MeshDrawId);
        ids.zip(&self.indices)
    }
}

#[derive(Clone)]
struct MeshSlot {
    residency: Residency,
    /// The number of objects that have the mesh.
    users: u32,
    place: MeshPlace,
}

/// The places of all meshes.
#[derive(Clone)]
pub(crate) struct MeshSlots {
    slots: Vec<MeshSlot>,
    ids: SpareRanges,
    vertices: SpareRanges,
    indices: SpareRanges,
    levels: SpareRanges,
}

impl MeshSlots {
    /// Notes the places of the meshes of a scene, and the room for more.
    pub(crate) fn new(scene: &Scene, joined: &JoinedMeshes, spare: &SpareCapacity) -> Self {
        let mut are_kept = are_skinned(scene);
        for sprites in scene.surfaces.iter().flat_map(|surfaces| &surfaces.sprites) {
            if let Some(is_kept) = are_kept.get_mut(sprites.mesh.0 as usize) {
                *is_kept = true;
            }
        }
        let slot = |(number, mesh): (u32, &scene::Mesh)| {
            let levels = joined.lods.draws_of(MeshId(number));
            let draws = std::iter::once(number).chain(levels.clone());
            let draws = draws.filter_map(|draw| joined.draws.get(draw as usize));
            let indices = draws
                .map(|draw| draw.draw.first_index..draw.draw.first_index + draw.draw.index_count);
            let first = joined.draws.get(number as usize).map_or(0, |draw| draw.draw.vertex_offset);
            let first = first as u32;
            let count = mesh.vertices.len() as u32;
            MeshPlace { vertices: first..first + count, indices: indices.collect(), levels }
        };
        let slots = (0..).zip(&scene.meshes).map(slot).zip(are_kept).map(|(place, is_kept)| {
            let residency = if is_kept { Residency::Kept } else { Residency::Resident };
            MeshSlot { residency, users: 0, place }
        });
        let free =
            || MeshSlot { residency: Residency::Free, users: 0, place: MeshPlace::default() };
        let slots = slots.chain((0..spare.meshes).map(|_| free()));
        let [vertices, indices, draws] = joined.used;
        let mut all = Self {
            slots: slots.collect(),
            ids: SpareRanges::behind("meshes", scene.meshes.len() as u32, spare.meshes),
            vertices: SpareRanges::behind("vertices", vertices, spare.vertices),
            indices: SpareRanges::behind("indices", indices, spare.indices),
            levels: SpareRanges::behind("levels of detail", draws, spare.levels),
        };
        let transparent = scene.surfaces.iter().flat_map(|surfaces| &surfaces.transparent);
        for object in scene.objects.iter().chain(transparent) {
            all.count_user(None, Some(object.mesh));
        }
        all
    }

    pub(crate) fn residency(&self, mesh: MeshId) -> Residency {
        self.slots.get(mesh.0 as usize).map_or(Residency::Free, |slot| slot.residency)
    }

    /// Returns the number of meshes of the scene that the slots were made for.
    pub(crate) fn of_scene(&self) -> usize {
        self.slots.iter().filter(|slot| slot.residency != Residency::Free).count()
    }

    /// Returns the place of a mesh.
    pub(crate) fn place(&self, mesh: MeshId) -> Option<&MeshPlace> {
        self.slots.get(mesh.0 as usize).map(|slot| &slot.place)
    }

    /// Returns the existing meshes with their places.
    pub(crate) fn placed(&self) -> impl Iterator<Item = (MeshId, Residency, &MeshPlace)> {
        let all = (0..).map(MeshId).zip(&self.slots);
        let all = all.map(|(mesh, slot)| (mesh, slot.residency, &slot.place));
        all.filter(|(_, residency, _)| *residency != Residency::Free)
    }

    /// Notes that an object changes its mesh.
    pub(crate) fn count_user(&mut self, before: Option<MeshId>, now: Option<MeshId>) {
        for (mesh, change) in [(before, -1), (now, 1)] {
            if let Some(slot) = mesh.and_then(|mesh| self.slots.get_mut(mesh.0 as usize)) {
                slot.users = slot.users.saturating_add_signed(change);
            }
        }
    }

    /// Takes the places of a mesh to upload. After an error nothing is taken.
    pub(crate) fn take(&mut self, mesh: &PreparedMesh) -> Result<(MeshId, MeshPlace), Error> {
        let id = self.ids.take(1)?;
        let mut place = MeshPlace::default();
        if let Err(error) = self.fill(mesh, &mut place) {
            self.free_place(place);
            self.ids.free(id);
            return Err(error);
        }
        if let Some(slot) = self.slots.get_mut(id.start as usize) {
            *slot = MeshSlot { residency: Residency::Uploading, users: 0, place: place.clone() };
        }
        Ok((MeshId(id.start), place))
    }

    fn fill(&mut self, mesh: &PreparedMesh, place: &mut MeshPlace) -> Result<(), Error> {
        place.vertices = self.vertices.take(mesh.mesh().vertices.len())?;
        place.indices.push(self.indices.take(mesh.mesh().indices.len())?);
        for level in mesh.levels() {
            place.indices.push(self.indices.take(level.indices.len())?);
        }
        place.levels = self.levels.take(mesh.levels().len())?;
        Ok(())
    }

    fn free_place(&mut self, place: MeshPlace) {
        self.vertices.free(place.vertices);
        place.indices.into_iter().for_each(|indices| self.indices.free(indices));
        self.levels.free(place.levels);
    }

    /// Notes that a mesh is on the GPU.
    pub(crate) fn arrived(&mut self, mesh: MeshId) {
        if let Some(slot) = self.slots.get_mut(mesh.0 as usize) {
            slot.residency = Residency::Resident;
        }
    }

    /// Refuses to remove a mesh that is in use or permanent, with the reason.
    pub(crate) fn check_removal(&self, mesh: MeshId) -> Result<(), MeshError> {
        match (self.residency(mesh), self.slots.get(mesh.0 as usize).map_or(0, |slot| slot.users)) {
            (Residency::Free, _) => Err(MeshError::UnknownMesh),
            (Residency::Kept, _) => Err(MeshError::Permanent),
            (_, 1..) => Err(MeshError::InUse),
            _ => Ok(()),
        }
    }

    /// Frees the places of a mesh, and returns its draws, which must become empty.
    pub(crate) fn remove(&mut self, mesh: MeshId) -> impl Iterator<Item = MeshDrawId> + use<> {
        let place = self.slots.get_mut(mesh.0 as usize).map(|slot| {
            slot.residency = Residency::Free;
            std::mem::take(&mut slot.place)
        });
        let place = place.unwrap_or_default();
        let levels = place.levels.clone();
        self.free_place(place);
        self.ids.free(mesh.0..mesh.0 + 1);
        std::iter::once(mesh.0).chain(levels).map(MeshDrawId)
    }
}

/// Returns the draws of a mesh at its place, and of its coarser levels.
pub(crate) fn draws_of(
    id: MeshId,
    mesh: &PreparedMesh,
    place: &MeshPlace,
) -> impl Iterator<Item = (MeshDrawId, MeshDraw)> {
    let vertex_offset = place.vertices.start as i32;
    place.draws(id).map(move |(id, indices)| {
        let draw = IndirectDraw {
            index_count: indices.end - indices.start,
            instance_count: 1,
            first_index: indices.start,
            vertex_offset,
            first_instance: 0,
        };
        let triangles = mesh.mesh().triangles_of(indices.len()) as u32;
        (id, MeshDraw { draw, triangles })
    })
}
