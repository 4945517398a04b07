//! The window programs `city` and `viewer`, and their head-up display.
//!
//! What they share with the measuring programs (options, cameras, reports, endings) is in `bench`.
#![forbid(unsafe_code)]

pub mod hud;
pub mod window;
