//! Tests of the decision logic against a simulated GPU: a small software depth buffer executes the
//! plans, and its answers come back late, out of order, twice, or never.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod blocking;
mod casters;
mod device;
mod device_costs;
mod exactness;
mod explain;
mod image;
mod in_frustum;
mod invariants;
mod knowledge;
mod learned_costs;
mod learning;
mod moving;
mod multi_view;
mod next_frame;
mod optics;
mod projections;
mod query_shares;
mod random;
mod raster;
mod recycling;
mod rest;
mod scene;
mod section;
mod sequences;
mod talk;
mod tester_support;
mod threshold;
mod walk;
mod work;
