//! The checks that a file must pass before it is used, one module per kind of object.

mod accessors;
mod animations;
mod attributes;
mod bounds;
mod budget;
mod extensions;
mod forest;
mod instancing;
mod materials;
mod meshes;
mod nodes;
mod numbers;
mod skins;
mod values;

use std::collections::BTreeMap;

use gltf::json::Root;

pub(crate) use accessors::views_and_accessors;
pub(crate) use bounds::check as bounds;
pub(crate) use extensions::required;
pub(crate) use forest::mend as forest;
pub use instancing::Instancing;
pub(crate) use values::indices_and_joints;

use crate::error::Fault;
use crate::verdict::Verdict;
use crate::{Limits, leave_out, prune};

/// Checks everything that depends only on the JSON, except views and accessors. Leaves only roots
/// in the shown scene, and leaves out parts that need a broken element.
///
/// Returns the instancing of meshes, by node.
pub(crate) fn structure(
    root: &mut Root,
    limits: &Limits,
    verdict: &mut Verdict,
) -> Result<BTreeMap<usize, Instancing>, Fault> {
    materials::check(root, verdict)?;
    meshes::note_without_positions(root, verdict);
    // Faults of elements often cause faults of the parts that need them, so these come first.
    leave_out::dependants(root, verdict)?;
    meshes::check(root, verdict)?;
    let parents = nodes::check(root, verdict)?;
    skins::check(root, &parents, verdict)?;
    prune::scene_roots(root, &parents, verdict);
    let instancing = instancing::check(root, verdict)?;
    leave_out::dependants(root, verdict)?;
    prune::channels(root, verdict);
    animations::check(root, verdict)?;
    budget::check(root, &instancing, limits, verdict)?;
    Ok(instancing)
}
