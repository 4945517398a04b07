//! A scene's surfaces in GPU memory.

mod api;

use cull::{Aabb, Hierarchy, HierarchyError, ObjectId};
use gpu::{Buffer, BufferSlice, Device, Frame, vk};
use scene::{
    Alpha, LightId, LightKind, Material, MaterialId, MeshId, Object, PreparedTexture,
    PunctualLight, Scene, SurfaceVertex, Surfaces, Texels, TextureId, TransparentId,
};

use crate::error::Error;
use crate::resource_errors::{MaterialError, TextureError};
use crate::resources::instance::lights_and_tint;
use crate::resources::limits;
use crate::resources::skinned_meshes::mesh_order;
use crate::resources::spare_capacity::SpareCapacity;
use crate::resources::sprites;
use crate::shading::environment_texture::EnvironmentTexture;
use crate::shading::scene_degradations::SceneDegradations;
use crate::shading::surfaces::checks::{check, check_counts};
use crate::shading::surfaces::light_lists::{LIST_VALUES, LightLists};
use crate::shading::surfaces::lights::{LightEntry, LightTable, dark_light, is_broken};
use crate::shading::surfaces::marked::Marked;
use crate::shading::surfaces::material_slots::MaterialSlots;
use crate::shading::surfaces::materials::{Features, MaterialTable};
use crate::shading::surfaces::pages::PagePlan;
use crate::shading::surfaces::surface_options::SurfaceOptions;
use crate::shading::surfaces::texture_slots::TexturePlace;
use crate::shading::surfaces::texture_storage::TextureStorage;
use crate::shading::surfaces::textures::SurfaceTextures;
use occlusion::{ScatterIo, ScatterPass};

/// The data of a scene that the surface pass reads in addition to positions, indices and instances.
///
/// An object has a *slot*. It is the object's id; for a transparent object it is the number of the
/// hierarchy's leaves plus the object's index in [`Surfaces::transparent`].
pub struct SurfaceResources {
    /// A [`SurfaceVertex`] for each vertex of all meshes, in the same order.
    vertices: Buffer,
    materials: Buffer,
    transforms: Buffer,
    lights: Buffer,
    lists: Buffer,
    pub(crate) textures: SurfaceTextures,
    features: [Features; 2],
    mesh_materials: Vec<u32>,
    pub(crate) material_slots: MaterialSlots,
    /// The place of each mesh's sprites after the instances; 0 without sprites.
    mesh_sprites: Vec<u32>,
    /// The material of meshes without one.
    default_material: u32,
    pub(crate) table: LightTable,
    pub(crate) light_lists: LightLists,
    dirty_lights: Marked,
    first_transparent_slot: u32,
    /// The hierarchy over the transparent objects, by which lights find them.
    transparent: Hierarchy,
    pub(crate) exposure: f32,
    pub(crate) environment: EnvironmentTexture,
    /// The degradations that are known after the upload.
    degradations: SceneDegradations,
}

impl SurfaceResources {
    /// Uploads the surfaces of `scene` and finds the lights of the objects in `hierarchy`; `None`
    /// for a scene without surfaces. Waits for copies, and can run on any thread.
    ///
    /// # Errors
    /// Too many lights, meshes without surface vertices, images whose number of bytes does not fit
    /// their size; sizes beyond the device's limits, no memory, a failed call,
    /// [`gpu::Error::Cancelled`].
    pub fn upload(
        device: &Device,
        scene: &Scene,
        hierarchy: &Hierarchy,
        options: &SurfaceOptions,
    ) -> Result<Option<Self>, Error> {
        let Some(surfaces) = &scene.surfaces else { return Ok(None) };
        check_counts(device, surfaces, hierarchy, &options.spare)?;
        check(scene, surfaces)?;
        let (textures, plan) = SurfaceTextures::new(device, surfaces, options)?;
        options.cancellation.check()?;
        let places = plan.texture_places(surfaces);
        let table = LightTable::new(surfaces, &options.spare);
        let first_transparent_slot = hierarchy.leaf_objects().len() as u32;
        let slots = first_transparent_slot as usize + surfaces.transparent.len();
        limits::check_memory("the lights of all objects", slots, 2 * 4 * LIST_VALUES)?;
        let mut light_lists = LightLists::new(&table, slots);
        let bounds = |object: &Object| scene.bounds_of(object).unwrap_or(Aabb::EMPTY);
        let transparent: Vec<Aabb> = surfaces.transparent.iter().map(bounds).collect();
        let transparent = Hierarchy::build(&transparent)?;
        if light_lists.has_lights() {
            light_lists.fill(hierarchy, 0);
            light_lists.fill(&transparent, first_transparent_slot);
        }
        light_lists.submitted();
        options.cancellation.check()?;
        let vertices = surface_vertices(scene, surfaces, &options.spare)?;
        // Without lights the lists are not read.
        let lists = if light_lists.has_lights() { light_lists.all_values() } else { Vec::new() };
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let beside = vk::BufferUsageFlags::VERTEX_BUFFER | storage;
        let degradations = degradations_of(&plan, &table);
        let features = features(surfaces, &plan, &places, &table, &light_lists, &options.spare);
        let materials = MaterialTable::new(surfaces, places, options.spare.materials)?;
        let light_entries = table.entries(|texture| materials.place(texture));
        let default_material = materials.entries.len() as u32 - 1;
        let of_scene = surfaces.materials.len() as u32;
        let material_of =
            |material: u32| if material < of_scene { material } else { default_material };
        let mesh_materials = surfaces.meshes.iter().map(|mesh| material_of(mesh.material.0));
        let to_come = options.spare.meshes as usize;
        let to_come = std::iter::repeat_n(default_material, to_come);
        Ok(Some(Self {
            vertices: device.upload("surface vertices", &vertices, beside)?,
            materials: device.upload("materials", &materials.entries, storage)?,
            transforms: device.upload(
                "texture transforms",
                materials.transforms.entries(),
                storage,
            )?,
            lights: device.upload("lights", &light_entries, storage)?,
            lists: device.upload("light lists", &lists, storage)?,
            textures,
            features,
            mesh_materials: mesh_materials.chain(to_come).collect(),
            material_slots: MaterialSlots::new(surfaces, materials, &options.spare),
            mesh_sprites: sprites::places(scene, hierarchy.leaf_objects().len()),
            default_material,
            degradations,
            dirty_lights: Marked::none_of(table.lights.len()),
            table,
            light_lists,
            first_transparent_slot,
            transparent,
            environment: EnvironmentTexture::new(device, surfaces.environment.as_ref())?,
            exposure: if surfaces.exposure.is_finite() { surfaces.exposure.max(0.0) } else { 1.0 },
        }))
    }

    /// Returns true if an object that is not transparent has holes. A
    /// [`SurfaceKind::Depth`](crate::passes::SurfaceKind::Depth) pass then draws the depth;
    /// otherwise [`OpaquePass::depth_only`](crate::passes::OpaquePass::depth_only) does.
    pub fn is_masked(&self) -> bool {
        self.features[0].is_masked
    }

    /// Returns the slot of the first of [`Surfaces::transparent`]; the others follow.
    pub fn first_transparent_slot(&self) -> u32 {
        self.first_transparent_slot
    }

    /// Returns the last 16 bytes of the instance of an object, which hold only its tint in other
    /// scenes.
    pub fn instance_tail(&self, object: &Object, slot: u32) -> [u32; 4] {
        let mesh = object.mesh;
        let material =
            self.mesh_materials.get(mesh.0 as usize).copied().unwrap_or(self.default_material);
        let sprites = self.mesh_sprites.get(mesh.0 as usize).copied().unwrap_or(0);
        [material, slot, lights_and_tint(self.light_lists.count(slot), object.tint), sprites]
    }

    /// Returns true if a mesh consists of sprites.
    pub(crate) fn is_of_sprites(&self, mesh: MeshId) -> bool {
        self.mesh_sprites.get(mesh.0 as usize).is_some_and(|place| *place != 0)
    }

    /// Returns true if objects with a mesh cast shadow volumes: its material is opaque, and it does
    /// not consist of sprites.
    pub(crate) fn casts_volumes(&self, mesh: MeshId) -> bool {
        let of_mesh = |values: &[u32]| values.get(mesh.0 as usize).copied();
        let material = of_mesh(&self.mesh_materials).unwrap_or(self.default_material);
        let is_sprites = of_mesh(&self.mesh_sprites).is_some_and(|place| place != 0);
        self.material_slots.is_opaque(MaterialId(material)) && !is_sprites
    }

    /// Returns true if the material of a mesh is masked.
    pub(crate) fn has_holes(&self, mesh: MeshId) -> bool {
        let material = self.mesh_materials.get(mesh.0 as usize).copied();
        self.material_slots.is_masked(MaterialId(material.unwrap_or(self.default_material)))
    }

    /// Refuses a material that cannot be added, with the reason.
    pub(crate) fn check_material(&self, material: &Material) -> Result<(), MaterialError> {
        self.material_slots.check(material, &self.features[0])
    }

    /// Sets the material of a mesh that no object has; `None` for a mesh that is removed.
    pub(crate) fn set_mesh_material(&mut self, mesh: MeshId, material: Option<MaterialId>) {
        let now = material.map_or(self.default_material, |material| material.0);
        if let Some(there) = self.mesh_materials.get_mut(mesh.0 as usize) {
            self.material_slots.count_user(std::mem::replace(there, now), now);
        }
    }

    /// Takes a place for a texture that was checked.
    pub(crate) fn add_texture(
        &mut self,
        texture: &PreparedTexture,
    ) -> Result<(TextureId, TexturePlace), Error> {
        let (id, place) = self.textures.add(texture)?;
        self.material_slots.place_texture(id, Some(place));
        Ok((id, place))
    }

    /// Returns the mip maps of a texture that the device does not generate.
    pub(crate) fn levels_by_cpu(
        &self,
        place: TexturePlace,
        texture: &PreparedTexture,
    ) -> Vec<Vec<u8>> {
        let Texels::Rgba8(rgba8) = &texture.image().texels else { return Vec::new() };
        let array = self.textures.array(place);
        array.map(|array| array.levels_by_cpu(rgba8)).unwrap_or_default()
    }

    /// Refuses to remove a texture that is in use, that the scene began with, or that does not
    /// exist.
    pub(crate) fn check_texture_removal(&self, texture: TextureId) -> Result<(), TextureError> {
        self.textures.check_removal(texture)?;
        if self.material_slots.uses_texture(texture) { Err(TextureError::InUse) } else { Ok(()) }
    }

    /// Refuses the picture of a light that cannot be shown, with the reason.
    pub(crate) fn check_cookie(&self, light: &PunctualLight) -> Result<(), &'static str> {
        self.material_slots.check_cookie(light, &self.features[0])
    }

    /// Frees the place of a texture that no material uses.
    pub(crate) fn remove_texture(&mut self, texture: TextureId) {
        self.textures.remove(texture);
        self.material_slots.place_texture(texture, None);
    }

    /// Returns true if any mesh consists of sprites.
    pub(crate) fn has_sprites(&self) -> bool {
        self.mesh_sprites.iter().any(|place| *place != 0)
    }

    /// Returns the [`SurfaceVertex`]es of all meshes, in the order of their vertices. A compute
    /// shader may write them.
    pub fn vertices(&self) -> BufferSlice {
        self.vertices.whole()
    }

    /// Returns the parts that are shown in a degraded form, with the present lights and objects.
    pub(crate) fn degradations(&self) -> SceneDegradations {
        SceneDegradations {
            crowded_objects: self.light_lists.crowded(),
            broken_lights: self.table.lights.iter().filter(|light| is_broken(light)).count(),
            ..self.degradations
        }
    }

    /// Returns the factor on all light before tone mapping.
    pub fn exposure(&self) -> f32 {
        self.exposure
    }

    /// Finds the lights of the object in a slot by its present box; an empty box means no object.
    /// Returns true if its instance must be uploaded again.
    pub(crate) fn find_lights(&mut self, slot: u32, bounds: &Aabb) -> bool {
        self.light_lists.has_lights() && self.light_lists.find(slot, bounds)
    }

    /// Notes that a transparent object has moved. Fails if it does not exist.
    pub(crate) fn move_transparent(
        &mut self,
        transparent: TransparentId,
        bounds: &Aabb,
    ) -> Result<(), HierarchyError> {
        self.transparent.refit([(ObjectId(transparent.0), *bounds)])?;
        self.find_lights(self.first_transparent_slot + transparent.0, bounds);
        Ok(())
    }

    /// Replaces a light by one of the same kind; the next frame shows it. Objects around its old
    /// and its new place, transparent ones included, must [find their
    /// lights](SurfaceResources::relight) again.
    pub(crate) fn replace_light(
        &mut self,
        hierarchy: &Hierarchy,
        light: LightId,
        to: PunctualLight,
    ) {
        let number = light.0 as usize;
        let place = self.table.places.get(number).copied().flatten();
        if let Some(there) = self.table.lights.get_mut(number) {
            self.material_slots.count_cookie(there, -1);
            self.material_slots.count_cookie(&to, 1);
            *there = to;
            self.dirty_lights.mark_dirty(light.0);
        }
        for (centre, radius_m) in self.light_lists.replace(number, place, &to) {
            self.light_lists.doubt(hierarchy, 0, centre, radius_m);
            self.light_lists.doubt(
                &self.transparent,
                self.first_transparent_slot,
                centre,
                radius_m,
            );
        }
    }

    /// Returns the number of lights of a kind that can be added.
    pub(crate) fn light_room(&self, kind: LightKind) -> usize {
        let is_compiled = self.features[0].has_spots || !matches!(kind, LightKind::Spot { .. });
        if is_compiled { self.table.room(kind) } else { 0 }
    }

    /// Adds a light, if there is [room](SurfaceResources::light_room): a dark light begins to
    /// shine.
    pub(crate) fn add_light(
        &mut self,
        hierarchy: &Hierarchy,
        light: PunctualLight,
    ) -> Option<LightId> {
        let id = self.table.take(light.kind)?;
        self.replace_light(hierarchy, id, light);
        Some(id)
    }

    /// Makes a light dark and frees its id.
    pub(crate) fn remove_light(&mut self, hierarchy: &Hierarchy, light: LightId) {
        if let Some(kind) = self.table.get(light).map(|light| light.kind) {
            self.replace_light(hierarchy, light, dark_light(kind));
            self.table.free(light);
        }
    }

    /// Finds the lights of transparent objects again around lights that changed. Returns the other
    /// objects whose lights must be found again.
    pub(crate) fn relight(&mut self) -> Vec<ObjectId> {
        let mut objects = self.light_lists.take_doubtful();
        objects.retain(|slot| {
            let Some(transparent) = slot.checked_sub(self.first_transparent_slot) else {
                return true;
            };
            if let Some(node) = self.transparent.node_of(ObjectId(transparent)) {
                self.light_lists.find(*slot, &self.transparent.bounds(node));
            }
            false
        });
        objects.into_iter().map(ObjectId).collect()
    }

    /// Records the upload of changed lights and lists, before anything of `frame` reads them. They
    /// stay marked until the frame was [submitted](SurfaceResources::submitted).
    pub(crate) fn upload_changes(
        &self,
        frame: &mut Frame<'_>,
        scatter: &ScatterPass,
    ) -> Result<(), Error> {
        let materials = self.materials.whole();
        let transforms = self.transforms.whole();
        self.material_slots.upload_changes(frame, scatter, materials, transforms)?;
        let dirty = self.light_lists.dirty();
        if !dirty.is_empty() {
            let uploads = frame.uploads();
            let leaves = uploads.push(dirty)?;
            let elements =
                uploads.push_iter(dirty.iter().map(|slot| self.light_lists.values(*slot)))?;
            let array = self.lists.whole();
            let io = ScatterIo { leaves, elements, array, element_bytes: LIST_VALUES * 4 };
            scatter.record(frame.commands(), dirty.len() as u32, [io]);
        }
        let changed = || {
            self.dirty_lights.list().iter().filter_map(|light| {
                let light = *light as usize;
                let place = self.table.places.get(light).copied().flatten()?;
                Some((place, self.table.lights.get(light)?))
            })
        };
        let count = changed().count();
        if count > 0 {
            let places: Vec<u32> = changed().map(|(place, _)| place).collect();
            let entry = |light: &PunctualLight| {
                let picture =
                    light.cookie.and_then(|picture| self.material_slots.place(picture.texture));
                LightEntry::of(light, picture)
            };
            let entries: Vec<LightEntry> = changed().map(|(_, light)| entry(light)).collect();
            let uploads = frame.uploads();
            let leaves = uploads.push(&places)?;
            let elements = uploads.push(&entries)?;
            let array = self.lights.whole();
            let element_bytes = size_of::<LightEntry>();
            let io = ScatterIo { leaves, elements, array, element_bytes };
            scatter.record(frame.commands(), count as u32, [io]);
        }
        Ok(())
    }

    /// Notes that the frame of the last [`SurfaceResources::upload_changes`] was submitted.
    pub(crate) fn submitted(&mut self) {
        self.material_slots.submitted();
        self.light_lists.submitted();
        self.dirty_lights.drain().for_each(drop);
    }

    /// Returns the features that transparent objects use, or that all other objects use.
    pub(crate) fn features(&self, is_transparent: bool) -> &Features {
        &self.features[usize::from(is_transparent)]
    }

    /// Returns the buffers at the bindings after the instances: materials, transforms, lights and
    /// lists.
    pub(crate) fn buffers(&self) -> [BufferSlice; 4] {
        [&self.materials, &self.transforms, &self.lights, &self.lists].map(Buffer::whole)
    }
}

/// Returns the vertices of all meshes in the order of their positions, followed by the vertices of
/// sprites and room for more.
fn surface_vertices(
    scene: &Scene,
    surfaces: &Surfaces,
    spare: &SpareCapacity,
) -> Result<Vec<SurfaceVertex>, Error> {
    let meshes = mesh_order(scene).into_iter().filter_map(|mesh| surfaces.meshes.get(mesh));
    let count = surfaces.meshes.iter().map(|mesh| mesh.vertices.len()).sum::<usize>();
    let [pattern, _] = sprites::pattern_size(scene);
    let count = count + pattern + spare.vertices as usize;
    let mut vertices: Vec<SurfaceVertex> =
        limits::room("what the vertices of all meshes look like", count)?;
    meshes.for_each(|mesh| vertices.extend_from_slice(&mesh.vertices));
    sprites::add_surface_pattern(scene, &mut vertices);
    vertices.resize(count, bytemuck::Zeroable::zeroed());
    Ok(vertices)
}

fn degradations_of(plan: &PagePlan, table: &LightTable) -> SceneDegradations {
    SceneDegradations {
        shrunk_images: plan.shrunk,
        enlarged_images: plan.resampled - plan.shrunk,
        unpacked_images: plan.unpacked,
        borrowed_samplers: plan.resampled_by_others,
        textures: if plan.are_own { TextureStorage::Bindless } else { TextureStorage::ArrayPacked },
        dark_suns: table.dark_suns,
        ..SceneDegradations::default()
    }
}

fn features(
    surfaces: &Surfaces,
    plan: &PagePlan,
    places: &[Option<TexturePlace>],
    table: &LightTable,
    lists: &LightLists,
    spare: &SpareCapacity,
) -> [Features; 2] {
    [false, true].map(|is_transparent| {
        let fallback = scene::Material::default();
        let is_of_class =
            |material: &&scene::Material| (material.alpha == Alpha::Blend) == is_transparent;
        let materials = surfaces.materials.iter().filter(is_of_class).chain([&fallback]);
        let is_spot = |light: &PunctualLight| matches!(light.kind, LightKind::Spot { .. });
        let features = Features {
            directional_lights: table.directional,
            has_local_lights: lists.has_lights(),
            has_spots: spare.lights > 0 || table.lights.iter().any(is_spot),
            pictures: Features::cookie_pages(surfaces, places, plan),
            ..Features::of(materials, places)
        };
        let has_room = spare.materials > 0 && !is_transparent;
        if has_room { features.of_any(plan) } else { features }
    })
}
