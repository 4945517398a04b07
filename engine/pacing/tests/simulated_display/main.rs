//! Tests of the pacer against a simulated presentation engine: seeded runs of every mode and kind
//! of feedback.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod display;
mod disturbances;
mod fixed_rate;
mod free_rate;
mod measure;
mod random;
mod run;
mod scenario;
mod timings;
mod unthrottled;
