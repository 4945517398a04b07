//! The methods of lower rooms' types that need the upper rooms.

pub(crate) mod adapters;
pub(crate) mod adopt;
pub(crate) mod clocks;
pub(crate) mod host_frames;
#[cfg(feature = "loaded")]
pub(crate) mod open;
pub(crate) mod transfer;
