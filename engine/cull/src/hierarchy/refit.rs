//! Moves boxes in a hierarchy whose shape stays: only ancestors of what moved are touched.

use super::topology::{NO_NODE, Topology};
use super::{HierarchyError, check};
use crate::bounds::Aabb;
use crate::ids::ObjectId;

/// Kept between refits so that moving objects does not allocate.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Ancestors whose box has to be computed again.
    stale: Vec<u32>,
    /// Whether a node is among them.
    is_stale: Vec<bool>,
}

/// Sets the boxes of `moved` objects, then those of their ancestors, the deepest first.
pub(super) fn refit(
    topology: &Topology,
    bounds: &mut [Aabb],
    scratch: &mut Scratch,
    moved: impl IntoIterator<Item = (ObjectId, Aabb)>,
) -> Result<(), HierarchyError> {
    scratch.is_stale.resize(bounds.len(), false);
    let outcome = moved
        .into_iter()
        .try_for_each(|(object, target)| place(topology, bounds, scratch, object, target));
    // In pre-order children have larger numbers than their parents.
    scratch.stale.sort_unstable_by(|a, b| b.cmp(a));
    for node in scratch.stale.drain(..) {
        let [left, right] = topology.nodes[node as usize].children(node);
        bounds[node as usize] = bounds[left as usize].union(&bounds[right as usize]);
        scratch.is_stale[node as usize] = false;
    }
    outcome
}

/// Sets the box of one object and marks its ancestors up to the first that is marked.
fn place(
    topology: &Topology,
    bounds: &mut [Aabb],
    scratch: &mut Scratch,
    object: ObjectId,
    target: Aabb,
) -> Result<(), HierarchyError> {
    check(object.0 as usize, &target)?;
    let node = *topology
        .object_nodes
        .get(object.0 as usize)
        .ok_or(HierarchyError::UnknownObject { object })?;
    bounds[node as usize] = target;
    let mut parent = topology.nodes[node as usize].parent;
    while parent != NO_NODE && !scratch.is_stale[parent as usize] {
        scratch.is_stale[parent as usize] = true;
        scratch.stale.push(parent);
        parent = topology.nodes[parent as usize].parent;
    }
    Ok(())
}
