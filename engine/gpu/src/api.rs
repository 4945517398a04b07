//! Methods of types in lower modules that need the upper modules.

pub(crate) mod adapters;
pub(crate) mod adopt;
pub(crate) mod clocks;
pub(crate) mod faults;
pub(crate) mod host_frames;
#[cfg(feature = "loaded")]
pub(crate) mod open;
pub(crate) mod transfer;
