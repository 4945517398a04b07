//! Measures the costs of a device and makes its page.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::{gpu_page, terminal};

fn main() -> ExitCode {
    terminal::run_program("warn", gpu_page::run)
}
