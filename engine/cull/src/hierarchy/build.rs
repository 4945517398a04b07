//! Finds the shape of a hierarchy with parallel locally-ordered clustering (Meister and Bittner
//! 2018, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction"), from
//! the crate `obvhs`.

use glam::{DVec3, Vec3, Vec3A};
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::chunks::{Chunks, append};
use super::error::{BUILD_BYTES_PER_OBJECT, HierarchyError, MAX_OBJECTS, check};
use super::topology::{NO_NODE, Split, Topology};
use crate::geom::bounds::Aabb;
use crate::ids::ObjectId;
use crate::rng::SplitMix64;

/// The random growth of the boxes that the clustering gets, relative to the scene. Equal distances
/// are its worst case: if all neighbours are equally good, only one pair is merged per pass, and a
/// row of equal boxes takes quadratic time. The growth also bounds the depth, because distances
/// below it look random.
const JITTER_OF_SCENE: f32 = 1.0 / (1 << 20) as f32;

/// The random growth relative to the box itself, for boxes that are large against their distance.
const JITTER_OF_BOX: f32 = 1.0 / 1024.0;

/// The number of first passes, over the chunks of a large hierarchy, in which a node looks at its
/// next neighbour alone. One such pass saves a fifth of the time and raises the surface-area cost
/// by 3 %.
const NEAR_PASSES: usize = 1;

/// Returns the shape of a good hierarchy over `boxes`. An [empty](Aabb::EMPTY) box becomes a free
/// leaf. Free leaves form a balanced subtree next to the rest, at the end of the leaves.
pub(super) fn topology(boxes: &[Aabb]) -> Result<Topology, HierarchyError> {
    check_capacity(boxes.len())?;
    let mut occupied = Vec::with_capacity(boxes.len());
    let mut free = Vec::new();
    for (object, bounds) in boxes.iter().enumerate() {
        if *bounds == Aabb::EMPTY {
            free.push(object as u32);
        } else {
            check(object, bounds)?;
            occupied.push(object as u32);
        }
    }
    if boxes.is_empty() {
        return Ok(Topology::default());
    }
    let chunks = Chunks::new(boxes, occupied);
    let near_passes = if chunks.is_split() { NEAR_PASSES } else { 0 };
    let mut clustering = Clustering { near_passes, ..Clustering::default() };
    if free.is_empty() && !chunks.is_split() {
        // All objects in their order: their positions are their numbers, and nothing is copied.
        return Ok(clustering.cluster(boxes, chunks.objects()));
    }
    let mut topology = Topology::with_capacity(boxes.len(), boxes.len());
    let root = if chunks.objects().is_empty() || free.is_empty() {
        NO_NODE
    } else {
        topology.push_inner(NO_NODE, boxes.len() as u32)
    };
    if !chunks.objects().is_empty() {
        chunks.append_to(&mut topology, root, |objects| clustering.cluster(boxes, objects));
    }
    if !free.is_empty() {
        let first = topology.nodes.len() as u32;
        if let Some(root) = topology.nodes.get_mut(root as usize) {
            root.right = first;
        }
        append(&mut topology, &free, &balanced(free.len() as u32), root);
    }
    Ok(topology)
}

/// Returns the shape of a balanced tree over leaves in any order.
fn balanced(leaves: u32) -> Topology {
    let mut topology = Topology::with_capacity(leaves as usize, leaves as usize);
    // The leaves, the node above them, and true if they are its right child.
    let mut waiting = vec![(0..leaves, NO_NODE, false)];
    while let Some((leaves, parent, is_right)) = waiting.pop() {
        let node = topology.push_inner(parent, leaves.len() as u32);
        if is_right {
            topology.nodes[parent as usize].right = node;
        }
        if leaves.len() == 1 {
            topology.object_nodes[leaves.start as usize] = node;
            topology.leaf_objects.push(ObjectId(leaves.start));
        } else {
            let middle = leaves.start.midpoint(leaves.end);
            waiting.push((middle..leaves.end, node, true));
            waiting.push((leaves.start..middle, node, false));
        }
    }
    topology
}

/// The memory of the clustering, which all chunks use.
#[derive(Default)]
struct Clustering {
    near_passes: usize,
    distinct: Vec<obvhs::aabb::Aabb>,
    builder: PlocBuilder,
    tree: Bvh2,
}

impl Clustering {
    /// Returns the shape over the `occupied` indices of `boxes`, by their position.
    fn cluster(&mut self, boxes: &[Aabb], occupied: &[u32]) -> Topology {
        let Self { near_passes, distinct, builder, tree } = self;
        make_distinct(boxes, occupied, distinct);
        let mut places = std::mem::take(&mut tree.primitive_indices);
        places.clear();
        places.extend(0..occupied.len() as u32);
        let reach = PlocSearchDistance::Medium;
        builder.build_with_bvh(tree, reach, distinct, places, SortPrecision::U64, *near_passes);
        Topology::linearise(0, occupied.len(), |node| {
            let node = &tree.nodes[node as usize];
            if node.is_leaf() {
                Split::Leaf(ObjectId(tree.primitive_indices[node.first_index as usize]))
            } else {
                Split::Inner(node.first_index, node.first_index + 1)
            }
        })
    }
}

/// Checks a number of objects against the limit of a hierarchy and against the available memory.
pub(super) fn check_capacity(count: usize) -> Result<(), HierarchyError> {
    check_count(count)?;
    check_memory(count)
}

/// Checks a number of objects against the limit of a hierarchy.
pub(super) fn check_count(count: usize) -> Result<(), HierarchyError> {
    if count > MAX_OBJECTS {
        return Err(HierarchyError::TooMany { count });
    }
    Ok(())
}

/// Allocates the memory of a build at once and frees it again: an allocation that fails in the
/// middle of the build would abort the program.
pub(super) fn check_memory(count: usize) -> Result<(), HierarchyError> {
    let size_bytes = count.saturating_mul(BUILD_BYTES_PER_OBJECT);
    let asked = Vec::<u8>::new().try_reserve_exact(size_bytes);
    asked.map_err(|_| HierarchyError::NoMemory { count, size_bytes })
}

/// Lists the `occupied` of the boxes, moved into the unit cube and made different from each other
/// by a jitter.
fn make_distinct(boxes: &[Aabb], occupied: &[u32], distinct: &mut Vec<obvhs::aabb::Aabb>) {
    let each = || occupied.iter().map(|object| &boxes[*object as usize]);
    let scene = each().fold(Aabb::EMPTY, |sum, next| sum.union(next));
    let origin = scene.min.as_dvec3();
    let size = (scene.max.as_dvec3() - origin).max_element();
    let scale = if size > 0.0 { 1.0 / size } else { 0.0 };
    let mut rng = SplitMix64::new(0x616e_7475_6d62_7261);
    let normalised = |point: Vec3| -> DVec3 { (point.as_dvec3() - origin) * scale };
    distinct.clear();
    distinct.extend(each().map(|bounds| {
        let min = normalised(bounds.min).as_vec3();
        let max = normalised(bounds.max).as_vec3();
        let reach = (max - min) * JITTER_OF_BOX + JITTER_OF_SCENE;
        let mut jitter = || Vec3::new(rng.unit(), rng.unit(), rng.unit()) * reach;
        obvhs::aabb::Aabb::new(Vec3A::from(min - jitter()), Vec3A::from(max + jitter()))
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_nodes_is_checked() {
        assert_eq!(check_count(MAX_OBJECTS), Ok(()));
        let refused = check_count(MAX_OBJECTS + 1).unwrap_err();
        assert!(refused.to_string().contains("1073741825"));
    }
}
