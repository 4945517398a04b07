//! How a hierarchy is changed, and what can be asked of it.

pub(crate) mod changes;
mod in_frustum;
mod ray;
