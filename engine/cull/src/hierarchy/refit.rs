//! Moves boxes in a hierarchy of fixed shape: only ancestors of moved leaves are touched.

use std::collections::TryReserveError;

use super::box_log::{BoxChange, BoxLog};
use super::error::{HierarchyError, check};
use super::topology::{NO_NODE, Topology};
use super::wear::Wear;
use crate::geom::bounds::Aabb;
use crate::ids::ObjectId;

/// The data of every node that depends on the objects under it.
#[derive(Clone, Debug, Default)]
pub(super) struct Nodes {
    pub(super) bounds: Vec<Aabb>,
    /// The number of leaves without an object under each node.
    pub(super) free: Vec<u32>,
    pub(super) wear: Wear,
}

impl Nodes {
    /// Creates the data of a hierarchy that was just built over `boxes`.
    pub(super) fn new(topology: &Topology, boxes: &[Aabb]) -> Self {
        let count = topology.nodes.len();
        let mut nodes =
            Self { bounds: vec![Aabb::EMPTY; count], free: vec![0; count], wear: Wear::new(count) };
        for (object, bounds) in topology.object_nodes.iter().zip(boxes) {
            nodes.place(*object, *bounds);
        }
        nodes.build(topology, 0);
        nodes
    }

    /// The memory per node (bytes).
    pub(super) const BYTES: usize = size_of::<Aabb>() + size_of::<u32>() + Wear::BYTES;

    /// Reserves memory for [`Nodes::add`].
    pub(super) fn try_reserve(&mut self, count: usize) -> Result<(), TryReserveError> {
        self.bounds.try_reserve_exact(count)?;
        self.free.try_reserve_exact(count)?;
        self.wear.try_reserve(count)
    }

    /// Adds nodes without objects.
    pub(super) fn add(&mut self, count: usize) {
        self.bounds.resize(self.bounds.len() + count, Aabb::EMPTY);
        self.free.resize(self.free.len() + count, 0);
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
            self.wear.reset(node, &self.bounds[node as usize]);
        }
    }

    /// Sets the box of a leaf.
    pub(super) fn place(&mut self, node: u32, bounds: Aabb) {
        self.bounds[node as usize] = bounds;
        self.free[node as usize] = u32::from(bounds.is_empty());
        self.wear.update_leaf(node);
    }

    /// Computes an inner node from its children.
    pub(super) fn update(&mut self, topology: &Topology, node: u32) {
        let children = topology.nodes[node as usize].children(node);
        let [left, right] = children.map(|child| child as usize);
        let bounds = self.bounds[left].union(&self.bounds[right]);
        self.bounds[node as usize] = bounds;
        self.free[node as usize] = self.free[left] + self.free[right];
        self.wear.update(node, &bounds, children);
    }
}

/// Memory that is kept between refits, so that moving objects does not allocate.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// The ancestors whose box must be computed again.
    stale: Vec<u32>,
    /// True for each node that is in `stale`.
    is_stale: Vec<bool>,
}

/// Sets the boxes of `moved` objects and then updates their ancestors, the deepest first. Logs the
/// moves, and calls `touched` with every ancestor.
pub(super) fn refit(
    topology: &Topology,
    nodes: &mut Nodes,
    scratch: &mut Scratch,
    log: &mut BoxLog,
    moved: impl IntoIterator<Item = (ObjectId, Aabb)>,
    mut touched: impl FnMut(&Nodes, u32),
) -> Result<(), HierarchyError> {
    scratch.is_stale.resize(nodes.bounds.len(), false);
    let outcome = moved
        .into_iter()
        .try_for_each(|(object, target)| place(topology, nodes, scratch, log, object, target));
    // In pre-order children have larger numbers than their parents.
    scratch.stale.sort_unstable_by(|a, b| b.cmp(a));
    for node in scratch.stale.drain(..) {
        nodes.update(topology, node);
        scratch.is_stale[node as usize] = false;
        touched(nodes, node);
    }
    outcome
}

/// Sets the box of one object and marks its ancestors up to the first marked one.
fn place(
    topology: &Topology,
    nodes: &mut Nodes,
    scratch: &mut Scratch,
    log: &mut BoxLog,
    object: ObjectId,
    target: Aabb,
) -> Result<(), HierarchyError> {
    check(object.0 as usize, &target)?;
    let node = occupied(topology, nodes, object)?;
    log.push(BoxChange { object, before: nodes.bounds[node as usize], after: target });
    nodes.place(node, target);
    let mut parent = topology.nodes[node as usize].parent;
    while parent != NO_NODE && !scratch.is_stale[parent as usize] {
        scratch.is_stale[parent as usize] = true;
        scratch.stale.push(parent);
        parent = topology.nodes[parent as usize].parent;
    }
    Ok(())
}

/// Returns the node of an object that is in the hierarchy.
pub(super) fn occupied(
    topology: &Topology,
    nodes: &Nodes,
    object: ObjectId,
) -> Result<u32, HierarchyError> {
    let node = topology.object_nodes.get(object.0 as usize).copied();
    node.filter(|node| nodes.free[*node as usize] == 0)
        .ok_or(HierarchyError::UnknownObject { object })
}
