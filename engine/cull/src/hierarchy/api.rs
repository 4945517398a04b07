//! Changes and queries of a hierarchy.

pub(crate) mod changes;
mod in_frustum;
pub(crate) mod whole;
