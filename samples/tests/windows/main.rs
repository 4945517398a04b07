//! Runs the window programs as users do: in windows of X and Wayland servers without a screen, and
//! without.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by panicking"
)]

mod city;
mod city_devices;
mod city_keys;
mod city_script;
mod city_window;
#[cfg(target_os = "linux")]
mod faults;
mod fly_out;
mod lights;
#[cfg(target_os = "linux")]
mod phone;
mod running;
mod scene_images;
#[cfg(target_os = "linux")]
mod terminal;
mod viewer_files;
mod viewer_window;
#[cfg(unix)]
mod wine;

const CITY: &str = env!("CARGO_BIN_EXE_city");
const TRIANGLE: &str = env!("CARGO_BIN_EXE_triangle");
const VIEWER: &str = env!("CARGO_BIN_EXE_viewer");
