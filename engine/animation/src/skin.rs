//! Skins: the joints that the vertices of a mesh follow.

use glam::Affine3A;

use crate::rig::RigNodeId;

/// The joints of a skin. Vertices refer to them by their indices here.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// The nodes that are its joints.
    pub joints: Vec<RigNodeId>,
    /// The transform from the mesh's space at rest to the joint's, for each joint.
    pub inverse_bind: Vec<Affine3A>,
}
