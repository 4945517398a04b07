//! Runs `walkthrough`, `budget`, `compare` and `gpu_page` as users do.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by panicking"
)]

mod bad_input;
mod budget;
#[cfg(feature = "charts")]
mod compare;
#[cfg(feature = "charts")]
mod gpu_page;
mod lights;
#[cfg(unix)]
mod results;
mod scene_files;
#[cfg(unix)]
mod scripts;
#[cfg(target_os = "linux")]
mod terminal;
mod whole_walk;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use harness::{Scratch, stderr};
use serde_json::Value;

const WALKTHROUGH: &str = env!("CARGO_BIN_EXE_walkthrough");

/// Returns `walkthrough` in `folder`.
fn walkthrough(folder: &Path, arguments: &[&str]) -> Command {
    harness::program(WALKTHROUGH, folder, arguments)
}

/// Runs a program to its end, which must be a success.
fn succeeded(command: &mut Command) -> Output {
    let output = command.output().expect("it starts");
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "needs `ci/setup --tests`, `. ci/env`: {message}");
    output
}

/// Runs a program to its end, which must be a refusal with that exit code: one line, and nothing on
/// standard output. Returns the line.
fn refusal(command: &mut Command, exit_code: i32) -> String {
    let output = command.output().expect("it starts");
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(exit_code), "{message}");
    assert!(message.starts_with("error: ") && !message.contains("panicked"), "{message}");
    assert_eq!(message.lines().count(), 1, "one sentence: {message}");
    assert!(output.stdout.is_empty());
    message
}

/// Returns what a program wrote to standard output.
fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Returns the report that a walk left in its folder.
fn report(scratch: &Scratch) -> Value {
    let text = fs::read_to_string(scratch.0.join("report.json")).expect("the report");
    serde_json::from_str(&text).expect("JSON")
}
