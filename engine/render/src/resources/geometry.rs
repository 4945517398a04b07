//! The scene in GPU memory, in the order of the hierarchy's leaves, so that a subtree is a range of
//! each array.

mod api;

use occlusion::ScenePartsMut;
use std::collections::HashMap;
use std::sync::Arc;

use cull::{Aabb, DetailPolicy, Hierarchy, LeafIndex, ObjectId};
use glam::Affine3A;
use gpu::{Buffer, BufferSlice, Device, Frame, IndirectDraw, vk};
use occlusion::{CulledScene, LeafElements, LeafTable, MeshDraw, MeshDrawId, ProxyBox};
use scene::{
    MeshId, Object, PreparedMesh, Scene, SurfaceVertex, TransparentId, Vertex,
    bounds_of_transformed, unpack_unorm,
};

use crate::error::Error;
use crate::resource_errors::MeshError;
use crate::resources::instance::{Instance, rows_of, with_lights};
use crate::resources::joined_meshes::JoinedMeshes;
use crate::resources::limits::{check_leaves, check_memory, check_storage};
use crate::resources::lod::{LodTable, stretch};
use crate::resources::mesh_slots::{MeshSlots, Residency, draws_of};
use crate::resources::skinned_meshes::{SkinnedVertices, are_skinned, skinned_vertices};
use crate::resources::sprites;
use crate::resources::upload_queue::{UploadQueue, UploadTargets};
use crate::resources::volume_meshes::{VolumeDraw, VolumeMeshes};
use crate::section::SectionMeshes;
use crate::shading::surfaces::{SurfaceOptions, SurfaceResources};

/// The memory per object while a renderer is created (bytes): the instance by object and by leaf,
/// the box, the draw, and some numbers. Device memory is included, since it may be the machine's
/// memory.
const UPLOAD_BYTES_PER_OBJECT: usize = 3 * size_of::<Instance>()
    + 2 * (size_of::<ProxyBox>() + size_of::<IndirectDraw>())
    + size_of::<[u64; 8]>();

/// The mesh index of an id without an object.
const NO_MESH: u32 = u32::MAX;

/// Meshes, instances, and the CPU data to draw a leaf.
pub(crate) struct Geometry {
    pub(crate) vertices: Buffer,
    /// The number of vertices of skinned meshes, which come first.
    skinned_vertices: u64,
    pub(crate) indices: Buffer,
    pub(crate) instances: Buffer,
    /// The surfaces, if the scene has surfaces.
    pub(crate) surfaces: Option<SurfaceResources>,
    /// The draws of meshes, followed by the draws of their coarser levels.
    mesh_draws: Arc<[MeshDraw]>,
    pub(crate) meshes: MeshSlots,
    pub(crate) uploads: UploadQueue,
    /// The meshes in the form that shadow volumes are extruded from, while volumes are drawn.
    pub(crate) volumes: Option<VolumeMeshes>,
    /// The meshes in the form that section planes cut, while there are planes.
    pub(crate) section_meshes: Option<SectionMeshes>,
    /// The objects whose meshes are being uploaded.
    waiting: Vec<ObjectId>,
    mesh_bounds: Vec<Aabb>,
    pub(crate) lods: LodTable,
    // By object.
    object_meshes: Vec<u32>,
    /// The draw of each object: the draw of its mesh, or of a coarser level.
    object_lods: Vec<u32>,
    object_instances: Vec<Instance>,
    /// True for each mesh that is skinned. Its box is the box of its only object.
    is_skinned: Vec<bool>,
    /// The objects of skinned meshes.
    owners: HashMap<u32, ObjectId>,
}

impl Geometry {
    pub(crate) fn upload(
        device: &Device,
        scene: &Scene,
        hierarchy: &Hierarchy,
        options: &SurfaceOptions,
        frame_bytes: usize,
    ) -> Result<Self, Error> {
        let spare = &options.spare;
        let leaf_count = hierarchy.leaf_objects().len();
        check_memory("the objects on their way to the GPU", leaf_count, UPLOAD_BYTES_PER_OBJECT)?;
        let joined = JoinedMeshes::new(scene, spare)?;
        check_leaves(device, leaf_count)?;
        sprites::check_size(device, scene, leaf_count)?;
        check_storage(
            device,
            "vertices of skinned meshes",
            skinned_vertices(scene),
            size_of::<SurfaceVertex>() as u64,
            "make those meshes simpler, or fewer",
        )?;
        options.cancellation.check()?;
        let surfaces = SurfaceResources::upload(device, scene, hierarchy, options)?;
        options.cancellation.check()?;
        let mut object_meshes = vec![NO_MESH; leaf_count];
        let mut object_instances = vec![Instance::default(); leaf_count];
        let places = object_meshes.iter_mut().zip(&mut object_instances);
        for (id, ((mesh, instance), object)) in (0..).zip(places.zip(&scene.objects)) {
            *mesh = object.mesh.0;
            *instance = instance_of(ObjectId(id), object, surfaces.as_ref());
        }
        let by_leaf = || hierarchy.leaf_objects().iter().map(|object| object.0 as usize);
        let mut instances: Vec<Instance> =
            by_leaf().map(|o| object_instances.get(o).copied().unwrap_or_default()).collect();
        sprites::add_vectors(scene, &mut instances);
        let meshes = MeshSlots::new(scene, &joined, spare);
        let JoinedMeshes { vertices, indices, draws: mesh_draws, lods, .. } = joined;
        let to_come = spare.meshes as usize;
        let mut mesh_bounds: Vec<Aabb> = scene.meshes.iter().map(|mesh| mesh.bounds).collect();
        mesh_bounds.resize(mesh_bounds.len() + to_come, Aabb::EMPTY);
        // Volumes are built from copies. Where a compute shader extrudes them, it reads vertices.
        let index = vk::BufferUsageFlags::INDEX_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC;
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let skinned_vertices = skinned_vertices(scene);
        let mut is_skinned = are_skinned(scene);
        is_skinned.resize(is_skinned.len() + to_come, false);
        let owners =
            (0..).map(ObjectId).zip(&scene.objects).map(|(id, object)| (object.mesh.0, id));
        let owners = owners.filter(|(mesh, _)| is_skinned.get(*mesh as usize) == Some(&true));
        let owners = owners.collect();
        let vertex =
            vk::BufferUsageFlags::VERTEX_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC | storage;
        Ok(Self {
            vertices: device.upload("vertices", &vertices, vertex)?,
            skinned_vertices,
            is_skinned,
            owners,
            indices: device.upload("indices", &indices, index)?,
            instances: device.upload("instances", &instances, storage)?,
            mesh_bounds,
            meshes,
            uploads: UploadQueue::new(frame_bytes),
            volumes: None,
            section_meshes: None,
            waiting: Vec::new(),
            surfaces,
            mesh_draws,
            lods,
            object_lods: object_meshes.clone(),
            object_meshes,
            object_instances,
        })
    }

    /// Returns the draws of meshes, followed by the draws of coarser levels.
    pub(crate) fn mesh_draws(&self) -> &Arc<[MeshDraw]> {
        &self.mesh_draws
    }

    /// Returns the draw of an object: its mesh or a coarser level; no draw while the mesh is being
    /// uploaded.
    pub(crate) fn draw_of(&self, object: ObjectId) -> MeshDrawId {
        let mesh = self.object_meshes.get(object.0 as usize).copied().unwrap_or(NO_MESH);
        match (self.object_lods.get(object.0 as usize), self.meshes.residency(MeshId(mesh))) {
            (Some(lod), Residency::Resident | Residency::Kept) => MeshDrawId(*lod),
            _ => MeshDrawId::NONE,
        }
    }

    /// Refuses a mesh that does not fit the scene, with the reason.
    pub(crate) fn check_mesh(&self, mesh: &PreparedMesh) -> Result<(), MeshError> {
        match (&self.surfaces, mesh.surface()) {
            (None, None) => Ok(()),
            (Some(surfaces), Some(surface)) => surfaces.material_slots.check_mesh(surface.material),
            (Some(_), None) => Err(MeshError::SurfaceMissing),
            (None, Some(_)) => Err(MeshError::NoSurfaces),
        }
    }

    /// Takes a mesh that fits. It is drawn once it has been uploaded.
    pub(crate) fn add_mesh(
        &mut self,
        mesh: PreparedMesh,
        leaves: &mut LeafTable,
    ) -> Result<MeshId, Error> {
        let (id, place) = self.meshes.take(&mesh)?;
        for (draw_id, draw) in draws_of(id, &mesh, &place) {
            self.set_mesh_draw(draw_id, draw, leaves);
        }
        if let Some(bounds) = self.mesh_bounds.get_mut(id.0 as usize) {
            *bounds = mesh.bounds();
        }
        self.lods.set(id, place.levels.start, mesh.levels());
        if let (Some(surfaces), Some(surface)) = (&mut self.surfaces, mesh.surface()) {
            surfaces.set_mesh_material(id, Some(surface.material));
        }
        let casts_volumes = self.casts_volumes(id);
        let volumes = self.volumes.as_mut().filter(|_| casts_volumes);
        let adjacency = volumes.map(|volumes| volumes.add(id, &mesh, &place));
        if let Some(section_meshes) = &mut self.section_meshes {
            section_meshes.add(id, &mesh, &place);
        }
        self.uploads.push_mesh(id, mesh, place, adjacency.unwrap_or_default());
        Ok(id)
    }

    /// Removes a mesh that no object has.
    pub(crate) fn remove_mesh(&mut self, mesh: MeshId, leaves: &mut LeafTable) {
        for draw in self.meshes.remove(mesh) {
            self.set_mesh_draw(draw, MeshDraw::default(), leaves);
            if let Some(volumes) = &mut self.volumes {
                volumes.remove(draw);
            }
        }
        if let Some(bounds) = self.mesh_bounds.get_mut(mesh.0 as usize) {
            *bounds = Aabb::EMPTY;
        }
        self.lods.set(mesh, 0, &[]);
        if let Some(surfaces) = &mut self.surfaces {
            surfaces.set_mesh_material(mesh, None);
        }
        self.uploads.cancel_mesh(mesh);
    }

    fn set_mesh_draw(&mut self, id: MeshDrawId, draw: MeshDraw, leaves: &mut LeafTable) {
        if let Some(there) = Arc::make_mut(&mut self.mesh_draws).get_mut(id.0 as usize) {
            *there = draw;
        }
        leaves.set_mesh_draw(id, draw);
    }

    /// Marks the objects of meshes that have arrived. Returns true if there are such meshes.
    pub(crate) fn show_arrived(&mut self, hierarchy: &Hierarchy, leaves: &mut LeafTable) -> bool {
        let arrived = self.uploads.take_arrived();
        arrived.iter().for_each(|mesh| self.meshes.arrived(*mesh));
        if arrived.is_empty() {
            return false;
        }
        let mut waiting = std::mem::take(&mut self.waiting);
        waiting.retain(|object| {
            let draw = self.draw_of(*object);
            if let (Some(leaf), true) = (hierarchy.leaf_of(*object), draw != MeshDrawId::NONE) {
                leaves.mark_dirty(leaf, draw);
            }
            let mesh = self.object_meshes.get(object.0 as usize).copied().unwrap_or(NO_MESH);
            self.meshes.residency(MeshId(mesh)) == Residency::Uploading
        });
        self.waiting = waiting;
        true
    }

    /// Returns the draw of a mesh; an empty draw if the scene does not have the mesh.
    pub(crate) fn mesh_draw(&self, mesh: MeshId) -> IndirectDraw {
        self.mesh_draws.get(mesh.0 as usize).map(|mesh| mesh.draw).unwrap_or_default()
    }

    /// Returns the draw of an object as a shadow caster: always the finest level, so that shadows
    /// do not depend on the distance of an eye. Empty while the mesh is being uploaded.
    pub(crate) fn caster_draw(&self, object: ObjectId, leaf: LeafIndex) -> IndirectDraw {
        let mesh = MeshId(self.object_meshes.get(object.0 as usize).copied().unwrap_or(NO_MESH));
        match self.meshes.residency(mesh) {
            Residency::Resident | Residency::Kept => {
                IndirectDraw { first_instance: leaf.0, instance_count: 1, ..self.mesh_draw(mesh) }
            }
            Residency::Free | Residency::Uploading => IndirectDraw::default(),
        }
    }

    /// Replaces the volumes of all meshes by new ones, or removes them.
    pub(crate) fn replace_volumes(&mut self, volumes: Option<VolumeMeshes>) {
        // The new volumes include meshes that are being uploaded.
        self.uploads.drop_adjacency();
        self.volumes = volumes;
    }

    /// Returns true if the objects of a mesh cast shadow volumes.
    pub(crate) fn casts_volumes(&self, mesh: MeshId) -> bool {
        self.surfaces.as_ref().is_some_and(|surfaces| surfaces.casts_volumes(mesh))
    }

    /// Returns the draw of an object and its triangles, if it casts shadow volumes. The level of
    /// detail is the one that is drawn, since the surfaces of another level would be in their own
    /// shadow.
    pub(crate) fn volume_draw(&self, object: ObjectId) -> Option<(IndirectDraw, &VolumeDraw)> {
        let id = self.draw_of(object);
        let volumes = self.volumes.as_ref()?.get(id)?;
        Some((self.mesh_draws.get(id.0 as usize)?.draw, volumes))
    }

    /// Returns the vertex shader's data of a transparent object.
    pub(crate) fn transparent_instance(&self, id: TransparentId, object: &Object) -> Instance {
        let slot = |surfaces: &SurfaceResources| surfaces.first_transparent_slot() + id.0;
        let surfaces = self.surfaces.as_ref();
        instance_of(ObjectId(surfaces.map_or(0, slot)), object, surfaces)
    }

    /// Returns the box of an object at another transform, if the object exists and the coordinates
    /// are possible.
    pub(crate) fn bounds_at(&self, object: ObjectId, transform: &Affine3A) -> Option<Aabb> {
        let mesh = self.object_meshes.get(object.0 as usize)?;
        self.bounds_of(*mesh, transform)
    }

    /// Returns the box of a mesh at a transform, if the mesh exists and the coordinates are
    /// possible.
    pub(crate) fn bounds_of(&self, mesh: u32, transform: &Affine3A) -> Option<Aabb> {
        bounds_in_world(self.mesh_bounds.get(mesh as usize)?, transform)
    }

    /// Sets the box of a skinned mesh in its own space, for its present object and for later
    /// objects.
    pub(crate) fn reshape(&mut self, mesh: MeshId, bounds: Aabb) {
        if let Some(of_mesh) = self.mesh_bounds.get_mut(mesh.0 as usize) {
            *of_mesh = bounds;
        }
    }

    pub(crate) fn is_skinned(&self, mesh: MeshId) -> bool {
        self.is_skinned.get(mesh.0 as usize).copied().unwrap_or_default()
    }

    /// Returns the object of a skinned mesh.
    pub(crate) fn owner(&self, mesh: MeshId) -> Option<ObjectId> {
        self.owners.get(&mesh.0).copied()
    }

    pub(crate) fn transform(&self, object: ObjectId) -> Option<Affine3A> {
        self.object_instances.get(object.0 as usize).map(Instance::transform)
    }

    pub(crate) fn skinned(&self) -> Option<SkinnedVertices> {
        let part = |vertices: BufferSlice, vertex_bytes: usize| {
            vertices.part(0, self.skinned_vertices * vertex_bytes as u64)
        };
        Some(SkinnedVertices {
            vertices: part(self.vertices.whole(), size_of::<Vertex>()),
            surfaces: part(self.surfaces.as_ref()?.vertices(), size_of::<SurfaceVertex>()),
        })
    }

    pub(crate) fn first_vertex(&self, mesh: usize) -> u32 {
        self.mesh_draws.get(mesh).map_or(0, |mesh| mesh.draw.vertex_offset as u32)
    }

    /// Moves an object. Its leaf must be [marked](occlusion::LeafTable::mark_dirty).
    pub(crate) fn place(&mut self, object: ObjectId, transform: &Affine3A) {
        if let Some(instance) = self.object_instances.get_mut(object.0 as usize) {
            instance.rows = rows_of(transform);
        }
    }

    /// Sets the object of an id, or removes it. Its leaf must be marked.
    pub(crate) fn replace(&mut self, id: ObjectId, object: Option<&Object>) {
        let surfaces = self.surfaces.as_ref();
        let now = object.map(|object| instance_of(id, object, surfaces)).unwrap_or_default();
        let place = id.0 as usize;
        let (Some(mesh), Some(lod), Some(instance)) = (
            self.object_meshes.get_mut(place),
            self.object_lods.get_mut(place),
            self.object_instances.get_mut(place),
        ) else {
            return;
        };
        let after = object.map(|object| object.mesh);
        self.meshes.count_user(Some(MeshId(*mesh)), after);
        if after.is_some_and(|mesh| self.meshes.residency(mesh) == Residency::Uploading) {
            self.waiting.push(id);
        }
        self.owners.remove(mesh);
        if let Some(object) = object
            && self.is_skinned.get(object.mesh.0 as usize) == Some(&true)
        {
            self.owners.insert(object.mesh.0, id);
        }
        *mesh = object.map_or(NO_MESH, |object| object.mesh.0);
        *lod = *mesh;
        *instance = now;
    }

    /// Selects the level of detail of an object by its size in the image. Returns true if the level
    /// changed; the caller must then mark its leaf.
    pub(crate) fn select_lod(
        &mut self,
        object: ObjectId,
        pixels_per_metre: f32,
        policy: &DetailPolicy,
    ) -> bool {
        let id = object.0 as usize;
        let (Some(mesh), Some(lod), Some(instance)) = (
            self.object_meshes.get(id),
            self.object_lods.get_mut(id),
            self.object_instances.get(id),
        ) else {
            return false;
        };
        let scale = pixels_per_metre * stretch(&instance.rows);
        let chosen = self.lods.select_lod(MeshId(*mesh), *lod, scale, policy);
        chosen.is_some_and(|chosen| std::mem::replace(lod, chosen) != chosen)
    }

    /// Finds the lights of an object at its present place, or none if it was removed. Returns true
    /// if the lights changed; the caller must then mark its leaf.
    pub(crate) fn find_lights(&mut self, hierarchy: &Hierarchy, object: ObjectId) -> bool {
        let Some(surfaces) = &mut self.surfaces else { return false };
        let node = hierarchy.node_of(object);
        let bounds = node.map_or(Aabb::EMPTY, |node| hierarchy.bounds(node));
        let is_other = surfaces.find_lights(object.0, &bounds);
        if let Some(instance) = self.object_instances.get_mut(object.0 as usize)
            && is_other
        {
            let count = surfaces.light_lists.count(object.0);
            instance.tail[2] = with_lights(instance.tail[2], count);
        }
        is_other
    }

    /// Finds the lights of objects again around lights that changed since the last frame.
    pub(crate) fn relight(&mut self, hierarchy: &Hierarchy, leaves: &mut LeafTable) {
        let objects = self.surfaces.as_mut().map(SurfaceResources::relight).unwrap_or_default();
        for object in objects {
            if self.find_lights(hierarchy, object)
                && let Some(leaf) = hierarchy.leaf_of(object)
            {
                leaves.mark_dirty(leaf, self.draw_of(object));
            }
        }
    }

    /// Records the upload of all changes since the last frame, before anything of `frame` reads
    /// them. Changes stay marked until the frame was [submitted](Geometry::submitted), which may
    /// never happen.
    pub(crate) fn upload_changes(
        &mut self,
        frame: &mut Frame<'_>,
        scene: &mut CulledScene,
    ) -> Result<(), Error> {
        let targets = UploadTargets {
            vertices: self.vertices.whole(),
            surfaces: self.surfaces.as_ref().map(SurfaceResources::vertices),
            indices: self.indices.whole(),
            adjacency: self.volumes.as_ref().map(VolumeMeshes::adjacency),
            textures: self.surfaces.as_ref().map(|surfaces| &surfaces.textures),
        };
        self.uploads.record(frame, targets)?;
        let ScenePartsMut { hierarchy, leaves, passes } = scene.parts_mut();
        let scatter = &passes.scatter;
        leaves.begin()?;
        if let Some(surfaces) = &self.surfaces {
            surfaces.upload_changes(frame, scatter)?;
        }
        if leaves.dirty().is_empty() {
            return Ok(());
        }
        let instance = |leaf: &LeafIndex| {
            let object = hierarchy.leaf_objects().get(leaf.0 as usize);
            let instance = object.and_then(|object| self.object_instances.get(object.0 as usize));
            instance.copied().unwrap_or_default()
        };
        let instances = LeafElements {
            elements: frame.uploads().push_iter(leaves.dirty().iter().map(instance))?,
            array: self.instances.whole(),
            element_bytes: size_of::<Instance>(),
        };
        Ok(leaves.upload(frame, hierarchy, scatter, Some(instances))?)
    }

    /// Notes that the frame of the last [`Geometry::upload_changes`] was submitted.
    pub(crate) fn submitted(&mut self) {
        self.uploads.submitted();
        if let Some(surfaces) = &mut self.surfaces {
            surfaces.submitted();
        }
    }
}

fn instance_of(id: ObjectId, object: &Object, surfaces: Option<&SurfaceResources>) -> Instance {
    let tint = || {
        let [red, green, blue, _] = unpack_unorm(object.tint).map(f32::to_bits);
        [red, green, blue, 0]
    };
    let tail = surfaces.map_or_else(tint, |surfaces| surfaces.instance_tail(object, id.0));
    Instance { rows: rows_of(&object.transform), tail }
}

/// Returns the box around a transformed box, if its coordinates are possible.
pub(crate) fn bounds_in_world(bounds: &Aabb, transform: &Affine3A) -> Option<Aabb> {
    let bounds = bounds_of_transformed(bounds, transform);
    bounds.is_usable().then_some(bounds)
}
