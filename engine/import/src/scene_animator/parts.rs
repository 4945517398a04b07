//! What hangs on nodes: how it was shown last, and how it is to be shown. What several hang on is
//! looked at once a moment.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use animation::{Clip, Pose, Rig, RigNodeId, Skeleton, Skin};
use cull::{Aabb, Containment, PlaneMask, View};
use glam::{Affine3A, Vec3};
use scene::{
    Deformation, LightMove, ObjectChange, PoseBounds, PunctualLight, SceneUpdate, SkinnedMesh,
    SkinnedMeshId, TransparentMove, bounds_of_transformed,
};

use crate::convert::used_joints;
use crate::gltf_scene::{NodeAttachment, PlacedNode};

/// All that moves or changes its form.
#[derive(Debug, Default)]
pub(super) struct Parts {
    parts: Vec<Part>,
    skeletons: Vec<Hung>,
    /// Matrices of a skeleton in the making, kept to allocate nothing.
    matrices: Vec<Affine3A>,
}

/// A skeleton, whatever hangs on it.
#[derive(Debug)]
struct Hung {
    skeleton: Skeleton,
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
    placement: NodeAttachment,
    /// What it hangs on, if it has a skin.
    skeleton: Option<usize>,
    /// The node in whose space it is; `None` in the world's.
    node: Option<RigNodeId>,
    shown: Affine3A,
    /// The version of its skeleton and the weights that were shown last; `None` before.
    shown_version: Option<u64>,
    shown_weights: Vec<f32>,
    /// Whether its form is not that of the moment, because nobody could see it.
    is_behind: bool,
}

/// What clips do to nodes themselves, rather than to those above them.
#[derive(Debug, Default)]
pub(super) struct Touched {
    /// Those whose place in their parent changes.
    moved: HashSet<RigNodeId>,
    /// Those whose morph targets' weights change.
    weighed: HashSet<RigNodeId>,
}

impl Touched {
    /// Collects what these clips do.
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

/// The places of parts that are to be looked at.
#[derive(Debug, Default)]
pub(super) struct Movers {
    /// Those that playing clips move or change.
    pub(super) moved: Vec<usize>,
    /// Others whose form is still that of another moment.
    pub(super) behind: Vec<usize>,
}

impl Parts {
    /// Finds what hangs together. Takes as long as the parts have vertices.
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

    /// Returns where a part was shown last, on which joints, and with which weights.
    #[cfg(test)]
    pub(super) fn shown(&self, part: usize) -> (Affine3A, Vec<Affine3A>, Vec<f32>) {
        let part = &self.parts[part];
        let joints = part.skeleton.map(|skeleton| self.skeletons[skeleton].matrices.clone());
        (part.shown, joints.unwrap_or_default(), part.shown_weights.clone())
    }

    /// Returns how many skeletons there are.
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

    /// Returns how many parts there are.
    pub(super) fn len(&self) -> usize {
        self.parts.len()
    }

    /// Returns the box in the world of a part as it was shown last. `mesh` are the bounds of its
    /// mesh, which hold for what does not change its form; `form` are those of its poses, if it
    /// does.
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

    /// Forgets what was shown; `world` are the nodes at rest.
    pub(super) fn begin_anew(&mut self, world: &[Affine3A]) {
        for part in &mut self.parts {
            part.shown = part.place(world);
            part.shown_version = None;
            part.shown_weights.clear();
            part.is_behind = false;
        }
    }

    /// Returns what a part is, and what changes its form.
    pub(super) fn placed(&self, part: usize) -> Option<(PlacedNode, Option<SkinnedMeshId>)> {
        let placement = &self.parts.get(part)?.placement;
        Some((placement.placed, placement.skinned_mesh.map(|(skinned_mesh, _)| skinned_mesh)))
    }

    /// Returns the parts that change while clips play that do this to nodes, and move these. Takes
    /// as long as there are parts and bones.
    pub(super) fn movers(&self, touched: &Touched, is_moving: &[bool], is_new: bool) -> Movers {
        let is_bent = |hung: &Hung| hung.skeleton.bones().any(|bone| touched.moved.contains(&bone));
        let bent: Vec<bool> = self.skeletons.iter().map(is_bent).collect();
        let mut movers = Movers::default();
        for (place, part) in self.parts.iter().enumerate() {
            let node = part.node.and_then(|node| is_moving.get(node.0 as usize));
            let is_deformed = part.placement.skinned_mesh.is_some();
            let is_formed = part.skeleton.is_some_and(|skeleton| bent.get(skeleton) == Some(&true))
                || touched.weighed.contains(&part.placement.node);
            if node == Some(&true) || is_deformed && (is_formed || is_new) {
                movers.moved.push(place);
            } else if part.is_behind {
                movers.behind.push(place);
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

    /// Notes the form of a part if it is another, and if one of the `views` may show it or it never
    /// had a form. Its place must be that of the moment.
    pub(super) fn change(
        &mut self,
        part: usize,
        (rig, pose): (&Rig, &Pose),
        views: Option<&[View]>,
        changes: &mut SceneUpdate,
    ) {
        let Some(part) = self.parts.get_mut(part) else { return };
        let Some((skinned_mesh, _)) = part.placement.skinned_mesh else { return };
        part.is_behind =
            part.shown_version.is_some() && views.is_some_and(|it| !part.may_be_in(it));
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
        changes.deformations.push(Deformation { skinned_mesh, joints, weights });
    }

    /// Notes where a part is if that is elsewhere.
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
    /// Looks at where the joints are now.
    fn pose(&mut self, rig: &Rig, pose: &Pose, matrices: &mut Vec<Affine3A>) {
        self.is_known_now = true;
        self.skeleton.joint_matrices(rig, pose, matrices);
        if self.version == 0 || self.matrices != *matrices {
            self.matrices.clone_from(matrices);
            self.version += 1;
        }
    }

    /// Returns where its matrices are among the changes.
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
    /// Returns where it is.
    fn place(&self, world: &[Affine3A]) -> Affine3A {
        let node = self.node.and_then(|node| world.get(node.0 as usize));
        node.map_or(self.placement.local, |node| *node * self.placement.local)
    }

    /// Returns true if one of the views may show any of it, whatever form it has.
    fn may_be_in(&self, views: &[View]) -> bool {
        let bounds = bounds_of_transformed(&self.placement.reach, &self.shown);
        let is_in =
            |view: &View| view.frustum.classify(&bounds, PlaneMask::ALL).0 != Containment::Outside;
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
