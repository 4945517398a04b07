//! Skins: the joints that the vertices of a mesh follow.

use glam::Affine3A;

use crate::rig::RigNodeId;

/// The joints of a skin. Vertices refer to them by index.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// The nodes that are the joints.
    pub joints: Vec<RigNodeId>,
    /// For each joint the transform from the mesh's space at rest to the joint's space.
    pub inverse_bind: Vec<Affine3A>,
}
