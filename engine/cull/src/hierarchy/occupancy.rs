//! Objects that come and go: a leaf whose object went is free, with an empty box, until another
//! object moves in.

use super::refit::{Nodes, occupied};
use super::topology::{NO_NODE, Topology};
use super::{HierarchyError, check};
use crate::bounds::Aabb;
use crate::ids::ObjectId;

/// Empties the leaf of an object; answers its node.
pub(super) fn vacate(
    topology: &Topology,
    nodes: &mut Nodes,
    object: ObjectId,
) -> Result<u32, HierarchyError> {
    let node = occupied(topology, nodes, object)?;
    nodes.place(node, Aabb::EMPTY);
    Ok(node)
}

/// Puts an object into a free leaf near it; answers the leaf's node.
pub(super) fn occupy(
    topology: &Topology,
    nodes: &mut Nodes,
    bounds: Aabb,
) -> Result<u32, HierarchyError> {
    let leaf = free_leaf(topology, nodes, &bounds).ok_or(HierarchyError::NoFreeLeaf)?;
    let object = topology.leaf_objects[topology.nodes[leaf as usize].first_leaf as usize];
    check(object.0 as usize, &bounds)?;
    nodes.place(leaf, bounds);
    Ok(leaf)
}

/// Computes the ancestors of a leaf again; tells `touched` each.
pub(super) fn refit_above(
    topology: &Topology,
    nodes: &mut Nodes,
    leaf: u32,
    mut touched: impl FnMut(&Nodes, u32),
) {
    let mut node = topology.nodes[leaf as usize].parent;
    while node != NO_NODE {
        nodes.update(topology, node);
        touched(nodes, node);
        node = topology.nodes[node as usize].parent;
    }
}

/// The free leaf that is found by going down where the box grows the least.
fn free_leaf(topology: &Topology, nodes: &Nodes, bounds: &Aabb) -> Option<u32> {
    let growth = |node: u32| {
        let before = &nodes.bounds[node as usize];
        before.union(bounds).half_area() - before.half_area()
    };
    let is_free = |node: u32| nodes.free[node as usize] > 0;
    let mut node = 0;
    if nodes.free.is_empty() || !is_free(node) {
        return None;
    }
    while !topology.nodes[node as usize].is_leaf() {
        let [left, right] = topology.nodes[node as usize].children(node);
        node = match (is_free(left), is_free(right)) {
            (true, false) => left,
            (false, true) => right,
            _ if growth(right) < growth(left) => right,
            _ => left,
        };
    }
    Some(node)
}
