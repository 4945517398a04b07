//! The parts on nodes: their shown state and their next state. A skeleton that several parts share
//! is posed once per update.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use animation::{Clip, Pose, Rig, RigNodeId, Skeleton, Skin};
use cull::{Aabb, Containment, CullView, PlaneMask};
use glam::{Affine3A, Vec3};
use scene::{
    LightMove, ObjectChange, PoseBounds, PoseUpdate, PunctualLight, SceneUpdate, SkinnedMesh,
    SkinnedMeshId, TransparentMove, bounds_of_transformed,
};

use crate::convert::used_joints;
use crate::gltf_scene::{NodeAttachment, PlacedNode};

/// Everything that moves or is posed.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts {
    parts: Vec<Part>,
    skeletons: Vec<Hung>,
    /// The matrices of the current skeleton, kept so that nothing is allocated.
    matrices: Vec<Affine3A>,
}

/// A skeleton that parts share.
#[derive(Clone, Debug)]
struct Hung {
    skeleton: Skeleton,
    /// The last matrices.
    matrices: Vec<Affine3A>,
    /// The number of times that the matrices changed.
    version: u64,
    /// The range of the matrices in this update, once they were added.
    now: Option<Range<usize>>,
    is_known_now: bool,
}

/// An object or light on a node, and its shown state.
#[derive(Clone, Debug)]
struct Part {
    placement: NodeAttachment,
    /// The skeleton that it follows, if it has a skin.
    skeleton: Option<usize>,
    /// The node in whose space it is; `None` for the world.
    node: Option<RigNodeId>,
    shown: Affine3A,
    /// The last shown version of its skeleton and weights; `None` before the first pose.
    shown_version: Option<u64>,
    shown_weights: Vec<f32>,
    /// True if its pose is outdated because no view could show it.
    is_behind: bool,
}

/// The nodes that clips animate directly, not through an ancestor.
#[derive(Debug, Default)]
pub(super) struct Touched {
    /// The nodes whose transform relative to their parent changes.
    moved: HashSet<RigNodeId>,
    /// The nodes whose weights of morph targets change.
    weighed: HashSet<RigNodeId>,
}

impl Touched {
    /// Collects the nodes that these clips animate.
    pub(super) fn by<'a>(clips: impl Iterator<Item = &'a Clip>) -> Self {
        let mut touched = Self::default();
        for channel in clips.flat_map(|clip| &clip.channels) {
            let nodes =
                if channel.is_transform() { &mut touched.moved } else { &mut touched.weighed };
            nodes.insert(channel.node);
        }
        touched
    }
}

/// The indices of parts that must be visited.
#[derive(Clone, Debug, Default)]
pub(super) struct Movers {
    /// The parts that playing clips move or pose.
    pub(super) moved: Vec<usize>,
    /// Other parts whose pose is outdated.
    pub(super) behind: Vec<usize>,
}

impl Parts {
    /// Finds the parts that share skeletons. The time is proportional to the number of vertices.
    pub(super) fn new(
        rig: &Rig,
        skins: &[Skin],
        skinned_meshes: &[SkinnedMesh],
        placements: Vec<NodeAttachment>,
        world: &[Affine3A],
    ) -> Self {
        let mut known: HashMap<(usize, Vec<bool>), Option<usize>> = HashMap::new();
        let mut parts = Self::default();
        for placement in placements {
            let skeleton = placement.skinned_mesh.and_then(|(skinned_mesh, skin)| {
                let weights = skinned_meshes.get(skinned_mesh.0 as usize)?.skin.as_ref()?;
                let key = (skin?, used_joints(weights));
                if let Some(known) = known.get(&key) {
                    return *known;
                }
                let skeleton = Skeleton::new(rig, skins.get(key.0)?, &key.1).ok();
                let place = skeleton.map(|skeleton| parts.hang(skeleton));
                known.insert(key, place);
                place
            });
            let hung = skeleton.and_then(|skeleton| parts.skeletons.get(skeleton));
            let node = hung.map_or(Some(placement.node), |hung| hung.skeleton.space());
            let mut part = Part {
                placement,
                skeleton,
                node,
                shown: Affine3A::IDENTITY,
                shown_version: None,
                shown_weights: Vec::new(),
                is_behind: false,
            };
            part.shown = part.place(world);
            parts.parts.push(part);
        }
        parts
    }

    /// Returns the last shown transform, joint matrices and weights of a part.
    #[cfg(test)]
    pub(super) fn shown(&self, part: usize) -> (Affine3A, Vec<Affine3A>, Vec<f32>) {
        let part = &self.parts[part];
        let joints = part.skeleton.map(|skeleton| self.skeletons[skeleton].matrices.clone());
        (part.shown, joints.unwrap_or_default(), part.shown_weights.clone())
    }

    /// Returns the number of skeletons.
    #[cfg(test)]
    pub(super) fn skeletons(&self) -> usize {
        self.skeletons.len()
    }

    fn hang(&mut self, skeleton: Skeleton) -> usize {
        self.skeletons.push(Hung {
            skeleton,
            matrices: Vec::new(),
            version: 0,
            now: None,
            is_known_now: false,
        });
        self.skeletons.len() - 1
    }

    /// Returns the number of parts.
    pub(super) fn len(&self) -> usize {
        self.parts.len()
    }

    /// Returns the box in the world of a part as last shown. `mesh` is the box of an unskinned
    /// mesh; `form` bounds the poses of a skinned one.
    pub(super) fn seen_in(
        &self,
        part: usize,
        mesh: Option<Aabb>,
        form: Option<&PoseBounds>,
    ) -> Option<Aabb> {
        let part = self.parts.get(part)?;
        let hung = part.skeleton.and_then(|skeleton| self.skeletons.get(skeleton));
        let own = match form {
            Some(form) => {
                let joints = hung.map_or(&[][..], |hung| &hung.matrices);
                form.bounds(joints, &part.shown_weights)?
            }
            None => mesh?,
        };
        let bounds = bounds_of_transformed(&own, &part.shown);
        bounds.is_usable().then_some(bounds)
    }

    /// Resets the shown state; `world` holds the transforms of nodes at rest.
    pub(super) fn reset(&mut self, world: &[Affine3A]) {
        for part in &mut self.parts {
            part.shown = part.place(world);
            part.shown_version = None;
            part.shown_weights.clear();
            part.is_behind = false;
        }
    }

    /// Returns the object or light of a part, and its skinned mesh.
    pub(super) fn placed(&self, part: usize) -> Option<(PlacedNode, Option<SkinnedMeshId>)> {
        let placement = &self.parts.get(part)?.placement;
        Some((placement.placed, placement.skinned_mesh.map(|(skinned_mesh, _)| skinned_mesh)))
    }

    /// Returns the parts that change while clips touch and move these nodes. The time is
    /// proportional to the number of parts and bones.
    pub(super) fn movers(&self, touched: &Touched, is_moving: &[bool], is_new: bool) -> Movers {
        let is_bent = |hung: &Hung| hung.skeleton.bones().any(|bone| touched.moved.contains(&bone));
        let bent: Vec<bool> = self.skeletons.iter().map(is_bent).collect();
        let mut movers = Movers::default();
        for (place, part) in self.parts.iter().enumerate() {
            let node = part.node.and_then(|node| is_moving.get(node.0 as usize));
            let is_skinned = part.placement.skinned_mesh.is_some();
            let is_formed = part.skeleton.is_some_and(|skeleton| bent.get(skeleton) == Some(&true))
                || touched.weighed.contains(&part.placement.node);
            if node == Some(&true) || is_skinned && (is_formed || is_new) {
                movers.moved.push(place);
            } else if part.is_behind {
                movers.behind.push(place);
            }
        }
        movers
    }

    /// Begins an update.
    pub(super) fn begin(&mut self) {
        for hung in &mut self.skeletons {
            (hung.now, hung.is_known_now) = (None, false);
        }
    }

    /// Adds the pose of a part to the changes if it is new, and if one of the `views` may show the
    /// part or it never had a pose. Its transform must be up to date.
    pub(super) fn change(
        &mut self,
        part: usize,
        rig: &Rig,
        pose: &Pose,
        views: Option<&[CullView]>,
        changes: &mut SceneUpdate,
    ) {
        let Some(part) = self.parts.get_mut(part) else { return };
        let Some((skinned_mesh, _)) = part.placement.skinned_mesh else { return };
        part.is_behind =
            part.shown_version.is_some() && views.is_some_and(|views| !part.may_be_in(views));
        if part.is_behind {
            return;
        }
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
        changes.poses.push(PoseUpdate { skinned_mesh, joints, weights });
    }

    /// Adds the transform of a part to the changes if it has moved.
    pub(super) fn change_place(
        &mut self,
        part: usize,
        world: &[Affine3A],
        lights: &mut [PunctualLight],
        changes: &mut SceneUpdate,
    ) {
        if let Some(part) = self.parts.get_mut(part) {
            part.change_place(world, lights, changes);
        }
    }
}

impl Hung {
    /// Poses the joints.
    fn pose(&mut self, rig: &Rig, pose: &Pose, matrices: &mut Vec<Affine3A>) {
        self.is_known_now = true;
        self.skeleton.joint_matrices(rig, pose, matrices);
        if self.version == 0 || self.matrices != *matrices {
            self.matrices.clone_from(matrices);
            self.version += 1;
        }
    }

    /// Returns the range of its matrices among the changes, to which they are added on first use.
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
    /// Returns the transform of the part.
    fn place(&self, world: &[Affine3A]) -> Affine3A {
        let node = self.node.and_then(|node| world.get(node.0 as usize));
        node.map_or(self.placement.local, |node| *node * self.placement.local)
    }

    /// Returns true if one of the views may show the part in any pose of the clips.
    fn may_be_in(&self, views: &[CullView]) -> bool {
        let bounds = bounds_of_transformed(&self.placement.reach, &self.shown);
        let is_in = |view: &CullView| {
            view.frustum.classify(&bounds, PlaneMask::ALL).0 != Containment::Outside
        };
        !bounds.is_usable() || views.iter().any(is_in)
    }

    fn change_place(
        &mut self,
        world: &[Affine3A],
        lights: &mut [PunctualLight],
        changes: &mut SceneUpdate,
    ) {
        let transform = self.place(world);
        if transform == self.shown {
            return;
        }
        self.shown = transform;
        match self.placement.placed {
            PlacedNode::Object(object) => {
                changes.objects.push(ObjectChange::Move { object, transform });
            }
            PlacedNode::Transparent(transparent) => {
                changes.transparent.push(TransparentMove { transparent, transform });
            }
            PlacedNode::Light(light) => {
                let Some(to) = lights.get_mut(light.0 as usize) else { return };
                let along = Vec3::from(-transform.matrix3.z_axis);
                to.position = transform.translation.into();
                to.direction = along.try_normalize().unwrap_or(to.direction);
                changes.lights.push(LightMove { light, to: *to });
            }
        }
    }
}
