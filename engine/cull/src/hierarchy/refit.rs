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
            if !topology.nodes[node as usize].is_leaf() {
                self.update(topology, node);
            }
            self.wear.reset(node, &self.all[node as usize]);
        }
    }

    /// Sets the box of a leaf.
    pub(super) fn place(&mut self, node: u32, bounds: Aabb) {
        self.all[node as usize] = Node::leaf(bounds);
    }

    /// Computes an inner node from its children, and returns its data.
    #[inline]
    pub(super) fn update(&mut self, topology: &Topology, node: u32) -> Node {
        let [left, right] = topology.nodes[node as usize].children(node);
        let above = Node::above(&self.all[left as usize], &self.all[right as usize]);
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

/// Sets the boxes of `moved` objects and then updates their ancestors, the deepest first. Logs the
/// moves, and calls `touched` with every ancestor and its new data. Leaves `stale` empty.
///
/// The ancestors are found on the way: each updated node puts its parent into the set.
pub(super) fn refit(
    topology: &Topology,
    nodes: &mut Nodes,
    stale: &mut NodeSet,
    log: &mut BoxLog,
    moved: impl IntoIterator<Item = (ObjectId, Aabb)>,
    mut touched: impl FnMut(&Wear, u32, &Node),
) -> Result<(), HierarchyError> {
    stale.grow(nodes.all.len());
    let outcome = moved.into_iter().try_for_each(|(object, target)| {
        check(object.0 as usize, &target)?;
        let node = occupied(topology, nodes, object)?;
        let moved = &mut nodes.all[node as usize];
        let change = BoxChange { object, before: moved.bounds(), after: target };
        log.push(change, topology.object_nodes.len());
        *moved = Node::leaf(target);
        stale.insert(node);
        Ok(())
    });
    stale.drain_down(|node| {
        let links = &topology.nodes[node as usize];
        if !links.is_leaf() {
            let data = nodes.update(topology, node);
            touched(&nodes.wear, node, &data);
        }
        (links.parent != NO_NODE).then_some(links.parent)
    });
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
