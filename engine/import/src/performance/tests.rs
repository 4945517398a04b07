//! Tests of a performance: what changes when, without a device.
