//! What must hold before anything of a file is used: one file a sort of object.

mod accessors;
mod animations;
mod attributes;
mod bounds;
mod budget;
mod extensions;
mod instancing;
mod materials;
mod meshes;
mod nodes;
mod skins;
mod values;

use std::collections::BTreeMap;

use gltf::json::Root;
use gltf::json::mesh::Primitive;

pub(crate) use accessors::views_and_accessors;
pub(crate) use bounds::check as bounds;
pub(crate) use extensions::required;
pub(crate) use instancing::accessors as instance_accessors;
pub(crate) use materials::lights;
pub(crate) use values::indices_and_joints;

use crate::error::{Fault, Reason};
use crate::source::Instancing;
use crate::verdict::Verdict;
use crate::{Limits, SUPPORTED_EXTENSIONS, prune};

/// Checks all that the JSON alone can tell beyond views and accessors. Leaves only roots in the scene that is
/// shown.
///
/// Finds where meshes are instanced, by their nodes.
pub(crate) fn structure(
    root: &mut Root,
    limits: &Limits,
    verdict: &mut Verdict,
) -> Result<BTreeMap<usize, Instancing>, Fault> {
    materials::check(root, verdict)?;
    meshes::check(root, verdict)?;
    let parents = nodes::check(root, limits, verdict)?;
    skins::check(root, &parents, verdict)?;
    prune::scene_roots(root, &parents, verdict);
    animations::check(root, verdict)?;
    let instancing = instancing::check(root, verdict)?;
    budget::check(root, &instancing, (limits, verdict))?;
    Ok(instancing)
}

/// That an index is below a count.
fn in_range(what: &str, index: usize, count: usize) -> Result<(), Reason> {
    if index < count { Ok(()) } else { Err(Reason::out_of_range(what, index, count)) }
}

/// That numbers out of the JSON fit 32 bits: greater ones were rounded to infinity.
fn finite(what: &str, numbers: &[f32]) -> Result<(), Reason> {
    if numbers.iter().all(|number| number.is_finite()) {
        return Ok(());
    }
    Err(Reason::malformed(format!("its {what} is beyond what 32 bits can hold")))
}

/// Whether a file says that it uses an extension.
fn uses(root: &Root, extension: &str) -> bool {
    debug_assert!(SUPPORTED_EXTENSIONS.contains(&extension));
    root.extensions_used.iter().chain(&root.extensions_required).any(|used| used == extension)
}

/// How many vertices a primitive has: as many as any of its attributes, if it has one.
fn vertex_count(root: &Root, primitive: &Primitive) -> Option<u64> {
    let first = primitive.attributes.values().next().and_then(|&first| root.get(first));
    first.map(|first| first.count.0)
}
