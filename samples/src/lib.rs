//! The window programs `city`, `shadows` and `viewer`, and their head-up display.
//!
//! The parts that they share with the measuring programs (options, cameras, reports, exit codes)
//! are in `bench`.
#![forbid(unsafe_code)]

pub mod hud;
pub mod window;
