//! What hangs on nodes: how it was shown last, and how it is to be shown. What several hang on is looked at
//! once a moment.

use std::collections::HashMap;
use std::ops::Range;

use animation::{Clip, ClipIndex, NodeId, Pose, Rig, Skeleton, Skin};
use cull::Aabb;
use glam::{Affine3A, Vec3};
use scene::{
    BlendedMove, Deformation, Deformer, LightMove, ObjectChange, PunctualLight, SceneUpdate,
    bounds_of_transformed,
};

use crate::convert::used_joints;
use crate::gltf_scene::{Placed, Placement};

/// All that moves or changes its form.
#[derive(Debug, Default)]
pub(super) struct Parts {
    parts: Vec<Part>,
    skeletons: Vec<Hung>,
    /// For each node whose weights clips change, these clips.
    weighing: HashMap<NodeId, Vec<usize>>,
    /// Matrices of a skeleton in the making, kept to allocate nothing.
    matrices: Vec<Affine3A>,
}

/// A skeleton, whatever hangs on it.
#[derive(Debug)]
struct Hung {
    skeleton: Skeleton,
    /// The clips that change its form, ascending.
    forming: Vec<usize>,
    /// As they were last.
    matrices: Vec<Affine3A>,
    /// How often they changed.
    version: u64,
    /// Where they are among those of this moment, once they were looked at.
    now: Option<Range<usize>>,
    is_known_now: bool,
}

/// Something that hangs on a node, and how it was shown last.
#[derive(Debug)]
struct Part {
    placement: Placement,
    /// What it hangs on, if it has a skin.
    skeleton: Option<usize>,
    /// The node in whose space it is; `None` in the world's.
    node: Option<NodeId>,
    shown: Affine3A,
    /// Empty before it was shown.
    shown_bounds: Aabb,
    /// The boxes that hold while clips fade and when they have; `None` where it has its form for ever.
    bounds: Option<[Aabb; 2]>,
    /// The version of its skeleton and the weights that were shown last; `None` before.
    shown_version: Option<u64>,
    shown_weights: Vec<f32>,
}

/// Which of the clips of some set form something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Forming {
    None,
    One(usize),
    Several,
}

impl Forming {
    fn of(clips: &[usize], plays: &[bool]) -> Self {
        let playing = clips.iter().filter(|clip| plays.get(**clip) == Some(&true));
        playing.fold(Self::None, |found, clip| found.and(Self::One(*clip)))
    }

    fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::None, one) | (one, Self::None) => one,
            (Self::One(one), Self::One(other)) if one == other => self,
            _ => Self::Several,
        }
    }
}

impl Parts {
    /// Finds what hangs together. Takes as long as the clips have channels, and the parts vertices.
    pub(super) fn new(
        rig: &Rig,
        clips: &[Clip],
        skins: &[Skin],
        deformers: &[Deformer],
        placements: Vec<Placement>,
        world: &[Affine3A],
    ) -> Self {
        let index = ClipIndex::new(rig, clips);
        let mut known: HashMap<(usize, Vec<bool>), Option<usize>> = HashMap::new();
        let mut parts = Self::default();
        for placement in placements {
            let skeleton = placement.deformer.and_then(|(deformer, skin)| {
                let weights = deformers.get(deformer.0 as usize)?.skin.as_ref()?;
                let key = (skin?, used_joints(weights));
                if let Some(known) = known.get(&key) {
                    return *known;
                }
                let skeleton = Skeleton::new(rig, skins.get(key.0)?, &key.1).ok();
                let place = skeleton.map(|skeleton| parts.hang(skeleton, &index));
                known.insert(key, place);
                place
            });
            if placement.deformer.is_some() && !rig_weights(rig, placement.node).is_empty() {
                let weighing = || index.weighing(placement.node);
                parts.weighing.entry(placement.node).or_insert_with(weighing);
            }
            let hung = skeleton.and_then(|skeleton| parts.skeletons.get(skeleton));
            let node = hung.map_or(Some(placement.node), |hung| hung.skeleton.space());
            let mut part = Part {
                placement,
                skeleton,
                node,
                shown: Affine3A::IDENTITY,
                shown_bounds: Aabb::EMPTY,
                bounds: None,
                shown_version: None,
                shown_weights: Vec::new(),
            };
            part.shown = part.place(world);
            parts.parts.push(part);
        }
        parts
    }

    /// Where a part was shown last, in which box, on which joints, and with which weights.
    #[cfg(test)]
    pub(super) fn shown(&self, part: usize) -> (Affine3A, Aabb, Vec<Affine3A>, Vec<f32>) {
        let part = &self.parts[part];
        let joints = part.skeleton.map(|skeleton| self.skeletons[skeleton].matrices.clone());
        let weights = part.shown_weights.clone();
        (part.shown, part.shown_bounds, joints.unwrap_or_default(), weights)
    }

    /// How many skeletons there are.
    #[cfg(test)]
    pub(super) fn skeletons(&self) -> usize {
        self.skeletons.len()
    }

    fn hang(&mut self, skeleton: Skeleton, index: &ClipIndex) -> usize {
        let forming = index.moving(skeleton.bones());
        self.skeletons.push(Hung {
            skeleton,
            forming,
            matrices: Vec::new(),
            version: 0,
            now: None,
            is_known_now: false,
        });
        self.skeletons.len() - 1
    }

    /// How many parts there are.
    pub(super) fn len(&self) -> usize {
        self.parts.len()
    }

    /// Where a part was shown last, in the world; at rest if it was not. `mesh` are the bounds of its mesh,
    /// which hold for what does not change its form.
    pub(super) fn seen_in(&self, part: usize, mesh: Option<Aabb>) -> Option<Aabb> {
        let part = self.parts.get(part)?;
        let own = match part.bounds {
            Some(_) if part.shown_bounds == Aabb::EMPTY => {
                return Some(part.placement.seen_at_rest);
            }
            Some(_) => part.shown_bounds,
            None => mesh?,
        };
        let bounds = bounds_of_transformed(&own, &part.shown);
        bounds.is_usable().then_some(bounds)
    }

    /// Forgets what was shown; `world` are the nodes at rest.
    pub(super) fn begin_anew(&mut self, world: &[Affine3A]) {
        for part in &mut self.parts {
            part.shown = part.place(world);
            part.shown_bounds = Aabb::EMPTY;
            part.shown_version = None;
            part.shown_weights.clear();
        }
    }

    /// What a part is.
    pub(super) fn placed(&self, part: usize) -> Option<Placed> {
        self.parts.get(part).map(|part| part.placement.placed)
    }

    /// The parts that change while clips play: those of the first list while they fade, those of the second
    /// when they have. Also finds the boxes that hold then. Takes as long as there are parts.
    pub(super) fn movers(
        &mut self,
        playing: &[Vec<bool>; 2],
        is_moving: &[bool],
        is_new: bool,
    ) -> Vec<usize> {
        let of = |clips: &Vec<usize>| playing.each_ref().map(|plays| Forming::of(clips, plays));
        let skeletons: Vec<[Forming; 2]> =
            self.skeletons.iter().map(|hung| of(&hung.forming)).collect();
        let weighing: HashMap<NodeId, [Forming; 2]> =
            self.weighing.iter().map(|(node, clips)| (*node, of(clips))).collect();
        let mut movers = Vec::new();
        for (place, part) in self.parts.iter_mut().enumerate() {
            let none = [Forming::None; 2];
            let skeleton = part.skeleton.and_then(|skeleton| skeletons.get(skeleton).copied());
            let [by_joints, by_weights] = [skeleton, weighing.get(&part.placement.node).copied()]
                .map(|it| it.unwrap_or(none));
            let is_deformed = part.placement.deformer.is_some();
            let forming = [0, 1].map(|at| by_joints[at].and(by_weights[at]));
            part.bounds = is_deformed.then(|| part.bounds_while(forming));
            let node = part.node.and_then(|node| is_moving.get(node.0 as usize));
            let is_formed = is_deformed && forming[0] != Forming::None;
            if node == Some(&true) || is_formed || (is_new && is_deformed) {
                movers.push(place);
            }
        }
        movers
    }

    /// Begins a moment.
    pub(super) fn begin(&mut self) {
        for hung in &mut self.skeletons {
            (hung.now, hung.is_known_now) = (None, false);
        }
    }

    /// Notes the form of a part if it is another.
    pub(super) fn change(
        &mut self,
        part: usize,
        (rig, pose): (&Rig, &Pose),
        changes: &mut SceneUpdate,
    ) {
        let Some(part) = self.parts.get_mut(part) else { return };
        let Some((deformer, _)) = part.placement.deformer else { return };
        let mut hung = part.skeleton.and_then(|skeleton| self.skeletons.get_mut(skeleton));
        if let Some(hung) = hung.as_mut().filter(|hung| !hung.is_known_now) {
            hung.pose(rig, pose, &mut self.matrices);
        }
        let version = hung.as_ref().map_or(0, |hung| hung.version);
        let weights = pose.weights(part.placement.node);
        if part.shown_version == Some(version) && part.shown_weights == weights {
            return;
        }
        part.shown_version = Some(version);
        part.shown_weights.clear();
        part.shown_weights.extend_from_slice(weights);
        let first = changes.weights.len();
        changes.weights.extend_from_slice(weights);
        let joints = hung.map_or(0..0, |hung| hung.bring(changes));
        let weights = first..changes.weights.len();
        changes.deformations.push(Deformation { deformer, joints, weights });
    }

    /// Notes where a part is if that is elsewhere.
    pub(super) fn change_place(
        &mut self,
        part: usize,
        world: &[Affine3A],
        is_fading: bool,
        lights: &mut [PunctualLight],
        changes: &mut SceneUpdate,
    ) {
        if let Some(part) = self.parts.get_mut(part) {
            part.change_place(world, is_fading, lights, changes);
        }
    }
}

fn rig_weights(rig: &Rig, node: NodeId) -> &[f32] {
    rig.nodes().get(node.0 as usize).map(|node| node.weights.as_slice()).unwrap_or_default()
}

impl Hung {
    /// Looks at where the joints are now.
    fn pose(&mut self, rig: &Rig, pose: &Pose, matrices: &mut Vec<Affine3A>) {
        self.is_known_now = true;
        self.skeleton.joint_matrices(rig, pose, matrices);
        if self.version == 0 || self.matrices != *matrices {
            self.matrices.clone_from(matrices);
            self.version += 1;
        }
    }

    /// Where its matrices are among the changes.
    fn bring(&mut self, changes: &mut SceneUpdate) -> Range<usize> {
        let matrices = &self.matrices;
        let now = self.now.get_or_insert_with(|| {
            let first = changes.joints.len();
            changes.joints.extend_from_slice(matrices);
            first..changes.joints.len()
        });
        now.clone()
    }
}

impl Part {
    /// Where it is.
    fn place(&self, world: &[Affine3A]) -> Affine3A {
        let node = self.node.and_then(|node| world.get(node.0 as usize));
        node.map_or(self.placement.local, |node| *node * self.placement.local)
    }

    /// The boxes that it stays in while clips that form it fade, and when they have. What fades is mixed
    /// with others or with the rest, so a single clip's box holds only where there is nothing to mix it with.
    fn bounds_while(&self, forming: [Forming; 2]) -> [Aabb; 2] {
        let Placement { rest_bounds, blend_bounds, .. } = self.placement;
        let [fading, settled] = forming;
        let fading = if fading == Forming::None { rest_bounds } else { blend_bounds };
        let settled = match settled {
            Forming::None => rest_bounds,
            Forming::One(clip) => self.placement.bounds_of(clip),
            Forming::Several => blend_bounds,
        };
        [fading, settled]
    }

    fn change_place(
        &mut self,
        world: &[Affine3A],
        is_fading: bool,
        lights: &mut [PunctualLight],
        changes: &mut SceneUpdate,
    ) {
        let bounds = self.bounds.map(|[fading, settled]| if is_fading { fading } else { settled });
        let transform = self.place(world);
        let is_same_box = bounds.is_none_or(|bounds| bounds == self.shown_bounds);
        if transform == self.shown && is_same_box {
            return;
        }
        self.shown = transform;
        self.shown_bounds = bounds.unwrap_or(self.shown_bounds);
        match self.placement.placed {
            Placed::Object(object) => {
                changes.objects.push(match bounds {
                    Some(bounds) => ObjectChange::Reshape { object, transform, bounds },
                    None => ObjectChange::Move { object, transform },
                });
            }
            Placed::Blended(blended) => {
                changes.blended.push(BlendedMove { blended, transform, bounds });
            }
            Placed::Light(light) => {
                let Some(to) = lights.get_mut(light.0 as usize) else { return };
                let along = Vec3::from(-transform.matrix3.z_axis);
                to.position = transform.translation.into();
                to.direction = along.try_normalize().unwrap_or(to.direction);
                changes.lights.push(LightMove { light, to: *to });
            }
        }
    }
}
