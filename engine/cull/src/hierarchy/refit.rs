//! Moves boxes in a hierarchy of fixed shape: only ancestors of moved leaves are touched.

use std::collections::TryReserveError;

use super::box_log::{BoxChange, BoxLog};
use super::error::{HierarchyError, check};
use super::node::Node;
use super::node_set::NodeSet;
use super::topology::{NO_NODE, Topology};
use super::wear::Wear;
use crate::geom::bounds::Aabb;
use crate::ids::ObjectId;

/// The data of every node that depends on the objects under it.
#[derive(Clone, Debug, Default)]
pub(super) struct Nodes {
    pub(super) all: Vec<Node>,
    pub(super) wear: Wear,
}

impl Nodes {
    /// Creates the data of a hierarchy that was just built over `boxes`.
    pub(super) fn new(topology: &Topology, boxes: &[Aabb]) -> Self {
        let count = topology.nodes.len();
        let mut nodes = Self { all: vec![Node::EMPTY; count], wear: Wear::new(count) };
        for (object, bounds) in topology.object_nodes.iter().zip(boxes) {
            nodes.place(*object, *bounds);
        }
        nodes.build(topology, 0);
        nodes
    }

    /// The memory per node (bytes).
    pub(super) const BYTES: usize = size_of::<Node>() + Wear::BYTES;

    /// Reserves memory for [`Nodes::add`].
    pub(super) fn try_reserve(&mut self, count: usize) -> Result<(), TryReserveError> {
        self.all.try_reserve_exact(count)?;
        self.wear.try_reserve(count)
    }

    /// Adds nodes without objects.
    pub(super) fn add(&mut self, count: usize) {
        self.all.resize(self.all.len() + count, Node::EMPTY);
        self.wear.add(count);
    }

    /// Computes the data of a subtree from the boxes of its leaves, and marks it as well built.
    pub(super) fn build(&mut self, topology: &Topology, root: u32) {
        let Some(links) = topology.nodes.get(root as usize) else {
            return;
        };
        // Children follow their parents.
        for node in (root..links.end(root)).rev() {
            let right = topology.rights[node as usize];
            if right != NO_NODE {
                self.update(node, right);
            }
            self.wear.reset(node, &self.all[node as usize]);
        }
    }

    /// Sets the box of a leaf.
    pub(super) fn place(&mut self, node: u32, bounds: Aabb) {
        self.all[node as usize] = Node::leaf(bounds);
    }

    /// Computes an inner node from its children, of which `right` is the second, and returns its
    /// data.
    #[inline]
    pub(super) fn update(&mut self, node: u32, right: u32) -> Node {
        let above = Node::above(&self.all[node as usize + 1], &self.all[right as usize]);
        self.all[node as usize] = above;
        above
    }

    /// Returns the area (square metres) that a rebuild of a subtree is expected to save; `None` if
    /// the subtree is not worn.
    #[inline]
    pub(super) fn excess(&self, node: u32) -> Option<f32> {
        self.wear.excess(node, self.all.get(node as usize)?)
    }
}

/// The nodes that a refit must update; empty between refits.
#[derive(Clone, Debug, Default)]
pub(super) struct Stale {
    leaves: NodeSet,
    /// The ancestors of these leaves, each before the nodes below it.
    ancestors: Vec<Ancestor>,
    /// The ancestors of the leaf that was found last, from the root down.
    path: Vec<Ancestor>,
}

/// A node above a moved leaf.
#[derive(Clone, Copy, Debug)]
struct Ancestor {
    node: u32,
    right: u32,
    /// The first node that is not below it.
    end: u32,
}

impl Stale {
    /// Lists the ancestors of the leaves, and removes the leaves.
    ///
    /// Descends from the root in the order of the memory and reads the right children alone: a
    /// climb from each leaf would wait for the memory at each step.
    fn find_ancestors(&mut self, rights: &[u32]) {
        let Self { leaves, ancestors, path } = self;
        path.clear();
        leaves.drain(|leaf| {
            while path.last().is_some_and(|last| last.end <= leaf) {
                path.pop();
            }
            let mut node = 0;
            let mut end = rights.len() as u32;
            if let Some(last) = path.last() {
                // What is left of a node on the path is its right side.
                node = last.right;
                end = last.end;
            }
            while node != leaf {
                let right = rights[node as usize];
                let ancestor = Ancestor { node, right, end };
                ancestors.push(ancestor);
                path.push(ancestor);
                if leaf < right {
                    node += 1;
                    end = right;
                } else {
                    node = right;
                }
            }
        });
    }
}

/// Sets the boxes of `moved` objects and then updates their ancestors, the deepest first. Logs the
/// moves, and calls `touched` with every ancestor, its number of leaves and its new data. Leaves
/// `stale` empty.
///
/// Each step knows all its nodes before it begins, and goes through the memory in its order. So the
/// processor can fetch many nodes at once.
pub(super) fn refit(
    topology: &Topology,
    nodes: &mut Nodes,
    stale: &mut Stale,
    log: &mut BoxLog,
    moved: impl IntoIterator<Item = (ObjectId, Aabb)>,
    mut touched: impl FnMut(&Wear, u32, u32, &Node),
) -> Result<(), HierarchyError> {
    stale.leaves.grow(nodes.all.len());
    let outcome = moved.into_iter().try_for_each(|(object, target)| {
        check(object.0 as usize, &target)?;
        let node = occupied(topology, nodes, object)?;
        let moved = &mut nodes.all[node as usize];
        log.push(BoxChange { object, before: moved.bounds(), after: target });
        *moved = Node::leaf(target);
        stale.leaves.insert(node);
        Ok(())
    });
    stale.find_ancestors(&topology.rights);
    for Ancestor { node, right, end } in stale.ancestors.drain(..).rev() {
        let data = nodes.update(node, right);
        // A tree with n leaves has 2n - 1 nodes.
        touched(&nodes.wear, node, (end - node).div_ceil(2), &data);
    }
    outcome
}

/// Returns the node of an object that is in the hierarchy.
#[inline]
pub(super) fn occupied(
    topology: &Topology,
    nodes: &Nodes,
    object: ObjectId,
) -> Result<u32, HierarchyError> {
    let node = topology.object_nodes.get(object.0 as usize).copied();
    node.filter(|node| nodes.all[*node as usize].free() == 0)
        .ok_or(HierarchyError::UnknownObject { object })
}
