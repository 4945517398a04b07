//! How far meshes reach that change their form. The work goes with what concerns each of them: what moves a
//! node is looked up, what several have in common is found once, and what is left is counted.
//!
//! Exact boxes take time. Where a file has so many that they would take longer than [`MOST_STEPS`], the others
//! get one that is larger, holds whatever plays, and costs next to nothing.

use std::collections::HashMap;
use std::sync::Arc;

use animation::{
    Binding, Clip, ClipIndex, DeformedMesh, Excerpt, Extents, NodeId, Reach, ReachError, Rig,
    Skeleton, Skin, weight_ranges,
};
use cull::Aabb;
use glam::{Affine3A, Vec3};
use scene::SkinWeights;

use super::geometry::Geometry;
use super::nodes::Tree;
use super::primitives::Primitive;
use super::skins::used_joints;
use crate::{Cause, ImportError, Limits};

/// Steps of about 100 ns that exact boxes may take in all: some ten seconds.
const MOST_STEPS: u64 = 100_000_000;

/// Keys that are looked through for one exact box.
const MOST_KEYS: usize = 1 << 20;
/// Clips times bones of one exact box: all are laid out at once.
const MOST_TRACKS: usize = 1 << 18;

/// What keeping a box costs, in steps: this is what bounds the memory of all of them, to 40 MB.
const KEPT_STEPS: u64 = 100;

/// Where a mesh is that changes its form, and how far it reaches.
#[derive(Clone, Debug)]
pub(super) struct Form {
    /// The node in whose space it is; `None` for the world's.
    pub(super) space: Option<NodeId>,
    pub(super) rest_bounds: Aabb,
    pub(super) clip_bounds: Arc<[(usize, Aabb)]>,
    pub(super) blend_bounds: Aabb,
}

impl Form {
    /// The box in the world of what is seen at rest, as close as it can be: `rest_bounds` lies askew there.
    pub(super) fn seen_at_rest(
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

    /// Whether its boxes are such that an object can have them, where `transform` brings them.
    pub(super) fn is_usable(&self, transform: &Affine3A) -> bool {
        let boxes = self.clip_bounds.iter().map(|(_, bounds)| bounds);
        boxes.chain([&self.rest_bounds, &self.blend_bounds]).all(|it| is_usable(it, transform))
    }
}

/// A mesh that changes its form.
pub(super) struct Formed<'a> {
    pub(super) primitive: &'a Primitive<'a>,
    pub(super) geometry: &'a Geometry,
    pub(super) node: NodeId,
    /// Its skin, with its number.
    pub(super) skin: Option<(usize, &'a Skin)>,
}

/// What was found, and what is left of the work that may be done.
#[derive(Debug)]
pub(super) struct Forms {
    index: ClipIndex,
    extents: Extents,
    skeletons: Vec<Skeleton>,
    /// By skin, and which of its joints are used; `None` if that is no skeleton.
    known: HashMap<(usize, Vec<bool>), Option<usize>>,
    /// Of what hangs on skins and has no morph targets: by mesh, primitive and skin.
    made: HashMap<[usize; 3], Option<Form>>,
    /// The weights of the morph targets of one node.
    weights: Option<(NodeId, Vec<[f32; 2]>)>,
    bones: u64,
    most_bones: u64,
    spent_steps: u64,
}

impl Forms {
    pub(super) fn new(rig: &Rig, clips: &[Clip], limits: &Limits) -> Self {
        Self {
            index: ClipIndex::new(rig, clips),
            extents: Extents::new(rig, clips),
            skeletons: Vec::new(),
            known: HashMap::new(),
            made: HashMap::new(),
            weights: None,
            bones: 0,
            most_bones: limits.bones,
            spent_steps: 0,
        }
    }

    /// How far nodes go in all clips.
    pub(super) fn into_extents(self) -> Extents {
        self.extents
    }

    /// Of each node whether it or one above it mirrors at one time and not at another.
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

    /// Where a mesh is and how far it reaches; `None` if that is beyond all numbers.
    ///
    /// # Errors
    /// More bones than the limits allow.
    pub(super) fn form(
        &mut self,
        rig: &Rig,
        clips: &[Clip],
        formed: &Formed<'_>,
    ) -> Result<Option<Form>, ImportError> {
        let Formed { primitive, geometry, .. } = formed;
        // What the same primitive is on the same skin, it is wherever it hangs.
        let key = formed.skin.filter(|_| geometry.targets.is_empty());
        let key = key.map(|(skin, _)| [primitive.mesh, primitive.number, skin]);
        if let Some(made) = key.and_then(|key| self.made.get(&key)) {
            return Ok(made.clone());
        }
        let skeleton = match formed.skin.zip(geometry.skin.as_ref()) {
            Some((skin, weights)) => match self.skeleton(rig, primitive, skin, weights)? {
                Some(skeleton) => Some(skeleton),
                None => return Ok(None),
            },
            None => None,
        };
        let form = self.boxes(rig, clips, formed, skeleton).ok();
        if let Some(key) = key {
            self.made.insert(key, form.clone());
        }
        Ok(form)
    }

    /// The skeleton of a skin and what hangs on it, which others may share; `None` if it is none.
    fn skeleton(
        &mut self,
        rig: &Rig,
        primitive: &Primitive<'_>,
        (number, skin): (usize, &Skin),
        weights: &SkinWeights,
    ) -> Result<Option<usize>, ImportError> {
        let key = (number, used_joints(weights));
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let made = Skeleton::new(rig, skin, &key.1).ok();
        let place = made.map(|skeleton| {
            let costs = skeleton.bones().map(|bone| 1 + self.index.channels(bone) as u64);
            self.bones = self.bones.saturating_add(costs.sum());
            self.skeletons.push(skeleton);
            self.skeletons.len() - 1
        });
        if self.bones > self.most_bones {
            let (bones, most) = (self.bones, self.most_bones);
            let reason = format!(
                "bones up to it, and the animation channels that move them: {bones}, \
                 more than the limit of {most}"
            );
            return Err(primitive.source.error(Cause::TooLarge, primitive.place(), reason));
        }
        self.known.insert(key, place);
        Ok(place)
    }

    fn boxes(
        &mut self,
        rig: &Rig,
        clips: &[Clip],
        formed: &Formed<'_>,
        skeleton: Option<usize>,
    ) -> Result<Form, ReachError> {
        let Formed { geometry, node, .. } = *formed;
        let positions: Vec<[f32; 3]> = geometry.positions.iter().map(|at| at.to_array()).collect();
        let targets: Vec<&[[f32; 3]]> =
            geometry.targets.iter().map(|target| target.positions.as_slice()).collect();
        let skeleton = skeleton.and_then(|skeleton| self.skeletons.get(skeleton));
        let binding = skeleton.zip(geometry.skin.as_ref()).map(|(skeleton, weights)| Binding {
            skeleton,
            joints: &weights.joints,
            weights: &weights.weights,
            sets: weights.sets,
        });
        let mesh = DeformedMesh { positions: &positions, targets: &targets, node, binding };
        let space = skeleton.map_or(Some(node), Skeleton::space);
        if self.spent_steps < MOST_STEPS {
            let bones = skeleton.into_iter().flat_map(Skeleton::bones);
            let excerpts = self.index.excerpts(clips, bones, node);
            let channels = excerpts.iter().map(|(_, excerpt)| excerpt.channels.len() as u64);
            self.spent_steps += channels.sum::<u64>() + positions.len() as u64;
            let keys: usize = excerpts.iter().map(|(_, excerpt)| excerpt.keys()).sum();
            let bones = skeleton.map_or(1, |skeleton| skeleton.bones().count());
            let tracks = bones.saturating_mul(excerpts.len());
            if keys <= MOST_KEYS && tracks <= MOST_TRACKS {
                return exact(rig, mesh, excerpts, &mut self.spent_steps)
                    .map(|form| Form { space, ..form });
            }
        }
        let no_weights = [];
        let weights: &[[f32; 2]] = if targets.is_empty() {
            &no_weights
        } else {
            if self.weights.as_ref().is_none_or(|(of, _)| *of != node) {
                let excerpts = self.index.excerpts(clips, [].into_iter(), node);
                let excerpts: Vec<&Excerpt> = excerpts.iter().map(|(_, it)| it).collect();
                self.weights = Some((node, weight_ranges(rig, node, &excerpts)));
            }
            self.weights.as_ref().map_or(&no_weights, |(_, weights)| weights)
        };
        let bounds = self.extents.bounds(&mesh, weights)?;
        let clip_bounds = [].into();
        Ok(Form { space, rest_bounds: bounds, clip_bounds, blend_bounds: bounds })
    }
}

/// The boxes at rest, of each clip, and of all together.
fn exact(
    rig: &Rig,
    mesh: DeformedMesh<'_>,
    excerpts: Vec<(usize, Excerpt<'_>)>,
    spent_steps: &mut u64,
) -> Result<Form, ReachError> {
    let reach = Reach::new(rig, mesh)?;
    let rest_bounds = reach.rest_bounds()?;
    let (numbers, mut all): (Vec<usize>, Vec<Excerpt>) = excerpts.into_iter().unzip();
    let mut blend_bounds = rest_bounds;
    let mut clip_bounds = Vec::new();
    if !all.is_empty() {
        all.push(Excerpt::default());
        blend_bounds = reach.blend_bounds_of(&all)?;
        for (number, excerpt) in numbers.into_iter().zip(&all) {
            let kept = clip_bounds.len() as u64 * KEPT_STEPS;
            if *spent_steps + reach.spent_steps() + kept > MOST_STEPS {
                break;
            }
            clip_bounds.push((number, reach.excerpt_bounds(excerpt)?));
        }
    }
    *spent_steps += reach.spent_steps() + clip_bounds.len() as u64 * KEPT_STEPS;
    Ok(Form { space: None, rest_bounds, clip_bounds: clip_bounds.into(), blend_bounds })
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
