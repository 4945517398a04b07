//! What the types of the lower rooms offer that needs the upper rooms.

pub(crate) mod adapters;
pub(crate) mod clocks;
#[cfg(feature = "loaded")]
pub(crate) mod open;
pub(crate) mod transfer;
