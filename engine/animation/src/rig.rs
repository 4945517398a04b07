//! Rigs: the nodes of a scene, each in the space of its parent, and their world transforms. World
//! transforms are computed for all nodes, or only for moving ones.

use glam::{Affine3A, Quat, Vec3};

use crate::clip::{Channel, Clip};
use crate::pose::Pose;

/// The identity of a node of a rig: an index into its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RigNodeId(pub u32);

/// A transform in parts: scale first, then rotation, then translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trs {
    /// The translation from the parent, in metres.
    pub translation: Vec3,
    /// The rotation, of unit length.
    pub rotation: Quat,
    /// The scale along each axis; 1 leaves the size as it is.
    pub scale: Vec3,
}

impl Trs {
    /// The identity transform.
    pub const IDENTITY: Self =
        Self { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE };

    /// Returns the transform as a matrix.
    pub fn to_affine(&self) -> Affine3A {
        Affine3A::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// The transform of a node relative to its parent when no clip moves the node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rest {
    /// Separate parts, which clips may animate.
    Parts(Trs),
    /// A matrix, which clips cannot animate.
    Matrix(Affine3A),
}

/// A node: a transform relative to a parent.
#[derive(Clone, Debug, PartialEq)]
pub struct RigNode {
    /// The name, for people.
    pub name: String,
    /// The parent, in whose space the node lies; `None` for the world.
    pub parent: Option<RigNodeId>,
    /// The transform relative to the parent at rest.
    pub rest: Rest,
    /// The weights of the node's morph targets at rest; empty if it has none.
    pub weights: Vec<f32>,
}

/// The reason why nodes are not a valid rig.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RigError {
    /// A parent that does not exist.
    #[error("node {node} has the parent {parent}, which is not there")]
    NoParent {
        /// The index of the child.
        node: u32,
        /// The parent that it names.
        parent: u32,
    },
    /// Nodes that are their own ancestors.
    #[error("node {node} is its own ancestor")]
    Cycle {
        /// One of these nodes.
        node: u32,
    },
}

/// The nodes of a scene, and an order with parents before their children.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    nodes: Vec<RigNode>,
    order: Vec<RigNodeId>,
    /// The position of each node in the order.
    places: Vec<u32>,
}

impl Rig {
    /// Creates a rig of these nodes, in time proportional to their number, however deep they are.
    ///
    /// # Errors
    /// A parent that does not exist; nodes that are their own ancestors.
    pub fn new(nodes: Vec<RigNode>) -> Result<Self, RigError> {
        let is_after_parent = |(place, node): (usize, &RigNode)| {
            node.parent.is_none_or(|parent| (parent.0 as usize) < place)
        };
        if nodes.iter().enumerate().all(is_after_parent) {
            let places: Vec<u32> = (0..nodes.len() as u32).collect();
            return Ok(Self {
                nodes,
                order: places.iter().copied().map(RigNodeId).collect(),
                places,
            });
        }
        // The first child of each node, and the next child of its parent: linked lists, so that
        // nodes need no vectors.
        let mut first: Vec<Option<RigNodeId>> = vec![None; nodes.len()];
        let mut next: Vec<Option<RigNodeId>> = vec![None; nodes.len()];
        let mut order = Vec::with_capacity(nodes.len());
        for (place, node) in nodes.iter().enumerate().rev() {
            let id = RigNodeId(place as u32);
            let Some(parent) = node.parent else { continue };
            let Some(first) = first.get_mut(parent.0 as usize) else {
                return Err(RigError::NoParent { node: id.0, parent: parent.0 });
            };
            next[place] = first.replace(id);
        }
        let is_root = |(_, node): &(RigNodeId, &RigNode)| node.parent.is_none();
        order.extend((0..).map(RigNodeId).zip(&nodes).filter(is_root).map(|(id, _)| id));
        let mut done = 0;
        while let Some(node) = order.get(done) {
            let mut child = first[node.0 as usize].take();
            while let Some(id) = child {
                order.push(id);
                child = next[id.0 as usize];
            }
            done += 1;
        }
        match first.iter().flatten().next() {
            Some(node) => Err(RigError::Cycle { node: node.0 }),
            None => {
                let mut places = vec![0; nodes.len()];
                for (place, node) in (0..).zip(&order) {
                    if let Some(entry) = places.get_mut(node.0 as usize) {
                        *entry = place;
                    }
                }
                Ok(Self { nodes, order, places })
            }
        }
    }

    /// Returns the nodes, in the order of their ids.
    pub fn nodes(&self) -> &[RigNode] {
        &self.nodes
    }

    /// Returns all nodes, parents before their children.
    pub fn order(&self) -> &[RigNodeId] {
        &self.order
    }

    /// Returns the position of a node in the order; `u32::MAX` if it does not exist.
    pub(crate) fn place_of(&self, node: RigNodeId) -> u32 {
        self.places.get(node.0 as usize).copied().unwrap_or(u32::MAX)
    }

    /// Computes the transforms from each node's space to the world. All results are finite: a node
    /// whose transform overflows collapses to a point at the origin.
    pub fn world(&self, pose: &Pose, world: &mut Vec<Affine3A>) {
        world.clear();
        world.resize(self.nodes().len(), Affine3A::IDENTITY);
        self.update_world(self.order(), pose, world);
    }

    /// Updates the world transforms of the nodes in `moved`, which [`Rig::moved_by`] returns; the
    /// rest of `world` is unchanged.
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
    /// their descendants, parents before children. The time is proportional to the size of the rig,
    /// so call it once per set of clips, not per frame. When a clip has ended, update its nodes
    /// once more, so that they return to rest.
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

/// Returns the matrix, or a point at the origin if it overflowed: this crate returns only finite
/// transforms.
pub(crate) fn finite(matrix: Affine3A) -> Affine3A {
    if matrix.is_finite() { matrix } else { Affine3A::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig(parents: &[Option<u32>]) -> Result<Rig, RigError> {
        let node = |parent: &Option<u32>| RigNode {
            name: String::new(),
            parent: parent.map(RigNodeId),
            rest: Rest::Matrix(Affine3A::IDENTITY),
            weights: Vec::new(),
        };
        Rig::new(parents.iter().map(node).collect())
    }

    #[test]
    fn parents_come_before_their_children_in_whatever_order_nodes_are_given() {
        let given: [&[Option<u32>]; 5] = [
            &[],
            &[None, Some(0), Some(1), Some(0), None],
            &[Some(1), Some(2), Some(3), None],
            &[Some(3), None, Some(1), Some(1), Some(0), Some(4)],
            &[None, Some(2), Some(0), Some(1)],
        ];
        for parents in given {
            let rig = rig(parents).unwrap_or_else(|error| unreachable!("{error}"));
            assert_eq!(rig.order().len(), parents.len());
            for (place, node) in (0..).zip(rig.order()) {
                assert_eq!(rig.place_of(*node), place);
                let parent = parents[node.0 as usize].map(RigNodeId);
                assert!(parent.is_none_or(|parent| rig.place_of(parent) < place), "{parents:?}");
            }
        }
    }

    #[test]
    fn nodes_that_are_no_forest_are_refused() {
        assert_eq!(rig(&[None, Some(2)]), Err(RigError::NoParent { node: 1, parent: 2 }));
        for circle in [&[Some(0)][..], &[Some(1), Some(0)], &[None, Some(3), Some(1), Some(2)]] {
            assert!(matches!(rig(circle), Err(RigError::Cycle { .. })), "{circle:?}");
        }
    }
}
