//! The reach of skinned meshes in any mix of clips. The renderer computes exact boxes for a pose
//! ([`PoseBounds`]). Here a loose and cheap box is enough: it shows which meshes can never be
//! drawn, and which need no pose because they are out of sight.

use std::collections::HashMap;

use animation::{Clip, Extents, Rig, RigNodeId, Skeleton, Skin, WeightRanges};
use cull::Aabb;
use glam::{Affine3A, Vec3};
use scene::{PoseBounds, SkinWeights};

use super::geometry::Geometry;
use super::nodes::Tree;
use super::primitives::Primitive;
use super::skins::used_joints;
use crate::{Cause, ImportError, Limits};

/// The space of a skinned mesh, and its reach.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkinnedExtent {
    /// The node in whose space it is; `None` for the world.
    pub(super) space: Option<RigNodeId>,
    /// A box around the mesh in that space.
    pub(super) reach: Aabb,
}

impl SkinnedExtent {
    /// Returns true if an object moved by `transform` can have this box.
    pub(super) fn is_usable(&self, transform: &Affine3A) -> bool {
        let corners = self.reach.corners().map(|corner| transform.transform_point3(corner));
        let is_finite = corners.iter().all(|corner| corner.is_finite());
        is_finite && in_world(&self.reach, transform).is_usable()
    }

    /// Returns the tightest known box in the world around the mesh at rest.
    pub(super) fn seen_at_rest(
        &self,
        geometry: &Geometry,
        node: RigNodeId,
        skin: Option<&Skin>,
        tree: &Tree,
        transform: &Affine3A,
    ) -> Aabb {
        let weights = tree.node(node).map(|node| node.weights.as_slice()).unwrap_or_default();
        let morphed = |(vertex, position): (usize, &Vec3)| {
            let targets = geometry.targets.iter().zip(weights);
            let added = targets.filter_map(|(target, weight)| {
                Some(Vec3::from(*target.positions.get(vertex)?) * *weight)
            });
            *position + added.sum::<Vec3>()
        };
        let morphed = geometry.positions.iter().enumerate().map(morphed);
        let mut seen = Aabb::EMPTY;
        let mut see = |at: Vec3| seen = seen.union(&Aabb::new(at, at));
        if let (Some(skin), Some(weights)) = (skin, &geometry.skin) {
            let joints = skin.joints.iter().zip(&skin.inverse_bind);
            let matrices: Vec<_> = joints.map(|(joint, bind)| tree.world(*joint) * *bind).collect();
            let sets = (weights.sets as usize).max(1);
            let followed = weights.joints.chunks(sets).zip(weights.weights.chunks(sets));
            for (position, (joints, weights)) in morphed.zip(followed) {
                let named = joints.as_flattened().iter().zip(weights.as_flattened());
                let named = named.filter(|(_, weight)| **weight > 0.0);
                let matrices = named.filter_map(|(joint, weight)| {
                    Some((matrices.get(usize::from(*joint))?, weight))
                });
                see(matrices
                    .map(|(matrix, weight)| matrix.transform_point3(position) * *weight)
                    .sum());
            }
        } else {
            morphed.for_each(|at| see(transform.transform_point3(at)));
        }
        if seen.is_usable() { seen } else { in_world(&self.reach, transform) }
    }
}

/// A skinned mesh.
pub(super) struct SkinnedPrimitive<'a> {
    pub(super) primitive: &'a Primitive<'a>,
    pub(super) geometry: &'a Geometry,
    pub(super) node: RigNodeId,
    /// The skin, with its index.
    pub(super) skin: Option<(usize, &'a Skin)>,
}

/// The extents of a rig under its clips, and the skeletons on it.
#[derive(Debug)]
pub(super) struct SkinnedExtents {
    extents: Extents,
    weights: WeightRanges,
    skeletons: Vec<Skeleton>,
    /// The skeletons by skin and used joints; `None` if they have no skeleton.
    known: HashMap<(usize, Vec<bool>), Option<usize>>,
    bones: u64,
    most_bones: u64,
}

impl SkinnedExtents {
    pub(super) fn new(rig: &Rig, clips: &[Clip], limits: &Limits) -> Self {
        Self {
            extents: Extents::new(rig, clips),
            weights: WeightRanges::new(rig, clips),
            skeletons: Vec::new(),
            known: HashMap::new(),
            bones: 0,
            most_bones: limits.bones,
        }
    }

    /// Returns the extents of nodes in all clips.
    pub(super) fn into_extents(self) -> Extents {
        self.extents
    }

    /// Returns true for each node that mirrors at some times and not at others, by its own
    /// transform or an ancestor's.
    pub(super) fn turning(&self, rig: &Rig) -> Vec<bool> {
        let mut turns = vec![false; rig.nodes().len()];
        if !self.extents.may_any_turn_inside_out() {
            return turns;
        }
        for node in rig.order() {
            let parent = rig.nodes().get(node.0 as usize).and_then(|node| node.parent);
            let above = parent.and_then(|parent| turns.get(parent.0 as usize)).copied();
            if let Some(turns) = turns.get_mut(node.0 as usize) {
                *turns = above == Some(true) || self.extents.may_turn_inside_out(*node);
            }
        }
        turns
    }

    /// Returns the space and the reach of a mesh; `None` if it has no skeleton.
    pub(super) fn form(
        &mut self,
        rig: &Rig,
        skinned: &SkinnedPrimitive<'_>,
    ) -> Result<Option<SkinnedExtent>, ImportError> {
        let SkinnedPrimitive { primitive, geometry, node, skin } = *skinned;
        let weights = geometry.skin.as_ref();
        let bounds =
            PoseBounds::new(geometry.positions.iter().copied(), weights, &geometry.targets);
        let skeleton = match (skin, weights) {
            (Some((index, skin)), Some(weights)) => {
                self.skeleton(rig, primitive, index, skin, weights)?
            }
            _ => None,
        };
        let skeleton = skeleton.and_then(|skeleton| self.skeletons.get(skeleton));
        let ranges = self.weights.of(rig, node);
        let boxes = bounds.parts(&ranges);
        Ok(match (skin, skeleton) {
            (Some(_), Some(skeleton)) => {
                let boxes = boxes.filter_map(|(joint, bounds)| Some((joint?, bounds)));
                let reach = self.extents.reach(skeleton, boxes);
                Some(SkinnedExtent { space: skeleton.space(), reach })
            }
            (Some(_), None) => None,
            (None, _) => {
                let reach = boxes.fold(Aabb::EMPTY, |all, (_, bounds)| all.union(&bounds));
                let reach = reach.enlarged(reach.largest_coordinate() * ROUNDING);
                Some(SkinnedExtent { space: Some(node), reach })
            }
        })
    }

    /// Returns the skeleton of a skin for the joints that its vertices use, which meshes may share;
    /// `None` if there is none.
    fn skeleton(
        &mut self,
        rig: &Rig,
        primitive: &Primitive<'_>,
        number: usize,
        skin: &Skin,
        weights: &SkinWeights,
    ) -> Result<Option<usize>, ImportError> {
        let key = (number, used_joints(weights));
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let made = Skeleton::new(rig, skin, &key.1).ok();
        let place = made.map(|skeleton| {
            self.bones = self.bones.saturating_add(skeleton.bones().count() as u64);
            self.skeletons.push(skeleton);
            self.skeletons.len() - 1
        });
        if self.bones > self.most_bones {
            let bones = self.bones;
            let most = self.most_bones;
            let reason = format!("bones up to it: {bones}, more than the limit of {most}");
            return Err(primitive.source.error(Cause::TooLarge, primitive.place(), reason));
        }
        self.known.insert(key, place);
        Ok(place)
    }
}

/// The error that single precision may add to a sum of displacements, relative to the largest
/// coordinate.
const ROUNDING: f32 = 1e-3;

/// Returns the box in the world around a transformed box.
fn in_world(bounds: &Aabb, transform: &Affine3A) -> Aabb {
    let corners = bounds.corners().map(|corner| transform.transform_point3(corner));
    corners.iter().fold(Aabb::EMPTY, |all, corner| all.union(&Aabb::new(*corner, *corner)))
}
