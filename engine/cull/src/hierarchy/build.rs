//! Finds the shape of a hierarchy with parallel locally-ordered clustering (Meister and Bittner
//! 2018, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction"), from
//! the crate `obvhs`.

use glam::{DVec3, Vec3, Vec3A};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::topology::{Split, Topology};
use super::{HierarchyError, MAX_OBJECTS, check};
use crate::bounds::Aabb;
use crate::ids::ObjectId;
use crate::rng::SplitMix64;

/// Random growth of the boxes that the clustering sees, relative to the scene. Equal distances are
/// what it cannot stand: when all neighbours are equally good only one pair is merged in a pass,
/// and a row of equal boxes takes quadratic time. This also bounds the depth, since distances
/// below it look random.
const JITTER_OF_SCENE: f32 = 1.0 / (1 << 20) as f32;

/// The same relative to the box itself, for boxes that are large against their distance.
const JITTER_OF_BOX: f32 = 1.0 / 1024.0;

/// The shape of a good hierarchy over `boxes`.
pub(super) fn topology(boxes: &[Aabb]) -> Result<Topology, HierarchyError> {
    check_count(boxes.len())?;
    for (object, bounds) in boxes.iter().enumerate() {
        check(object, bounds)?;
    }
    if boxes.is_empty() {
        return Ok(Topology::default());
    }
    let count = boxes.len() as u32;
    let tree = PlocBuilder::new().build(
        PlocSearchDistance::Medium,
        &distinct(boxes),
        (0..count).collect(),
        SortPrecision::U64,
        0,
    );
    Ok(Topology::linearise(0, boxes.len(), |node| {
        let node = &tree.nodes[node as usize];
        if node.is_leaf() {
            Split::Leaf(ObjectId(tree.primitive_indices[node.first_index as usize]))
        } else {
            Split::Inner(node.first_index, node.first_index + 1)
        }
    }))
}

fn check_count(count: usize) -> Result<(), HierarchyError> {
    if count > MAX_OBJECTS {
        return Err(HierarchyError::TooMany { count });
    }
    Ok(())
}

/// The boxes moved into the unit cube and made different from each other.
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
            let (min, max) = (normalised(bounds.min).as_vec3(), normalised(bounds.max).as_vec3());
            let reach = (max - min) * JITTER_OF_BOX + JITTER_OF_SCENE;
            let mut jitter = || Vec3::new(rng.unit(), rng.unit(), rng.unit()) * reach;
            obvhs::aabb::Aabb::new(Vec3A::from(min - jitter()), Vec3A::from(max + jitter()))
        })
        .collect()
}

/// The box of every node, from those of the objects.
pub(super) fn node_bounds(topology: &Topology, boxes: &[Aabb]) -> Vec<Aabb> {
    let mut bounds = vec![Aabb::EMPTY; topology.nodes.len()];
    // Children follow their parents.
    for (node, links) in topology.nodes.iter().enumerate().rev() {
        bounds[node] = if links.is_leaf() {
            boxes[topology.leaf_objects[links.first_leaf as usize].0 as usize]
        } else {
            let [left, right] = links.children(node as u32);
            bounds[left as usize].union(&bounds[right as usize])
        };
    }
    bounds
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
