//! Runs programs as users do: in folders of their own, in terminals, with scenes that are generated
//! here.
// A harness fails by panicking.
#![allow(clippy::panic, clippy::expect_used)]
#![forbid(unsafe_code)]

mod faulty_loader;
mod loader_library;
mod phone_loader;
mod pixels;
mod program;
pub mod scene;
pub mod terminal;

pub use faulty_loader::assert_faults_end_programs;
pub use phone_loader::PhoneLoader;
pub use pixels::pixels;
pub use program::{Scratch, cache, edited_shaders, program, signalled_program, stderr};
