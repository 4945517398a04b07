//! The window programs `city` and `viewer`, and their head-up display.
//!
//! Parts that they share with the measuring programs (options, cameras, reports, exit codes) are in
//! `bench`.
#![forbid(unsafe_code)]

pub mod hud;
pub mod window;
