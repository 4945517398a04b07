//! The measured costs of a device.

use crate::table::handle;

/// The costs of tests and draws on a device, and of the ways to skip hidden draws.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraDeviceCosts {
    /// The number of the handle; 0 for none.
    pub id: u64,
}
handle!(AntumbraDeviceCosts = "cost list");
