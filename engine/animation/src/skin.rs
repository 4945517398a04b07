//! Skins: the joints that a mesh hangs on.

use glam::Affine3A;

use crate::rig::RigNodeId;

/// The joints of a skin. A vertex names them by their places here.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// The nodes that are its joints.
    pub joints: Vec<RigNodeId>,
    /// For each joint, from the mesh's space at rest to the joint's.
    pub inverse_bind: Vec<Affine3A>,
}
