//! The errors of a hierarchy, and its limits.

use thiserror::Error;

use crate::geom::bounds::Aabb;
use crate::ids::ObjectId;

/// The most objects of one hierarchy: node ids stay below 2^31.
pub const MAX_OBJECTS: usize = 1 << 30;

/// The peak memory for building a hierarchy, per object (bytes).
pub const BUILD_BYTES_PER_OBJECT: usize = 296;

/// The reason why a hierarchy cannot be built or changed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum HierarchyError {
    /// A box has a coordinate that is infinite, NaN, or beyond
    /// [`MAX_COORDINATE`](crate::MAX_COORDINATE), or its minimum lies above its maximum.
    #[error(
        "object {} has no usable bounding box ({} to {}): \
         check its mesh and its transform for infinities and NaN", object.0, bounds.min, bounds.max
    )]
    BadBox {
        /// The id of the object.
        object: ObjectId,
        /// The box as it was given.
        bounds: Aabb,
    },
    /// The number of objects is above [`MAX_OBJECTS`].
    #[error("{count} objects are more than one hierarchy holds ({MAX_OBJECTS}): split the scene")]
    TooMany {
        /// The number of objects.
        count: usize,
    },
    /// The memory for a hierarchy, or for a view's history of it, is not available.
    #[error(
        "there is no memory to cull {count} objects (about {} MiB): use fewer, or end other programs",
        size_bytes.div_ceil(1 << 20)
    )]
    NoMemory {
        /// The number of objects.
        count: usize,
        /// The size of the request in bytes.
        size_bytes: usize,
    },
    /// The object was never in the hierarchy, or was removed.
    #[error(
        "object {} is not in the hierarchy: insert it, or rebuild the hierarchy with it", object.0
    )]
    UnknownObject {
        /// The id of the object.
        object: ObjectId,
    },
    /// The hierarchy has an object in every leaf.
    #[error(
        "the hierarchy has no free leaf: remove an object first, or build it with empty boxes as \
         room for more"
    )]
    NoFreeLeaf,
}

/// Checks that a box can be part of a hierarchy.
#[inline]
pub(super) fn check(object: usize, bounds: &Aabb) -> Result<(), HierarchyError> {
    if bounds.is_usable() {
        return Ok(());
    }
    Err(HierarchyError::BadBox {
        object: ObjectId(u32::try_from(object).unwrap_or(u32::MAX)),
        bounds: *bounds,
    })
}
