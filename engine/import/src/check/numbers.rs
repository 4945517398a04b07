//! Checks of numbers in the JSON, shared by several modules.

use gltf::json::Root;
use gltf::json::mesh::Primitive;

use crate::error::Reason;

/// Checks that an index is below a count.
pub(super) fn in_range(what: &str, index: usize, count: usize) -> Result<(), Reason> {
    if index < count { Ok(()) } else { Err(Reason::out_of_range(what, index, count)) }
}

/// Checks that numbers of the JSON fit 32 bits: greater ones were rounded to infinity.
pub(super) fn finite(what: &str, numbers: &[f32]) -> Result<(), Reason> {
    if numbers.iter().all(|number| number.is_finite()) {
        return Ok(());
    }
    Err(Reason::malformed(format!("its {what} is beyond what 32 bits can hold")))
}

/// Returns the number of vertices of a primitive, which is the count of any of its attributes;
/// `None` without attributes.
pub(super) fn vertex_count(root: &Root, primitive: &Primitive) -> Option<u64> {
    let first = primitive.attributes.values().next().and_then(|&first| root.get(first));
    first.map(|first| first.count.0)
}
