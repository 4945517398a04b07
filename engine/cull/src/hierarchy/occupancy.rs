//! Insertion and removal of objects: the leaf of a removed object is free, with an empty box, until
//! another object is inserted.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::error::{HierarchyError, check};
use super::node::Node;
use super::refit::{Nodes, occupied};
use super::topology::{NO_NODE, Topology};
use super::wear::Wear;
use crate::geom::bounds::Aabb;
use crate::ids::ObjectId;

/// Empties the leaf of an object and returns its node.
pub(super) fn vacate(
    topology: &Topology,
    nodes: &mut Nodes,
    object: ObjectId,
) -> Result<u32, HierarchyError> {
    let node = occupied(topology, nodes, object)?;
    nodes.place(node, Aabb::EMPTY);
    Ok(node)
}

/// Moves an object into a free leaf near it and returns the leaf's node.
pub(super) fn occupy(
    topology: &Topology,
    nodes: &mut Nodes,
    search: &mut Search,
    bounds: Aabb,
) -> Result<u32, HierarchyError> {
    let leaf = free_leaf(topology, nodes, search, &bounds).ok_or(HierarchyError::NoFreeLeaf)?;
    let object = topology.leaf_objects[topology.nodes[leaf as usize].first_leaf as usize];
    check(object.0 as usize, &bounds)?;
    nodes.place(leaf, bounds);
    Ok(leaf)
}

/// Updates the ancestors of a leaf and calls `touched` with each and its new data.
pub(super) fn refit_above(
    topology: &Topology,
    nodes: &mut Nodes,
    leaf: u32,
    mut touched: impl FnMut(&Wear, u32, &Node),
) {
    let mut node = topology.nodes[leaf as usize].parent;
    while node != NO_NODE {
        let data = nodes.update(topology, node);
        touched(&nodes.wear, node, &data);
        node = topology.nodes[node as usize].parent;
    }
}

/// The queue of the search for a free leaf: the node with the least growth above it comes first;
/// among equals the deepest, which is nearest to a leaf.
pub(super) type Search = BinaryHeap<(Reverse<u32>, u32, u32)>;

/// The number of nodes that the search visits before it takes the first leaf within reach.
const SEARCHED_NODES: u32 = 512;

/// Returns the free leaf in which a box makes the boxes above it grow least in total (after
/// Bittner, Hapala and Havran 2015, "Incremental BVH construction for ray tracing").
fn free_leaf(
    topology: &Topology,
    nodes: &Nodes,
    search: &mut Search,
    bounds: &Aabb,
) -> Option<u32> {
    search.clear();
    let growth_above = |growth: f32, node: u32| {
        let before = &nodes.all[node as usize].bounds();
        growth + (before.union(bounds).half_area() - before.half_area()).max(0.0)
    };
    // Floats that are not negative sort like their bits.
    let waiting = |growth: f32, node: u32| {
        (Reverse(growth.to_bits()), topology.nodes[node as usize].level, node)
    };
    if nodes.all.first().is_some_and(|root| root.free() > 0) {
        search.push(waiting(0.0, 0));
    }
    let mut looked_at = 0;
    while let Some((Reverse(growth), _, node)) = search.pop() {
        let links = &topology.nodes[node as usize];
        if links.is_leaf() {
            return Some(node);
        }
        looked_at += 1;
        let growth = growth_above(f32::from_bits(growth), node);
        if looked_at == SEARCHED_NODES {
            // The search ends: from now on only nodes below this node count.
            search.clear();
        }
        let is_free = |child: &u32| nodes.all[*child as usize].free() > 0;
        search.extend(
            links.children(node).iter().filter(|c| is_free(c)).map(|c| waiting(growth, *c)),
        );
    }
    None
}
