//! Makes a page with plots, a table and an image from a folder of walkthrough's reports.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bench::{compare, terminal};

fn main() -> ExitCode {
    terminal::run_program("warn", compare::run)
}
