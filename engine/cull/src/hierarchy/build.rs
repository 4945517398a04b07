//! Finds the shape of a hierarchy with parallel locally-ordered clustering (Meister and Bittner
//! 2018, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction"), from
//! the crate `obvhs`.

use glam::{DVec3, Vec3, Vec3A};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::error::{BUILD_BYTES_PER_OBJECT, HierarchyError, MAX_OBJECTS, check};
use super::topology::{Split, Topology};
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
    let mut nodes = balanced(&free);
    let spare_root = (!free.is_empty()).then_some(0);
    let root = cluster(boxes, occupied, &mut nodes);
    let root = match (root, spare_root) {
        (Some(left), Some(right)) => {
            nodes.push(Split::Inner(left, right));
            nodes.len() as u32 - 1
        }
        (Some(root), None) | (None, Some(root)) => root,
        (None, None) => 0,
    };
    Ok(Topology::linearise(root, boxes.len(), |node| nodes[node as usize]))
}

/// Returns a balanced tree over leaves in any order; node 0 is its root.
fn balanced(objects: &[u32]) -> Vec<Split> {
    let mut nodes = Vec::new();
    let mut waiting = Vec::new();
    if !objects.is_empty() {
        nodes.push(Split::Inner(0, 0));
        waiting.push((0, objects));
    }
    while let Some((node, objects)) = waiting.pop() {
        nodes[node] = match objects {
            [object] => Split::Leaf(ObjectId(*object)),
            _ => {
                let (left, right) = objects.split_at(objects.len() / 2);
                let child = nodes.len();
                nodes.extend([Split::Inner(0, 0); 2]);
                waiting.extend([(child, left), (child + 1, right)]);
                Split::Inner(child as u32, child as u32 + 1)
            }
        };
    }
    nodes
}

/// Appends the clustered tree over the `occupied` indices of `boxes` to `nodes` and returns its
/// root.
fn cluster(boxes: &[Aabb], occupied: Vec<u32>, nodes: &mut Vec<Split>) -> Option<u32> {
    if occupied.is_empty() {
        return None;
    }
    let present: Vec<Aabb> = occupied.iter().map(|object| boxes[*object as usize]).collect();
    let tree = PlocBuilder::new().build(
        PlocSearchDistance::Medium,
        &distinct(&present),
        (0..present.len() as u32).collect(),
        SortPrecision::U64,
        0,
    );
    let root = nodes.len() as u32;
    nodes.extend(tree.nodes.iter().map(|node| {
        if node.is_leaf() {
            let place = tree.primitive_indices[node.first_index as usize];
            Split::Leaf(ObjectId(occupied[place as usize]))
        } else {
            Split::Inner(root + node.first_index, root + node.first_index + 1)
        }
    }));
    Some(root)
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

/// Returns the boxes moved into the unit cube and made different from each other by a jitter.
fn distinct(boxes: &[Aabb]) -> Vec<obvhs::aabb::Aabb> {
    let scene = boxes.iter().fold(Aabb::EMPTY, |sum, next| sum.union(next));
    let origin = scene.min.as_dvec3();
    let size = (scene.max.as_dvec3() - origin).max_element();
    let scale = if size > 0.0 { 1.0 / size } else { 0.0 };
    let mut rng = SplitMix64::new(0x616e_7475_6d62_7261);
    let normalised = |point: Vec3| -> DVec3 { (point.as_dvec3() - origin) * scale };
    boxes
        .iter()
        .map(|bounds| {
            let min = normalised(bounds.min).as_vec3();
            let max = normalised(bounds.max).as_vec3();
            let reach = (max - min) * JITTER_OF_BOX + JITTER_OF_SCENE;
            let mut jitter = || Vec3::new(rng.unit(), rng.unit(), rng.unit()) * reach;
            obvhs::aabb::Aabb::new(Vec3A::from(min - jitter()), Vec3A::from(max + jitter()))
        })
        .collect()
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
