//! World transforms of nodes: all of them, or only those that something moves.

use glam::{Affine3A, Quat, Vec3};

use crate::clip::{Channel, Clip};
use crate::pose::Pose;
use crate::rig::{Rig, RigNodeId, Trs};

impl Trs {
    /// The identity transform.
    pub const IDENTITY: Self =
        Self { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE };

    /// Returns it as a matrix.
    pub fn to_affine(&self) -> Affine3A {
        Affine3A::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// Returns the matrix, or a point at the origin if it overflowed: no value that is not finite
/// leaves this crate.
pub(crate) fn finite(matrix: Affine3A) -> Affine3A {
    if matrix.is_finite() { matrix } else { Affine3A::ZERO }
}

impl Rig {
    /// Computes the transforms from each node's space to the world's. All are finite; a node whose
    /// transform overflows becomes a point at the origin.
    pub fn world(&self, pose: &Pose, world: &mut Vec<Affine3A>) {
        world.clear();
        world.resize(self.nodes().len(), Affine3A::IDENTITY);
        self.update_world(self.order(), pose, world);
    }

    /// Updates the world transforms of `moved` alone, which [`Rig::moved_by`] lists; the rest of
    /// `world` stays the same.
    pub fn update_world(&self, moved: &[RigNodeId], pose: &Pose, world: &mut [Affine3A]) {
        for id in moved {
            let index = id.0 as usize;
            let parent = self.nodes().get(index).and_then(|node| node.parent);
            let parent = parent.and_then(|parent| world.get(parent.0 as usize));
            let local = pose.local(self, *id);
            let place = finite(parent.map_or(local, |parent| *parent * local));
            if let Some(entry) = world.get_mut(index) {
                *entry = place;
            }
        }
    }

    /// Returns the nodes that move in the world when these clips play: the animated nodes and all
    /// below, parents before children. Takes time in proportion to the rig: call it once for a set
    /// of clips, not per frame. When a clip has ended, its nodes must be updated once more, back to
    /// rest.
    pub fn moved_by<'a>(&self, clips: impl IntoIterator<Item = &'a Clip>) -> Vec<RigNodeId> {
        let mut moves = vec![false; self.nodes().len()];
        let channels = clips.into_iter().flat_map(|clip| &clip.channels);
        for Channel { node, .. } in channels.filter(|channel| channel.is_transform()) {
            if let Some(moves) = moves.get_mut(node.0 as usize) {
                *moves = true;
            }
        }
        let mut moved = Vec::new();
        for id in self.order() {
            let parent = self.nodes().get(id.0 as usize).and_then(|node| node.parent);
            let with_parent = parent.and_then(|parent| moves.get(parent.0 as usize)).copied();
            if let Some(moves) = moves.get_mut(id.0 as usize) {
                *moves |= with_parent.unwrap_or_default();
                if *moves {
                    moved.push(*id);
                }
            }
        }
        moved
    }
}
