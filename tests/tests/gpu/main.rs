//! The engine on both software drivers, under synchronization validation, without a window.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod c;
mod culling;
mod device;
mod hosts;
mod robustness;
mod shading;
mod shadows;
