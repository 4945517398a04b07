//! Skinned meshes: each node with one gets its own mesh, and a box that the mesh never leaves.

use animation::RigNodeId;
use glam::Affine3A;
use scene::{Object, SkinnedMesh, SkinnedMeshId};

use super::assembly::{Assembly, NO_TINT};
use super::geometry::Geometry;
use super::materials::MaterialUse;
use super::primitives::{Facing, Primitive, Variant};
use super::skinned_extents::{SkinnedExtent, SkinnedPrimitive};
use super::skins::Used;
use crate::gltf_scene::NodeAttachment;
use crate::{Cause, ImportError};

/// Places a skinned or morphed primitive at its node or its joints.
pub(super) fn place_skinned(
    assembly: &mut Assembly<'_>,
    primitive: &Primitive<'_>,
    material: MaterialUse,
    name: String,
    node: RigNodeId,
    skin: Option<usize>,
    locals: &[Affine3A],
) -> Result<(), ImportError> {
    let skin = match skin {
        Some(skin) => {
            let losses = &mut assembly.losses;
            let notes = &mut assembly.notes;
            let used = assembly.skins.used(assembly.source, assembly.tree, skin, losses, notes)?;
            let Some(used) = used else { return Ok(()) };
            Some(used)
        }
        None => None,
    };
    // A skinned mesh is at its joints, while instances are relative to nodes.
    let once = [Affine3A::IDENTITY];
    let locals = if skin.is_some() { &once } else { locals };
    // All instances of a mesh share one pose.
    let mut known: Option<Option<SkinnedExtent>> = None;
    for local in locals {
        assembly.report()?;
        let place = assembly.tree.world(node) * *local;
        let facing = match skin {
            Some(skin) => facing_of(assembly, skin, node),
            None => Facing::of(&place, assembly.may_turn(node)),
        };
        let joints = skin.map(|skin| skin.joints);
        let variant = Variant { facing, joints, is_morphed: true };

        let built = primitive.build(
            variant,
            &material,
            &assembly.sight,
            &place,
            &mut assembly.budget,
            &mut assembly.notes,
        );
        let Some(geometry) = assembly.unbroken(built)? else {
            return Ok(());
        };
        let form = match known.take() {
            Some(form) => form,
            None => form(assembly, primitive, &geometry, node, skin)?,
        };
        let form = match known.insert(form) {
            Some(form) => *form,
            None => {
                assembly.leave_out_huge(node);
                continue;
            }
        };
        let transform = match (skin.is_some(), form.space) {
            (true, Some(space)) => assembly.tree.world(space),
            (true, None) => Affine3A::IDENTITY,
            (false, _) => place,
        };
        if !assembly.can_be_seen(form.space.unwrap_or(node), &transform) {
            continue;
        }
        if !form.is_usable(&transform) {
            assembly.leave_out_huge(node);
            continue;
        }
        let part = SkinnedPart {
            geometry,
            material: &material,
            name: name.clone(),
            node,
            skin,
            form,
            transform,
            local: *local,
        };
        add_skinned(assembly, part)?;
    }
    Ok(())
}

/// Returns the facing of meshes with a skin.
fn facing_of(assembly: &mut Assembly<'_>, skin: Used, node: RigNodeId) -> Facing {
    let joints = assembly.skins.list.get(skin.skin).map_or(&[][..], |skin| &skin.joints);
    let turns = |joint: &RigNodeId| assembly.turns.get(joint.0 as usize) == Some(&true);
    if *assembly.turning_skins.entry(skin.skin).or_insert_with(|| joints.iter().any(turns)) {
        assembly.note_turning(node);
        return Facing::Both;
    }
    if skin.is_mirrored { Facing::Mirrored } else { Facing::Plain }
}

/// A mesh that a skin or morph targets change, at its place.
struct SkinnedPart<'a> {
    geometry: Geometry,
    material: &'a MaterialUse,
    name: String,
    node: RigNodeId,
    skin: Option<Used>,
    form: SkinnedExtent,
    transform: Affine3A,
    /// The transform relative to its node.
    local: Affine3A,
}

fn add_skinned(assembly: &mut Assembly<'_>, part: SkinnedPart<'_>) -> Result<(), ImportError> {
    let SkinnedPart { mut geometry, material, name, node, skin, form, transform, local } = part;
    assembly.budget.take_skinned(geometry.positions.len() as u64).map_err(|over| {
        assembly.source.error(Cause::TooLarge, assembly.tree.name(node), over.to_string())
    })?;
    let used = skin.and_then(|used| assembly.skins.list.get(used.skin));
    let seen_at_rest = form.seen_at_rest(&geometry, node, used, assembly.tree, &transform);
    let mesh = assembly.add_mesh(&geometry, material, name);
    let skinned_mesh = SkinnedMeshId(assembly.surfaces.skinned_meshes.len() as u32);
    assembly.surfaces.skinned_meshes.push(SkinnedMesh {
        mesh,
        skin: geometry.skin.take(),
        targets: std::mem::take(&mut geometry.targets),
    });
    let object = Object { mesh, transform, tint: NO_TINT };
    let placed = assembly.add_object(node, object, material)?;
    assembly.placements.push(NodeAttachment {
        node,
        placed,
        local,
        skinned_mesh: Some((skinned_mesh, skin.map(|skin| skin.skin))),
        seen_at_rest,
        reach: form.reach,
    });
    Ok(())
}

/// Returns the space and the reach of the mesh; `None` if it has no skeleton.
fn form(
    assembly: &mut Assembly<'_>,
    primitive: &Primitive<'_>,
    geometry: &Geometry,
    node: RigNodeId,
    skin: Option<Used>,
) -> Result<Option<SkinnedExtent>, ImportError> {
    let skin = skin.and_then(|used| Some((used.skin, assembly.skins.list.get(used.skin)?)));
    let skinned = SkinnedPrimitive { primitive, geometry, node, skin };
    assembly.skinned_extents.form(&assembly.tree.rig, &skinned)
}
