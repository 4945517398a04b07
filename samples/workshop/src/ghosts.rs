//! The transparent objects that replace parts while these are shown transparent.

use antumbra::glam::{Affine3A, Mat3A, Vec3A};
use antumbra::scene::{
    Alpha, Material, MaterialId, MeshId, Object, Scene, Surfaces, TransparentId,
};

use crate::document::CommandError;

/// The most objects of a model whose parts can be shown transparent. Each object needs a second
/// object on the GPU, and transparent objects are sorted in every frame.
const MOST_GHOSTED_OBJECTS: usize = 4096;

/// The opacity of a transparent part.
const GHOST_ALPHA: f32 = 0.25;

/// The transform of a transparent object that is not shown: it collapses to a point.
pub(crate) const NOWHERE: Affine3A = Affine3A { matrix3: Mat3A::ZERO, translation: Vec3A::ZERO };

/// Adds a transparent object, which is not shown, for each object of a scene. Returns the first
/// one. Changes nothing if there are too many objects.
pub(crate) fn add_ghosts(scene: &mut Scene) -> Result<TransparentId, CommandError> {
    let Scene { meshes, objects, surfaces, .. } = scene;
    let surfaces = surfaces.get_or_insert_default();
    let first_ghost = TransparentId(surfaces.transparent.len() as u32);
    if objects.len() > MOST_GHOSTED_OBJECTS {
        return Err(CommandError::TooManyToGhost(MOST_GHOSTED_OBJECTS));
    }
    let first_mesh = meshes.len() as u32;
    let first_material = surfaces.materials.len() as u32;
    let ghosts = surfaces.materials.iter().map(|material| {
        let [red, green, blue, _] = material.base_colour;
        let base_colour = [red, green, blue, GHOST_ALPHA];
        Material { base_colour, alpha: Alpha::Blend, ..material.clone() }
    });
    let ghosts: Vec<Material> = ghosts.collect();
    surfaces.materials.extend(ghosts);
    for index in 0..first_mesh as usize {
        meshes.push(meshes[index].clone());
        let mut surface = surfaces.meshes[index].clone();
        surface.material = MaterialId(first_material + surface.material.0);
        surfaces.meshes.push(surface);
    }
    let Surfaces { levels, transparent, .. } = surfaces;
    if !levels.is_empty() {
        levels.resize(meshes.len(), Vec::new());
    }
    transparent.extend(objects.iter().map(|object| Object {
        mesh: MeshId(first_mesh + object.mesh.0),
        transform: NOWHERE,
        ..*object
    }));
    Ok(first_ghost)
}
