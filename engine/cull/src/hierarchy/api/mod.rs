//! The changes and the queries of a hierarchy.

pub(crate) mod changes;
mod in_frustum;
mod ray;
pub(crate) mod whole;
