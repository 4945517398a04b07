//! The measured prices of a device.

use crate::table::handle;

/// The prices of tests and draws on a device, and of the ways to skip hidden draws.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AntumbraPrices {
    /// The number of the handle; 0 for none.
    pub id: u64,
}
handle!(AntumbraPrices = "price list");
