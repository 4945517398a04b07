//! Checks that the surfaces of a scene belong to it and can be drawn: for a scene that passes, no
//! shader reads out of bounds or meets a value that is not finite.

use super::error::SceneError;
use super::surface::{MorphTarget, SkinWeights, SkinnedMesh, Surfaces};
use super::{Scene, bounds_of_transformed};

/// The tolerance of the sum of a vertex's weights, which may be rounded to eight bits each.
const WEIGHT_SLACK: f32 = 1.0 / 32.0;

/// A part of the surfaces.
#[derive(Clone, Copy)]
struct Part {
    kind: &'static str,
    /// The index among parts of its kind.
    index: usize,
}

fn part_of(kind: &'static str, index: usize) -> Part {
    Part { kind, index }
}

fn broken(part: Part, fault: &'static str) -> Result<(), SceneError> {
    Err(SceneError::BrokenSurfaces { part: part.kind, index: part.index, fault })
}

fn are_finite<const N: usize>(numbers: &[f32; N]) -> bool {
    numbers.iter().all(|number| number.is_finite())
}

/// Finds the first fault in the surfaces of a scene whose meshes and objects have been checked.
pub(super) fn check_surfaces(scene: &Scene, surfaces: &Surfaces) -> Result<(), SceneError> {
    if surfaces.meshes.len() != scene.meshes.len() {
        return broken(
            part_of("mesh", surfaces.meshes.len().min(scene.meshes.len())),
            "there must be as many as the scene has meshes",
        );
    }
    for (index, (surface, mesh)) in surfaces.meshes.iter().zip(&scene.meshes).enumerate() {
        let part = part_of("mesh", index);
        if surface.vertices.len() != mesh.vertices.len() {
            return broken(part, "it has not as many surface vertices as vertices");
        }
        if surface.vertices.iter().any(|vertex| !vertex.uv.iter().all(are_finite)) {
            return broken(part, "a texture coordinate is not a finite number");
        }
    }
    for (index, texture) in surfaces.textures.iter().enumerate() {
        if texture.image.0 as usize >= surfaces.images.len() {
            return broken(part_of("texture", index), "the scene does not have its image");
        }
    }
    for (index, material) in surfaces.materials.iter().enumerate() {
        let checked = material.check(surfaces.textures.len());
        checked.or_else(|fault| broken(part_of("material", index), fault))?;
    }
    for (index, light) in surfaces.lights.iter().enumerate() {
        let checked = light.check_cookie(surfaces.textures.len());
        checked.or_else(|fault| broken(part_of("light", index), fault))?;
    }
    if !surfaces.exposure.is_finite() {
        return broken(part_of("exposure", 0), "it is not a finite number");
    }
    check_transparent(scene, surfaces)?;
    check_levels(scene, surfaces)?;
    check_sprites(scene, surfaces)?;
    check_skinned_meshes(scene, surfaces)
}

/// Returns for each mesh true if it is a mesh of sprites.
pub(super) fn sprite_meshes(scene: &Scene) -> Vec<bool> {
    let mut are_sprites = vec![false; scene.meshes.len()];
    for sprites in scene.surfaces.iter().flat_map(|surfaces| &surfaces.sprites) {
        if let Some(are_sprites) = are_sprites.get_mut(sprites.mesh.0 as usize) {
            *are_sprites = true;
        }
    }
    are_sprites
}

fn check_sprites(scene: &Scene, surfaces: &Surfaces) -> Result<(), SceneError> {
    for (index, sprites) in surfaces.sprites.iter().enumerate() {
        let part = part_of("sprites", index);
        let Some(mesh) = scene.meshes.get(sprites.mesh.0 as usize) else {
            return broken(part, "the scene does not have its mesh");
        };
        if let Some(fault) = sprites.fault() {
            return broken(part, fault);
        }
        if !mesh.vertices.is_empty() || !mesh.indices.is_empty() {
            return broken(part, "its mesh has vertices or triangles of its own");
        }
        if mesh.bounds != sprites.bounds() {
            return broken(part, "the bounds of its mesh are not the box around its sprites");
        }
    }
    let are_sprites = sprite_meshes(scene);
    let is_sprites = |mesh: super::MeshId| are_sprites.get(mesh.0 as usize) == Some(&true);
    if let Some(index) = surfaces.transparent.iter().position(|object| is_sprites(object.mesh)) {
        return broken(part_of("transparent object", index), "its mesh is one of sprites");
    }
    if let Some(index) =
        surfaces.skinned_meshes.iter().position(|skinned_mesh| is_sprites(skinned_mesh.mesh))
    {
        return broken(part_of("skinned mesh", index), "its mesh is one of sprites");
    }
    Ok(())
}

fn check_transparent(scene: &Scene, surfaces: &Surfaces) -> Result<(), SceneError> {
    for (index, object) in surfaces.transparent.iter().enumerate() {
        let part = part_of("transparent object", index);
        let Some(mesh) = scene.mesh_of(object) else {
            return broken(part, "the scene does not have its mesh");
        };
        let bounds = bounds_of_transformed(&mesh.bounds, &object.transform);
        if !object.transform.is_finite() || !bounds.is_usable() {
            return broken(part, "its transform takes it nowhere");
        }
    }
    Ok(())
}

fn check_levels(scene: &Scene, surfaces: &Surfaces) -> Result<(), SceneError> {
    if !surfaces.levels.is_empty() && surfaces.levels.len() != scene.meshes.len() {
        return broken(
            part_of("the levels of mesh", surfaces.levels.len()),
            "there are as many as meshes, or none",
        );
    }
    for (index, (mesh, levels)) in scene.meshes.iter().zip(&surfaces.levels).enumerate() {
        let part = part_of("the levels of mesh", index);
        let is_in_mesh = |vertex: &u32| (*vertex as usize) < mesh.vertices.len();
        let mut before_m = 0.0;
        for level in levels {
            if !level.indices.len().is_multiple_of(3) || !level.indices.iter().all(is_in_mesh) {
                return broken(part, "its indices are not triangles of the mesh's vertices");
            }
            if !(level.error_m.is_finite() && level.error_m >= before_m) {
                return broken(part, "errors are finite and ascend");
            }
            before_m = level.error_m;
        }
    }
    Ok(())
}

fn check_skinned_meshes(scene: &Scene, surfaces: &Surfaces) -> Result<(), SceneError> {
    // The number of objects of each mesh: a skinned mesh may have one.
    let mut users = vec![0_u32; scene.meshes.len()];
    for object in scene.objects.iter().chain(&surfaces.transparent) {
        if let Some(users) = users.get_mut(object.mesh.0 as usize) {
            *users = users.saturating_add(1);
        }
    }
    let mut is_skinned = vec![false; scene.meshes.len()];
    for (index, skinned_mesh) in surfaces.skinned_meshes.iter().enumerate() {
        let part = part_of("skinned mesh", index);
        let mesh = skinned_mesh.mesh.0 as usize;
        let (Some(users), Some(is_skinned)) = (users.get(mesh), is_skinned.get_mut(mesh)) else {
            return broken(part, "the scene does not have its mesh");
        };
        if *users > 1 {
            return broken(part, "several objects have its mesh: give each a mesh of its own");
        }
        if std::mem::replace(is_skinned, true) {
            return broken(part, "another one has its mesh");
        }
        check_skinned_mesh(
            skinned_mesh,
            scene.meshes.get(mesh).map_or(0, |mesh| mesh.vertices.len()),
            part,
        )?;
    }
    Ok(())
}

fn check_skinned_mesh(
    skinned_mesh: &SkinnedMesh,
    vertices: usize,
    part: Part,
) -> Result<(), SceneError> {
    if let Some(skin) = &skinned_mesh.skin {
        check_skin(skin, vertices, part)?;
    }
    for MorphTarget { positions, normals, tangents } in &skinned_mesh.targets {
        for list in [positions, normals, tangents] {
            if !list.is_empty() && list.len() != vertices {
                return broken(part, "a list of a morph target is not as long as its mesh's");
            }
            if !list.iter().all(are_finite) {
                return broken(part, "a morph target has a number that is not finite");
            }
        }
    }
    Ok(())
}

fn check_skin(skin: &SkinWeights, vertices: usize, part: Part) -> Result<(), SceneError> {
    let sets = skin.sets as usize;
    let wanted = vertices.checked_mul(sets);
    if sets == 0 || Some(skin.joints.len()) != wanted || Some(skin.weights.len()) != wanted {
        return broken(part, "it has not as many joints and weights as its vertices need");
    }
    for (joints, weights) in skin.joints.chunks(sets).zip(skin.weights.chunks(sets)) {
        let joints = joints.as_flattened();
        let weights = weights.as_flattened();
        if weights.iter().any(|weight| !weight.is_finite() || *weight < 0.0) {
            return broken(part, "a weight is not a positive finite number");
        }
        if (weights.iter().sum::<f32>() - 1.0).abs() > WEIGHT_SLACK {
            return broken(part, "the weights of a vertex are not 1 together");
        }
        let mut hangs = joints.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
        if hangs.any(|(joint, _)| u32::from(*joint) >= skin.joint_count) {
            return broken(part, "a vertex hangs on a joint that it does not have");
        }
    }
    Ok(())
}
