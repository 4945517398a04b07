//! The changes and the queries of a hierarchy.

pub(crate) mod changes;
mod in_frustum;
pub(crate) mod whole;
