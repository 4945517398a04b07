//! Rebuilds single subtrees in place. n leaves always have 2n - 1 nodes in depth-first pre-order,
//! so a subtree keeps its range of nodes and its range of leaves in any shape. The last subtree can
//! grow, because no nodes follow it.

use super::build;
use super::error::HierarchyError;
use super::journal::{FREE_LEAF, NEW_LEAF, Restructured};
use super::node::Node;
use super::refit::Nodes;
use super::topology::{Links, NO_NODE, Topology};
use super::wear::{LEAVES_MIN, LEAVES_PER_UPDATE, Wear};
use crate::geom::bounds::Aabb;
use crate::ids::ObjectId;

/// Subtrees that were found worn and wait for their rebuild.
#[derive(Clone, Debug, Default)]
pub(super) struct Worn {
    candidates: Vec<u32>,
    /// True for each node that is in `candidates`.
    is_candidate: Vec<bool>,
    /// Each candidate, with the area that its rebuild saves per leaf.
    ranked: Vec<(f32, u32)>,
}

impl Worn {
    /// Creates the lists of a hierarchy with `nodes` nodes, of which none is worn.
    pub(super) fn new(nodes: usize) -> Self {
        Self { is_candidate: vec![false; nodes], ..Self::default() }
    }

    /// Notes a refitted node, now with `data`, if its rebuild may be worthwhile.
    #[inline]
    pub(super) fn consider(&mut self, topology: &Topology, wear: &Wear, node: u32, data: &Node) {
        let leaves = topology.nodes[node as usize].leaf_count;
        let is_size = (LEAVES_MIN..=LEAVES_PER_UPDATE).contains(&leaves);
        if is_size && wear.excess(node, data).is_some() {
            self.is_candidate.resize(topology.nodes.len(), false);
            if !std::mem::replace(&mut self.is_candidate[node as usize], true) {
                self.candidates.push(node);
            }
        }
    }

    /// Fills `chosen` with the subtrees whose rebuild saves the most area per leaf, with at most
    /// `budget` leaves in total. A subtree may lie within another: the caller must check each again
    /// before its rebuild.
    pub(super) fn choose(
        &mut self,
        topology: &Topology,
        nodes: &Nodes,
        budget: u32,
        chosen: &mut Vec<u32>,
    ) {
        self.ranked.clear();
        self.candidates.retain(|node| {
            let excess = nodes.excess(*node);
            if let Some(excess) = excess {
                let leaves = topology.nodes[*node as usize].leaf_count;
                self.ranked.push((excess / leaves as f32, *node));
            }
            self.is_candidate[*node as usize] = excess.is_some();
            excess.is_some()
        });
        self.ranked.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut left = budget;
        for (_, node) in &self.ranked {
            let leaves = topology.nodes[*node as usize].leaf_count;
            if leaves <= left {
                left -= leaves;
                chosen.push(*node);
            }
        }
    }
}

/// Returns the topmost node that has at most `most_leaves` leaves and contains the last leaf: this
/// subtree can get more leaves without moving a node outside of it.
pub(super) fn last_subtree(topology: &Topology, most_leaves: u32) -> u32 {
    let mut node = 0;
    while topology.nodes[node as usize].leaf_count > most_leaves.max(1) {
        node = topology.nodes[node as usize].right;
    }
    node
}

/// Rebuilds the subtree of `root` from the boxes of its leaves and of `more` objects, and updates
/// the nodes above it. An empty box in `more` is a free leaf. The new leaves have the next ids. A
/// subtree that gets more leaves must contain the last leaf.
pub(super) fn rebuild_subtree(
    topology: &mut Topology,
    nodes: &mut Nodes,
    root: u32,
    more: &[Aabb],
) -> Result<Restructured, HierarchyError> {
    let top = topology.nodes[root as usize];
    let first = top.first_leaf as usize;
    let leaves = first..first + top.leaf_count as usize;
    let mut objects: Vec<ObjectId> = topology.leaf_objects[leaves].to_vec();
    let node_of = |object: &ObjectId| topology.object_nodes[object.0 as usize] as usize;
    let mut boxes: Vec<Aabb> =
        objects.iter().map(|object| nodes.all[node_of(object)].bounds()).collect();
    objects.extend((topology.leaf_objects.len() as u32..).take(more.len()).map(ObjectId));
    boxes.extend_from_slice(more);
    let built = build::topology(&boxes)?;
    let subtree = root as usize..top.end(root) as usize;
    let before = topology.nodes[subtree].iter().map(|links| links.leaf_count).collect();
    let moved_from = |object: &ObjectId| {
        if boxes[object.0 as usize].is_empty() {
            FREE_LEAF
        } else if object.0 >= top.leaf_count {
            NEW_LEAF
        } else {
            object.0
        }
    };
    let change = Restructured {
        root,
        before,
        after: built.nodes.iter().map(|links| links.leaf_count).collect(),
        moved_from: built.leaf_objects.iter().map(moved_from).collect(),
    };
    topology.add_leaves(more.len());
    nodes.add(2 * more.len());
    splice(topology, root, &top, &built, &objects);
    for (local, bounds) in built.object_nodes.iter().zip(&boxes) {
        nodes.place(root + local, *bounds);
    }
    nodes.build(topology, root);
    let mut above = top.parent;
    while above != NO_NODE {
        topology.nodes[above as usize].leaf_count += more.len() as u32;
        nodes.update(topology, above);
        above = topology.nodes[above as usize].parent;
    }
    Ok(change)
}

/// Replaces the links below `root`, whose own links were `top`, by the links of `built`. `objects`
/// maps the object indices of `built` to object ids.
fn splice(topology: &mut Topology, root: u32, top: &Links, built: &Topology, objects: &[ObjectId]) {
    for (node, links) in (root..).zip(&built.nodes) {
        let inside = |local: u32, outside: u32| {
            if local == NO_NODE { outside } else { local + root }
        };
        topology.nodes[node as usize] = Links {
            right: inside(links.right, NO_NODE),
            parent: inside(links.parent, top.parent),
            first_leaf: top.first_leaf + links.first_leaf,
            leaf_count: links.leaf_count,
            level: top.level + links.level,
        };
    }
    for (leaf, local) in (top.first_leaf as usize..).zip(&built.leaf_objects) {
        let object = objects[local.0 as usize];
        topology.leaf_objects[leaf] = object;
        topology.object_nodes[object.0 as usize] = root + built.object_nodes[local.0 as usize];
    }
}
