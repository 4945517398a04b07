//! Checks that surfaces belong to a scene, and that tables have room for them.

use cull::Hierarchy;
use gpu::Device;
use scene::limits::{MAX_DIRECTIONAL_LIGHTS, MAX_LIGHTS};
use scene::{LightKind, Material, PunctualLight, Scene, Surfaces};

use crate::error::Error;
use crate::resources::limits;
use crate::resources::spare_capacity::SpareCapacity;
use crate::shading::surfaces::light_lists::LIST_VALUES;
use crate::shading::surfaces::materials::MaterialEntry;

/// The bytes of a material during its upload, and of its place.
const MATERIAL_BYTES: usize = size_of::<Material>() + 2 * size_of::<MaterialEntry>() + 8;

/// Refuses more elements than the tables of the shaders hold.
pub(super) fn check_counts(
    device: &Device,
    surfaces: &Surfaces,
    hierarchy: &Hierarchy,
    spare: &SpareCapacity,
) -> Result<(), Error> {
    let transparent = surfaces.transparent.len() as u64;
    check_lights(surfaces, spare)?;
    let materials = surfaces.materials.len() as u64 + u64::from(spare.materials) + 1;
    let bytes = size_of::<MaterialEntry>() as u64;
    limits::check_storage(
        device,
        "materials, with room",
        materials,
        bytes,
        "let meshes share materials",
    )?;
    limits::check_memory("materials", materials as usize, MATERIAL_BYTES)?;
    const SPLIT: &str = "split the scene, or join objects that stand still";

    limits::check_storage(
        device,
        "transparent objects",
        transparent,
        scene::limits::INSTANCE_BYTES,
        SPLIT,
    )?;
    let is_local = |light: &PunctualLight| light.kind != LightKind::Directional;
    if spare.lights > 0 || surfaces.lights.iter().any(is_local) {
        let slots = hierarchy.leaf_objects().len() as u64 + transparent;
        let lists_bytes = LIST_VALUES as u64 * 4;
        limits::check_storage(device, "objects in the light of lamps", slots, lists_bytes, SPLIT)?;
    }
    Ok(())
}

/// Refuses more lights, including the room for more, than the light table holds.
fn check_lights(surfaces: &Surfaces, spare: &SpareCapacity) -> Result<(), Error> {
    let [local, directional] = [spare.lights, spare.directional_lights].map(u64::from);
    let lights = surfaces.lights.len() as u64 + local + directional;
    const LESS: &str = "leave lights out, the weakest first, or keep room for fewer";
    limits::check("lights", lights, MAX_LIGHTS as u64, LESS)?;
    let is_sun = |light: &&PunctualLight| light.kind == LightKind::Directional;
    let suns = surfaces.lights.iter().filter(is_sun).count().min(MAX_DIRECTIONAL_LIGHTS) as u64;
    const FEWER: &str = "keep room for fewer with `RendererOptions::spare`";
    limits::check(
        "directional lights that may shine",
        suns + directional,
        MAX_DIRECTIONAL_LIGHTS as u64,
        FEWER,
    )
}

/// Refuses surfaces that do not belong to the scene.
pub(super) fn check(scene: &Scene, surfaces: &Surfaces) -> Result<(), Error> {
    let broken = |mesh: usize| {
        let beside = surfaces.meshes.get(mesh).map(|mesh| mesh.vertices.len());
        beside != scene.meshes.get(mesh).map(|mesh| mesh.vertices.len())
    };
    if let Some(mesh) =
        (0..scene.meshes.len().max(surfaces.meshes.len())).find(|mesh| broken(*mesh))
    {
        let name = scene.meshes.get(mesh).map(|mesh| mesh.name.clone()).unwrap_or_default();
        let fault = "it has not as many surface vertices as vertices";
        return Err(scene::SceneError::BrokenMesh { mesh: name, fault }.into());
    }
    for image in &surfaces.images {
        let size = image.size;
        let check = image.check();
        check.map_err(|fault| Error::Image { image: image.name.clone(), size, fault })?;
    }
    Ok(())
}
