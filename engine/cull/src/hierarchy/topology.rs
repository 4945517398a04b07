//! The shape of a hierarchy without its boxes: links between nodes in depth-first pre-order.

use std::collections::TryReserveError;

use crate::ids::ObjectId;

/// The parent of the root, and the right child of a leaf.
pub(crate) const NO_NODE: u32 = u32::MAX;

/// The links of a node to other nodes. The left child of an inner node is the next node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Links {
    pub(crate) right: u32,
    pub(crate) parent: u32,
    pub(crate) first_leaf: u32,
    /// 1 for a leaf, more for an inner node.
    pub(crate) leaf_count: u32,
    pub(crate) level: u32,
}

impl Links {
    #[inline]
    pub(crate) const fn is_leaf(&self) -> bool {
        self.leaf_count == 1
    }

    /// Returns the children of an inner node, whose index is `node`.
    #[inline]
    pub(crate) const fn children(&self, node: u32) -> [u32; 2] {
        [node + 1, self.right]
    }

    /// Returns the first node that is not in the subtree of `node`: a binary tree with n leaves has
    /// 2n - 1 nodes, which are contiguous here.
    pub(crate) const fn end(&self, node: u32) -> u32 {
        node + 2 * self.leaf_count - 1
    }
}

/// A node of the tree that is converted.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Split {
    Leaf(ObjectId),
    Inner(u32, u32),
}

/// All nodes and the order of the objects.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Topology {
    pub(crate) nodes: Vec<Links>,
    pub(crate) leaf_objects: Vec<ObjectId>,
    /// The node of each object's leaf.
    pub(crate) object_nodes: Vec<u32>,
}

impl Topology {
    /// Converts the tree below `root` to depth-first pre-order. Uses an explicit stack instead of
    /// recursion, because degenerate scenes make trees as deep as their number of objects.
    pub(crate) fn linearise(root: u32, object_count: usize, split: impl Fn(u32) -> Split) -> Self {
        let mut topology = Self::with_capacity(object_count, object_count);
        // The source node, its parent in the result, and its level.
        let mut stack = vec![(root, NO_NODE, 0_u32)];
        while let Some((source, parent, level)) = stack.pop() {
            let node = topology.nodes.len() as u32;
            // The left child directly follows its parent, so any other is a right child.
            if parent != NO_NODE && node != parent + 1 {
                topology.nodes[parent as usize].right = node;
            }
            let mut links = Links {
                right: NO_NODE,
                parent,
                first_leaf: topology.leaf_objects.len() as u32,
                leaf_count: 0,
                level,
            };
            match split(source) {
                Split::Leaf(object) => {
                    links.leaf_count = 1;
                    topology.object_nodes[object.0 as usize] = node;
                    topology.leaf_objects.push(object);
                }
                Split::Inner(left, right) => {
                    stack.push((right, node, level + 1));
                    stack.push((left, node, level + 1));
                }
            }
            topology.nodes.push(links);
        }
        // Children follow their parents, so backwards every count is complete when it is used.
        for node in (1..topology.nodes.len()).rev() {
            let Links { parent, leaf_count, .. } = topology.nodes[node];
            topology.nodes[parent as usize].leaf_count += leaf_count;
        }
        topology
    }

    /// Creates an empty shape with memory for `leaves` leaves, and no node for any object.
    pub(crate) fn with_capacity(leaves: usize, object_count: usize) -> Self {
        Self {
            nodes: Vec::with_capacity(2 * leaves),
            leaf_objects: Vec::with_capacity(leaves),
            object_nodes: vec![NO_NODE; object_count],
        }
    }

    /// Appends an inner node above `leaf_count` leaves, which must follow. The right child is not
    /// known yet.
    pub(crate) fn push_inner(&mut self, parent: u32, leaf_count: u32) -> u32 {
        let level = self.nodes.get(parent as usize).map_or(0, |links| links.level + 1);
        let first_leaf = self.leaf_objects.len() as u32;
        self.nodes.push(Links { right: NO_NODE, parent, first_leaf, leaf_count, level });
        self.nodes.len() as u32 - 1
    }

    /// The memory per leaf and its two nodes (bytes).
    pub(crate) const BYTES_PER_LEAF: usize =
        2 * size_of::<Links>() + size_of::<ObjectId>() + size_of::<u32>();

    /// Reserves memory for [`Topology::add_leaves`].
    pub(crate) fn try_reserve(&mut self, leaves: usize) -> Result<(), TryReserveError> {
        self.nodes.try_reserve_exact(2 * leaves)?;
        self.leaf_objects.try_reserve_exact(leaves)?;
        self.object_nodes.try_reserve_exact(leaves)
    }

    /// Adds uninitialised entries for more leaves and their nodes.
    pub(crate) fn add_leaves(&mut self, count: usize) {
        let none =
            Links { right: NO_NODE, parent: NO_NODE, first_leaf: 0, leaf_count: 1, level: 0 };
        let leaf_count = self.leaf_objects.len() + count;
        self.nodes.resize(self.nodes.len() + 2 * count, none);
        self.leaf_objects.resize(leaf_count, ObjectId(u32::MAX));
        self.object_nodes.resize(leaf_count, NO_NODE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a chain in which node 2k is inner: leaf 2k + 1 on the left, node 2k + 2 on the
    /// right.
    fn chain(objects: u32) -> Topology {
        Topology::linearise(0, objects as usize, |node| {
            if node == 2 * objects - 2 {
                Split::Leaf(ObjectId(objects - 1))
            } else if node % 2 == 1 {
                Split::Leaf(ObjectId(node / 2))
            } else {
                Split::Inner(node + 1, node + 2)
            }
        })
    }

    #[test]
    fn a_million_levels_need_no_recursion() {
        let objects = 1_000_000;
        let topology = chain(objects);
        assert_eq!(topology.nodes.len(), 1_999_999);
        assert_eq!(topology.nodes[0].leaf_count, objects);
        let last = topology.nodes[topology.nodes.len() - 1];
        assert_eq!((last.level, last.first_leaf), (objects - 1, objects - 1));
        assert!(topology.leaf_objects.iter().enumerate().all(|(i, o)| o.0 as usize == i));
    }

    #[test]
    fn subtrees_are_contiguous() {
        let topology = chain(5);
        for (number, links) in topology.nodes.iter().enumerate() {
            let end = links.end(number as u32);
            let leaves = (number as u32..end)
                .filter(|node| topology.nodes[*node as usize].is_leaf())
                .count();
            assert_eq!(leaves as u32, links.leaf_count);
            if !links.is_leaf() {
                let [left, right] = links.children(number as u32);
                assert_eq!(topology.nodes[left as usize].end(left), right);
                assert_eq!(topology.nodes[right as usize].end(right), end);
            }
        }
    }
}
