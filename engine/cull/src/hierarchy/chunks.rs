//! Splits the objects of a large hierarchy into chunks of neighbours, each of which is clustered
//! separately: the work then fits the caches, and the nodes above the chunks split space evenly.
//! Clustering joins nodes that are near each other on a Morton curve. The higher a node, the less
//! the curve says about its neighbours.

use std::ops::Range;

use glam::Vec3;

use super::topology::{Links, NO_NODE, Topology};
use crate::geom::bounds::Aabb;
use crate::ids::ObjectId;

/// The most objects of a hierarchy that is clustered as a whole. Chunks save nothing in plans over
/// 10,000 objects, and up to a fifth over 40,000.
const OBJECTS_OF_WHOLE: usize = 1 << 14;

/// The number of objects up to which a part is not split further. Over 1,000,000 houses on a
/// square, chunks of 65,536, 16,384 and 4,096 objects give a surface-area cost of 89, 69 and 59;
/// clustering as a whole gives 161.
const OBJECTS_PER_CHUNK: usize = 1 << 12;

/// The bits of a cell number per axis.
const BITS_PER_AXIS: u32 = 5;

const CELLS: usize = 1 << (3 * BITS_PER_AXIS);

/// The objects of a hierarchy, sorted by the cell of a grid in which the centre of their box lies.
/// The cells are in the order of a Morton curve, so that each bit of a cell's number splits space.
pub(super) struct Chunks {
    objects: Vec<u32>,
    /// The first place in `objects` of each cell, and the end of the last.
    firsts: Vec<u32>,
}

impl Chunks {
    /// Sorts `objects`, which are indices of `boxes`.
    pub(super) fn new(boxes: &[Aabb], objects: Vec<u32>) -> Self {
        if objects.len() <= OBJECTS_OF_WHOLE {
            return Self { firsts: Vec::new(), objects };
        }
        let centres = || objects.iter().map(|object| boxes[*object as usize].centre());
        let all = centres().fold(Aabb::EMPTY, |sum, centre| sum.union(&Aabb::new(centre, centre)));
        let cells: Vec<u16> = centres().map(|centre| cell_of(centre, &all)).collect();
        let mut firsts = vec![0; CELLS + 1];
        cells.iter().for_each(|cell| firsts[usize::from(*cell) + 1] += 1);
        for cell in 0..CELLS {
            firsts[cell + 1] += firsts[cell];
        }
        let mut next = firsts.clone();
        let mut sorted = vec![0; objects.len()];
        for (cell, object) in cells.iter().zip(objects) {
            let place = &mut next[usize::from(*cell)];
            sorted[*place as usize] = object;
            *place += 1;
        }
        Self { objects: sorted, firsts }
    }

    pub(super) fn objects(&self) -> &[u32] {
        &self.objects
    }

    /// Returns true if there are several chunks.
    pub(super) fn is_split(&self) -> bool {
        !self.firsts.is_empty()
    }

    /// Appends the shape over all objects below the node `parent`, as its left child. `cluster`
    /// returns the shape over some objects, by their position in its argument.
    pub(super) fn append_to(
        &self,
        topology: &mut Topology,
        parent: u32,
        mut cluster: impl FnMut(&[u32]) -> Topology,
    ) {
        if !self.is_split() {
            append(topology, &self.objects, &cluster(&self.objects), parent);
            return;
        }
        // The cells, the node above them, and true if they are its right child.
        let mut waiting = vec![(0..CELLS, parent, false)];
        while let Some((cells, parent, is_right)) = waiting.pop() {
            let places = self.places(&cells);
            if is_right {
                topology.nodes[parent as usize].right = topology.nodes.len() as u32;
            }
            if places.len() <= OBJECTS_PER_CHUNK || cells.len() == 1 {
                let objects = &self.objects[places];
                append(topology, objects, &cluster(objects), parent);
                continue;
            }
            let [left, right] = self.halves(cells);
            if self.places(&left).is_empty() || self.places(&right).is_empty() {
                let full = if self.places(&left).is_empty() { right } else { left };
                waiting.push((full, parent, is_right));
                continue;
            }
            let node = topology.push_inner(parent, places.len() as u32);
            waiting.push((right, node, true));
            waiting.push((left, node, false));
        }
    }

    fn places(&self, cells: &Range<usize>) -> Range<usize> {
        self.firsts[cells.start] as usize..self.firsts[cells.end] as usize
    }

    fn halves(&self, cells: Range<usize>) -> [Range<usize>; 2] {
        let middle = cells.start.midpoint(cells.end);
        [cells.start..middle, middle..cells.end]
    }
}

/// Returns the number of the cell with `centre` in a grid over the box `all`.
fn cell_of(centre: Vec3, all: &Aabb) -> u16 {
    const CELLS_PER_AXIS: u32 = 1 << BITS_PER_AXIS;
    let size = (all.max - all.min).max_element().max(f32::MIN_POSITIVE);
    let cell = ((centre - all.min) / size * CELLS_PER_AXIS as f32).as_uvec3();
    let cell = cell.min(glam::UVec3::splat(CELLS_PER_AXIS - 1));
    (0..BITS_PER_AXIS).fold(0, |number, bit| {
        let bits = cell >> bit & 1;
        number | ((bits.x | bits.y << 1 | bits.z << 2) << (3 * bit)) as u16
    })
}

/// Appends the shape `part` over `objects` below the node `parent`.
pub(super) fn append(topology: &mut Topology, objects: &[u32], part: &Topology, parent: u32) {
    let first = topology.nodes.len() as u32;
    let first_leaf = topology.leaf_objects.len() as u32;
    let level = topology.nodes.get(parent as usize).map_or(0, |links| links.level + 1);
    let inside = |node: u32, outside: u32| if node == NO_NODE { outside } else { node + first };
    topology.nodes.extend(part.nodes.iter().map(|links| Links {
        right: inside(links.right, NO_NODE),
        parent: inside(links.parent, parent),
        first_leaf: links.first_leaf + first_leaf,
        leaf_count: links.leaf_count,
        level: links.level + level,
    }));
    for local in &part.leaf_objects {
        let object = objects[local.0 as usize];
        topology.leaf_objects.push(ObjectId(object));
        topology.object_nodes[object as usize] = first + part.object_nodes[local.0 as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::build;

    /// Checks that subtrees are contiguous, that the links fit each other and that each object has
    /// one leaf.
    fn check(topology: &Topology, objects: usize) {
        assert_eq!(topology.nodes.len(), 2 * objects - 1);
        for (node, links) in (0..).zip(&topology.nodes) {
            if links.is_leaf() {
                let object = topology.leaf_objects[links.first_leaf as usize];
                assert_eq!(topology.object_nodes[object.0 as usize], node);
                continue;
            }
            let children = links.children(node);
            let [left, right] = children.map(|child| topology.nodes[child as usize]);
            for child in [left, right] {
                assert_eq!((child.parent, child.level), (node, links.level + 1));
            }
            assert_eq!(left.end(children[0]), children[1]);
            assert_eq!(right.end(children[1]), links.end(node));
            assert_eq!(left.first_leaf, links.first_leaf);
            assert_eq!(right.first_leaf, links.first_leaf + left.leaf_count);
        }
    }

    #[test]
    fn the_shape_is_well_formed_whether_objects_share_a_cell_or_not() {
        const COUNT: usize = OBJECTS_OF_WHOLE + 3_000;
        for outlier in [0.0, 1.0e12] {
            for free in [0, 1, 500] {
                let mut boxes: Vec<Aabb> = (0..COUNT)
                    .map(|n| Vec3::new((n % 257) as f32, (n % 7) as f32, (n / 257) as f32))
                    .map(|corner| Aabb::new(corner, corner + 0.5))
                    .collect();
                boxes[7].max.x += outlier;
                boxes[20..20 + free].fill(Aabb::EMPTY);
                check(&build::topology(&boxes).unwrap(), COUNT);
            }
        }
    }
}
