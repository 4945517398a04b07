//! Skeletons: the hierarchy of a skin's joints, and the matrices that its vertices follow.

use std::collections::BinaryHeap;

use glam::Affine3A;

use crate::clip::Clip;
use crate::pose::Pose;
use crate::rig::{Rig, RigNodeId, finite};
use crate::skin::Skin;

/// The reason why joints are not a valid skin of a rig.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SkinError {
    /// A skin without a joint: it needs at least one.
    #[error("the skin has no joints")]
    Empty,
    /// A joint that is not a node.
    #[error("joint {joint} is node {node}, which is not there")]
    NoNode {
        /// The index of the joint.
        joint: usize,
        /// The node that it names.
        node: u32,
    },
    /// A number of inverse bind matrices that differs from the number of joints.
    #[error("{joints} joints have {matrices} inverse bind matrices")]
    Count {
        /// The number of joints.
        joints: usize,
        /// The number of matrices.
        matrices: usize,
    },
    /// An inverse bind matrix that is not finite.
    #[error("the inverse bind matrix of joint {joint} is not finite")]
    NotFinite {
        /// The joint of the matrix.
        joint: usize,
    },
}

/// A node between the space of a skeleton and a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bone {
    /// The node of the bone.
    pub node: RigNodeId,
    /// The parent bone; `None` if the parent is the skeleton's space.
    pub parent: Option<usize>,
}

/// A joint: vertices that follow it are first transformed to its space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Joint {
    /// The bone of the joint; `None` if the joint is the skeleton's space.
    pub bone: Option<usize>,
    /// The transform from the mesh's space at rest to the joint's space.
    pub inverse_bind: Affine3A,
}

/// A skin on its rig.
///
/// A skinned object does not belong to a node of the file: glTF ignores the transform of the node
/// that has the mesh. Here it belongs to the **deepest node that moves all joints**
/// ([`Skeleton::space`], mostly the topmost joint). The movement of this node and its ancestors
/// (running, turning round) is in the object's transform. Joint matrices and boxes are relative to
/// this node, so boxes stay as small as in an animation "in place". The matrices are products of
/// local transforms from this node down to each joint. So no transform is ever inverted, and
/// singular transforms are valid.
#[derive(Clone, Debug, PartialEq)]
pub struct Skeleton {
    space: Option<RigNodeId>,
    /// The bones, parents before children.
    pub(crate) bones: Vec<Bone>,
    /// The bones of nodes, sorted by node.
    bone_of: Vec<(RigNodeId, usize)>,
    /// An element per joint of the skin; `None` if no vertex follows it.
    pub(crate) joints: Vec<Option<Joint>>,
}

impl Skeleton {
    /// Creates the skeleton of a skin, in time proportional to the number of its bones, not to the
    /// size of the rig. `is_used` is true for each joint that a vertex follows. Unused joints do
    /// not affect [`Skeleton::space`] and cost no time. If `is_used` is empty, all joints are used.
    ///
    /// # Errors
    /// A skin without joints; joints that are not nodes; a number of inverse bind matrices that
    /// differs from the number of joints; a matrix that is not finite.
    pub fn new(rig: &Rig, skin: &Skin, is_used: &[bool]) -> Result<Self, SkinError> {
        check(rig, skin)?;
        let uses = |joint: usize| is_used.get(joint).copied().unwrap_or(is_used.is_empty());
        let used = skin.joints.iter().enumerate().filter(|(joint, _)| uses(*joint));
        let (space, nodes) = between(rig, used.map(|(_, node)| *node));
        let mut bone_of: Vec<_> = (0..).zip(&nodes).map(|(bone, node)| (*node, bone)).collect();
        bone_of.sort_unstable();
        let find = |node: RigNodeId| find(&bone_of, node);
        let bone = |node: &RigNodeId| {
            let parent = rig.nodes().get(node.0 as usize).and_then(|node| node.parent);
            Bone { node: *node, parent: parent.and_then(find) }
        };
        let bones = nodes.iter().map(bone).collect();
        let joints = skin.joints.iter().zip(&skin.inverse_bind).enumerate();
        let joints = joints.map(|(joint, (node, inverse_bind))| {
            uses(joint).then_some(Joint { bone: find(*node), inverse_bind: *inverse_bind })
        });
        let joints = joints.collect();
        Ok(Self { space, bones, bone_of, joints })
    }

    /// Returns the node whose world transform is the object's transform. `None` if the joints have
    /// no common ancestor: then the object's space is the world.
    pub fn space(&self) -> Option<RigNodeId> {
        self.space
    }

    pub(crate) fn bone_of(&self, node: RigNodeId) -> Option<usize> {
        find(&self.bone_of, node)
    }

    /// Returns the nodes below its space down to its joints, including the joints, parents before
    /// children: these nodes move its vertices.
    pub fn bones(&self) -> impl Iterator<Item = RigNodeId> {
        self.bones.iter().map(|bone| bone.node)
    }

    /// Returns the number of matrices of [`Skeleton::joint_matrices`].
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// Returns true if a clip moves the vertices relative to the object.
    pub fn is_moved_by(&self, clip: &Clip) -> bool {
        let mut moving = clip.channels.iter().filter(|channel| channel.is_transform());
        moving.any(|channel| self.bone_of(channel.node).is_some())
    }

    /// Computes for each joint the matrix that transforms vertices from the mesh's space at rest to
    /// the object's space. All matrices are finite: a matrix that overflows collapses to a point.
    /// Unused joints get the identity.
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

/// Returns the bone of a node in a sorted list.
fn find(bone_of: &[(RigNodeId, usize)], node: RigNodeId) -> Option<usize> {
    let place = bone_of.binary_search_by_key(&node, |(node, _)| *node).ok()?;
    bone_of.get(place).map(|(_, bone)| *bone)
}

/// Returns the deepest node that moves all joints, and the nodes below it down to the joints,
/// parents before children.
///
/// In the order of the rig, all descendants of a node follow it. So the deepest common ancestor is
/// the first node, going up from the last joint, that has all joints below it.
fn between(
    rig: &Rig,
    joints: impl Iterator<Item = RigNodeId>,
) -> (Option<RigNodeId>, Vec<RigNodeId>) {
    let entry = |node: RigNodeId, joints: usize| (rig.place_of(node), node, joints);
    let mut open: BinaryHeap<_> = joints.map(|node| entry(node, 1)).collect();
    let total = open.len();
    let mut bones = Vec::new();
    while let Some((place, node, mut below)) = open.pop() {
        while let Some(&(other, _, more)) = open.peek()
            && other == place
        {
            below += more;
            open.pop();
        }
        if below == total {
            bones.reverse();
            return (Some(node), bones);
        }
        bones.push(node);
        let parent = rig.nodes().get(node.0 as usize).and_then(|node| node.parent);
        open.extend(parent.map(|parent| entry(parent, below)));
    }
    bones.reverse();
    (None, bones)
}

fn check(rig: &Rig, skin: &Skin) -> Result<(), SkinError> {
    if skin.joints.is_empty() {
        return Err(SkinError::Empty);
    }
    if skin.joints.len() != skin.inverse_bind.len() {
        let joints = skin.joints.len();
        let matrices = skin.inverse_bind.len();
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
