//! The C interface on a device.

mod interface;
