//! Meshes that change their form: each node that has one gets its own, with the boxes that it stays in.

use animation::{Binding, Clip, DeformedMesh, NodeId, Reach, ReachError, Rig, Skeleton, Skin};
use cull::Aabb;
use glam::{Affine3A, Vec3};
use render::scene::{Deformer, DeformerId, Object};

use super::assembly::{Assembly, NO_TINT};
use super::geometry::Geometry;
use super::materials::MaterialUse;
use super::nodes::Tree;
use super::numbers::mirrors;
use super::primitives::{Primitive, Variant};
use super::skins::{Used, used_joints};
use crate::imported::Placement;
use crate::{Cause, ImportError};

/// How many boxes of clips are found one by one. A file with more gets one for all clips together.
const MOST_BOXES: usize = 2000;

/// The most nodes that are gone through to find skeletons: each is looked for in the whole rig.
const MOST_STEPS: u64 = 1 << 33;

/// Where a mesh is that changes its form, and how far it reaches.
struct Form {
    /// The node in whose space it is; `None` for the world's.
    space: Option<NodeId>,
    rest_bounds: Aabb,
    clip_bounds: Vec<Aabb>,
    blend_bounds: Aabb,
}

impl Form {
    /// The box in the world of what is seen at rest, as close as it can be: `rest_bounds` lies askew there.
    fn seen_at_rest(
        &self,
        geometry: &Geometry,
        skin: Option<&Skin>,
        tree: &Tree,
        transform: &Affine3A,
    ) -> Aabb {
        let all = in_world(&self.rest_bounds, transform);
        let (Some(skin), Some(weights)) = (skin, &geometry.skin) else { return all };
        if !geometry.targets.is_empty() {
            return all;
        }
        let joints = skin.joints.iter().zip(&skin.inverse_bind);
        let matrices: Vec<_> = joints.map(|(joint, bind)| tree.world(*joint) * *bind).collect();
        let sets = (weights.sets as usize).max(1);
        let followed = weights.joints.chunks(sets).zip(weights.weights.chunks(sets));
        let mut seen = Aabb::EMPTY;
        for (position, (joints, weights)) in geometry.positions.iter().zip(followed) {
            let named = joints.as_flattened().iter().zip(weights.as_flattened());
            let at: Vec3 = named
                .filter(|(_, weight)| **weight > 0.0)
                .filter_map(|(joint, weight)| Some((matrices.get(usize::from(*joint))?, weight)))
                .map(|(matrix, weight)| matrix.transform_point3(*position) * *weight)
                .sum();
            seen = seen.union(&Aabb::new(at, at));
        }
        if seen.is_usable() { seen } else { all }
    }

    fn boxes(&self) -> impl Iterator<Item = &Aabb> {
        self.clip_bounds.iter().chain([&self.rest_bounds, &self.blend_bounds])
    }
}

/// What was done to find forms.
#[derive(Debug, Default)]
pub(super) struct Forms {
    boxes: usize,
    steps: u64,
}

impl Assembly<'_> {
    /// Puts a primitive that is skinned or morphed where its node or its joints are.
    ///
    /// # Errors
    /// What [`Primitive::build`] refuses; more skinned meshes than can be looked through.
    pub(super) fn place_deformed(
        &mut self,
        (primitive, material, name): (&Primitive<'_>, MaterialUse, String),
        node: NodeId,
        skin: Option<usize>,
        locals: &[Affine3A],
    ) -> Result<(), ImportError> {
        let skin = match skin {
            Some(skin) => match self.skins.used(self.source, self.tree, skin, &mut self.notes) {
                Some(used) => Some(used),
                None => return Ok(()),
            },
            None => None,
        };
        // A skinned mesh is where its joints are, and instances are where nodes are.
        let once = [Affine3A::IDENTITY];
        let locals = if skin.is_some() { &once } else { locals };
        for local in locals {
            let place = self.tree.world(node) * *local;
            let is_mirrored = skin.map_or_else(|| mirrors(&place), |skin| skin.is_mirrored);
            let joints = skin.map(|skin| skin.joints);
            let variant = Variant { is_mirrored, joints, is_morphed: true };
            let seen = (&self.sight, &place);
            let built =
                primitive.build(variant, &material, seen, &mut self.budget, &mut self.notes)?;
            let Some(geometry) = built else {
                return Ok(());
            };
            let form = match self.form(primitive, &geometry, node, skin)? {
                Some(form) => form,
                None => {
                    self.leave_out_huge(node);
                    continue;
                }
            };
            let transform = match (skin.is_some(), form.space) {
                (true, Some(space)) => self.tree.world(space),
                (true, None) => Affine3A::IDENTITY,
                (false, _) => place,
            };
            if !self.can_be_seen(form.space.unwrap_or(node), &transform) {
                continue;
            }
            if !form.boxes().all(|bounds| is_usable(bounds, &transform)) {
                self.leave_out_huge(node);
                continue;
            }
            self.add_deformed(
                (geometry, &material, name.clone()),
                node,
                (skin, form),
                (transform, *local),
            )?;
        }
        Ok(())
    }

    fn add_deformed(
        &mut self,
        (mut geometry, material, name): (Geometry, &MaterialUse, String),
        node: NodeId,
        (skin, form): (Option<Used>, Form),
        (transform, local): (Affine3A, Affine3A),
    ) -> Result<(), ImportError> {
        let used = skin.and_then(|used| self.skins.list.get(used.skin));
        let seen_at_rest = form.seen_at_rest(&geometry, used, self.tree, &transform);
        let mesh = self.add_mesh(&geometry, material, name);
        let deformer = DeformerId(self.surfaces.deformers.len() as u32);
        self.surfaces.deformers.push(Deformer {
            mesh,
            skin: geometry.skin.take(),
            targets: std::mem::take(&mut geometry.targets),
        });
        let placed = self.add_object(Object { mesh, transform, tint: NO_TINT }, material)?;
        self.placements.push(Placement {
            node,
            placed,
            local,
            deformer: Some((deformer, skin.map(|skin| skin.skin))),
            rest_bounds: form.rest_bounds,
            seen_at_rest,
            clip_bounds: form.clip_bounds,
            blend_bounds: form.blend_bounds,
        });
        Ok(())
    }

    /// Where the mesh is and how far it reaches; `None` if that is beyond all numbers.
    fn form(
        &mut self,
        primitive: &Primitive<'_>,
        geometry: &Geometry,
        node: NodeId,
        skin: Option<Used>,
    ) -> Result<Option<Form>, ImportError> {
        let rig = &self.tree.rig;
        let skin = skin.and_then(|used| self.skins.list.get(used.skin)).zip(geometry.skin.as_ref());
        let mut bound = None;
        if let Some((skin, weights)) = skin {
            self.forms.steps += rig.nodes().len() as u64;
            if self.forms.steps > MOST_STEPS {
                let reason = "there are too many skinned meshes for so many nodes".to_owned();
                return Err(self.source.error(Cause::TooLarge, primitive.place(), reason));
            }
            let Ok(skeleton) = Skeleton::new(rig, skin, &used_joints(weights)) else {
                return Ok(None);
            };
            bound = Some((skeleton, weights));
        }
        let positions: Vec<[f32; 3]> = geometry.positions.iter().map(|at| at.to_array()).collect();
        let targets: Vec<&[[f32; 3]]> =
            geometry.targets.iter().map(|target| target.positions.as_slice()).collect();
        let mesh = DeformedMesh {
            positions: &positions,
            targets: &targets,
            node,
            binding: bound.as_ref().map(|(skeleton, weights)| Binding {
                skeleton,
                joints: &weights.joints,
                weights: &weights.weights,
                sets: weights.sets,
            }),
        };
        let skeleton = bound.as_ref().map(|(skeleton, _)| skeleton);
        let forming: Vec<bool> =
            self.clips.iter().map(|clip| forms(clip, node, skeleton)).collect();
        let boxes = boxes(rig, self.clips, mesh, &forming, &mut self.forms.boxes);
        Ok(boxes.ok().map(|(rest_bounds, clip_bounds, blend_bounds)| {
            let space = skeleton.map_or(Some(node), Skeleton::space);
            Form { space, rest_bounds, clip_bounds, blend_bounds }
        }))
    }
}

/// Whether a clip changes the form of a mesh, rather than only its place.
fn forms(clip: &Clip, node: NodeId, skeleton: Option<&Skeleton>) -> bool {
    let weighs = |channel: &animation::Channel| !channel.is_transform() && channel.node == node;
    skeleton.is_some_and(|skeleton| skeleton.is_moved_by(clip)) || clip.channels.iter().any(weighs)
}

/// The boxes at rest, of each clip, and of all together. `found` counts those that took work.
fn boxes(
    rig: &Rig,
    clips: &[Clip],
    mesh: DeformedMesh<'_>,
    forming: &[bool],
    found: &mut usize,
) -> Result<(Aabb, Vec<Aabb>, Aabb), ReachError> {
    let reach = Reach::new(rig, mesh)?;
    let rest_bounds = reach.rest_bounds()?;
    let rest = Clip { name: String::new(), channels: Vec::new() };
    let mut all: Vec<&Clip> =
        clips.iter().zip(forming).filter(|(_, forms)| **forms).map(|(clip, _)| clip).collect();
    if all.is_empty() {
        return Ok((rest_bounds, vec![rest_bounds; clips.len()], rest_bounds));
    }
    *found += all.len();
    all.push(&rest);
    let blend_bounds = reach.blend_bounds(&all)?;
    let of_clip = |(clip, forms): (&Clip, &bool)| match (*forms, *found <= MOST_BOXES) {
        (false, _) => Ok(rest_bounds),
        (true, true) => reach.clip_bounds(clip),
        (true, false) => Ok(blend_bounds),
    };
    let clip_bounds = clips.iter().zip(forming).map(of_clip).collect::<Result<_, _>>()?;
    Ok((rest_bounds, clip_bounds, blend_bounds))
}

/// Whether a box somewhere in the world is one that an object can have.
fn is_usable(bounds: &Aabb, transform: &Affine3A) -> bool {
    let corners = bounds.corners().map(|corner| transform.transform_point3(corner));
    corners.iter().all(|corner| corner.is_finite()) && in_world(bounds, transform).is_usable()
}

/// A box around a box somewhere in the world.
fn in_world(bounds: &Aabb, transform: &Affine3A) -> Aabb {
    let corners = bounds.corners().map(|corner| transform.transform_point3(corner));
    corners.iter().fold(Aabb::EMPTY, |all, corner| all.union(&Aabb::new(*corner, *corner)))
}
