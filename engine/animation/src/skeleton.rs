//! Skeletons: how the joints of a skin hang together, and the matrices that its vertices follow.

use glam::Affine3A;

use crate::clip::Clip;
use crate::pose::Pose;
use crate::rig::{NodeId, Rig};
use crate::skin::Skin;
use crate::world::finite;

/// Why joints are no skin of a rig.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SkinError {
    /// No joints.
    #[error("the skin has no joints")]
    Empty,
    /// A joint that is no node.
    #[error("joint {joint} is node {node}, which is not there")]
    NoNode {
        /// Which joint.
        joint: usize,
        /// What it names.
        node: u32,
    },
    /// Not one inverse bind matrix a joint.
    #[error("{joints} joints have {matrices} inverse bind matrices")]
    Count {
        /// How many joints there are.
        joints: usize,
        /// How many matrices.
        matrices: usize,
    },
    /// An inverse bind matrix that is not finite.
    #[error("the inverse bind matrix of joint {joint} is not finite")]
    NotFinite {
        /// Whose.
        joint: usize,
    },
}

/// A node between the space of a skeleton and a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bone {
    /// Which node.
    pub node: NodeId,
    /// The bone it hangs on; `None` if it hangs on the space.
    pub parent: Option<usize>,
}

/// A joint: what follows it first goes into its space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Joint {
    /// Its bone; `None` if it is the space itself.
    pub bone: Option<usize>,
    /// From the mesh's space at rest to its own.
    pub inverse_bind: Affine3A,
}

/// A skin on its rig.
///
/// The object that hangs on a skin belongs to no node of the file: glTF ignores the transform of the node
/// that has the mesh. Here it belongs to the **deepest node that moves all joints** ([`Skeleton::space`],
/// mostly the topmost joint): what that node and those above it do (running away, turning round) is in the
/// object's transform, and joint matrices and boxes say only what happens relative to it. So boxes stay as
/// small as the animation "in place". The matrices are products of local transforms from there down to each
/// joint, so that no transform is ever inverted, and singular ones are as good as others.
#[derive(Clone, Debug, PartialEq)]
pub struct Skeleton {
    space: Option<NodeId>,
    /// Parents before children.
    pub(crate) bones: Vec<Bone>,
    /// The bone of each node that has one, by node.
    bone_of: Vec<(NodeId, usize)>,
    /// One for each joint of the skin; `None` if no vertex follows it.
    pub(crate) joints: Vec<Option<Joint>>,
}

impl Skeleton {
    /// The skeleton of a skin. `is_used` says of each joint whether a vertex follows it: joints that move
    /// nothing then neither pull [`Skeleton::space`] upwards nor cost time. Empty: all are used.
    ///
    /// # Errors
    /// A skin without joints; joints that are no nodes; not one finite inverse bind matrix for each joint.
    pub fn new(rig: &Rig, skin: &Skin, is_used: &[bool]) -> Result<Self, SkinError> {
        check(rig, skin)?;
        let uses = |joint: usize| is_used.get(joint).copied().unwrap_or(is_used.is_empty());
        let mut below = vec![0_usize; rig.nodes().len()];
        let mut total = 0;
        for (_, node) in skin.joints.iter().enumerate().filter(|(joint, _)| uses(*joint)) {
            if let Some(below) = below.get_mut(node.0 as usize) {
                *below += 1;
                total += 1;
            }
        }
        let parent_of =
            |node: NodeId| rig.nodes().get(node.0 as usize).and_then(|node| node.parent);
        for node in rig.order().iter().rev() {
            let joints = below.get(node.0 as usize).copied().unwrap_or_default();
            let parent = parent_of(*node).and_then(|parent| below.get_mut(parent.0 as usize));
            if let Some(parent) = parent {
                *parent += joints;
            }
        }
        let joints_below = |node: &NodeId| below.get(node.0 as usize).copied().unwrap_or_default();
        // Nodes above all joints are ancestors of each other: the last in the order is the deepest.
        let all = |node: &&NodeId| total > 0 && joints_below(node) == total;
        let space = rig.order().iter().rfind(all).copied();
        let mut bones = Vec::new();
        let mut bone_of: Vec<Option<usize>> = vec![None; rig.nodes().len()];
        let is_above = |node: &NodeId| space.is_some() && joints_below(node) == total;
        for node in rig.order().iter().filter(|node| joints_below(node) > 0 && !is_above(node)) {
            let parent = parent_of(*node).and_then(|parent| *bone_of.get(parent.0 as usize)?);
            if let Some(bone) = bone_of.get_mut(node.0 as usize) {
                *bone = Some(bones.len());
                bones.push(Bone { node: *node, parent });
            }
        }
        let joints = skin.joints.iter().zip(&skin.inverse_bind).enumerate();
        let joints = joints.map(|(joint, (node, inverse_bind))| {
            let bone = bone_of.get(node.0 as usize).copied().flatten();
            uses(joint).then_some(Joint { bone, inverse_bind: *inverse_bind })
        });
        let joints = joints.collect();
        let mut bone_of: Vec<_> =
            (0..).zip(&bones).map(|(index, bone)| (bone.node, index)).collect();
        bone_of.sort_unstable();
        Ok(Self { space, bones, bone_of, joints })
    }

    /// The node whose world transform is the object's; `None` if the joints have no ancestor in common: then
    /// the object's space is the world.
    pub fn space(&self) -> Option<NodeId> {
        self.space
    }

    /// The bone that a node is.
    pub(crate) fn bone_of(&self, node: NodeId) -> Option<usize> {
        let place = self.bone_of.binary_search_by_key(&node, |(node, _)| *node).ok()?;
        self.bone_of.get(place).map(|(_, bone)| *bone)
    }

    /// How many matrices [`Skeleton::joint_matrices`] gives.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// Whether a clip changes the form of what hangs on it, rather than only its place.
    pub fn is_moved_by(&self, clip: &Clip) -> bool {
        let mut moving = clip.channels.iter().filter(|channel| channel.is_transform());
        moving.any(|channel| self.bone_of(channel.node).is_some())
    }

    /// For each joint the matrix from the mesh's space at rest to the object's: what vertices are multiplied
    /// with. All are finite: what overflows becomes a point. Joints that are not used stay where they are.
    pub fn joint_matrices(&self, rig: &Rig, pose: &Pose, matrices: &mut Vec<Affine3A>) {
        matrices.clear();
        self.bone_transforms(rig, pose, matrices);
        for joint in &self.joints {
            let matrix = joint.as_ref().map_or(Affine3A::IDENTITY, |joint| {
                let bone = joint.bone.and_then(|bone| matrices.get(bone));
                finite(bone.map_or(joint.inverse_bind, |bone| *bone * joint.inverse_bind))
            });
            matrices.push(matrix);
        }
        matrices.drain(..self.bones.len().min(matrices.len()));
    }

    /// Appends for each bone the transform from its space to the object's.
    pub(crate) fn bone_transforms(&self, rig: &Rig, pose: &Pose, transforms: &mut Vec<Affine3A>) {
        let first = transforms.len();
        for Bone { node, parent } in &self.bones {
            let local = pose.local(rig, *node);
            let parent = parent.and_then(|parent| transforms.get(first + parent));
            transforms.push(finite(parent.map_or(local, |parent| *parent * local)));
        }
    }
}

fn check(rig: &Rig, skin: &Skin) -> Result<(), SkinError> {
    if skin.joints.is_empty() {
        return Err(SkinError::Empty);
    }
    if skin.joints.len() != skin.inverse_bind.len() {
        let (joints, matrices) = (skin.joints.len(), skin.inverse_bind.len());
        return Err(SkinError::Count { joints, matrices });
    }
    for (joint, node) in skin.joints.iter().enumerate() {
        if rig.nodes().get(node.0 as usize).is_none() {
            return Err(SkinError::NoNode { joint, node: node.0 });
        }
    }
    match skin.inverse_bind.iter().position(|matrix| !matrix.is_finite()) {
        Some(joint) => Err(SkinError::NotFinite { joint }),
        None => Ok(()),
    }
}
