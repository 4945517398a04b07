//! The changes of a scene between two frames, as plain values.

use std::ops::Range;

use cull::ObjectId;
use glam::Affine3A;

use super::{LightId, Object, PunctualLight, SkinnedMeshId, TransparentId};

/// A change of an object between two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectChange {
    /// The object moves.
    Move {
        /// The id of the object in the scene.
        object: ObjectId,
        /// The new transform.
        transform: Affine3A,
    },
    /// The object is removed; its id may be reused.
    Remove {
        /// The id of the object in the scene.
        object: ObjectId,
    },
    /// The object is added. The renderer's update returns its id.
    Add {
        /// The new object. Its mesh belongs to the scene.
        object: Object,
    },
}

/// A new transform of a transparent object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransparentMove {
    /// The transparent object that moves.
    pub transparent: TransparentId,
    /// The transform from the object's space to the world.
    pub transform: Affine3A,
}

/// A new place, colour or strength of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightMove {
    /// The light that changes.
    pub light: LightId,
    /// The new state; the kind of light must stay the same.
    pub to: PunctualLight,
}

/// The new pose of a skinned mesh. The renderer computes the box of its object from the pose, see
/// [`PoseBounds`](super::PoseBounds).
#[derive(Clone, Debug, PartialEq)]
pub struct PoseUpdate {
    /// The skinned mesh that takes the pose.
    pub skinned_mesh: SkinnedMeshId,
    /// The matrices of its joints, in [`SceneUpdate::joints`]; empty without a skin. Meshes with
    /// the same joints may share them.
    pub joints: Range<usize>,
    /// The weights of its morph targets, in [`SceneUpdate::weights`]; empty without targets.
    pub weights: Range<usize>,
}

/// The changes of a scene between two frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneUpdate {
    /// Objects that move, come or go, in this order.
    pub objects: Vec<ObjectChange>,
    /// Transparent objects that move.
    pub transparent: Vec<TransparentMove>,
    /// Lights that change.
    pub lights: Vec<LightMove>,
    /// Skinned meshes in another pose.
    pub poses: Vec<PoseUpdate>,
    /// Matrices of joints: from the mesh's space at rest to its current space.
    pub joints: Vec<Affine3A>,
    /// Weights of morph targets.
    pub weights: Vec<f32>,
}

impl SceneUpdate {
    /// Removes all changes and keeps the memory.
    pub fn clear(&mut self) {
        self.objects.clear();
        self.transparent.clear();
        self.lights.clear();
        self.poses.clear();
        self.joints.clear();
        self.weights.clear();
    }

    /// Returns true if there are no changes.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty()
            && self.transparent.is_empty()
            && self.lights.is_empty()
            && self.poses.is_empty()
    }
}
