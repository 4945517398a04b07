//! A Vulkan loader whose devices lack what phones often lack.

use std::fs;
use std::process::{Command, Output};

use crate::loader_library::LoaderLibrary;

/// The number of kinds of features and limits that the loader must have hidden: lavapipe of Mesa
/// 22.3 has all but descriptor indexing.
const LEAST_HIDDEN: u32 = 9;

/// The loader. `phone_loader.c` lists what its devices lack.
pub struct PhoneLoader(LoaderLibrary);

impl PhoneLoader {
    /// Compiles the loader into a folder of this name.
    pub fn new(name: &str) -> Self {
        Self(LoaderLibrary::compile(name, include_str!("phone_loader.c")))
    }

    /// Runs a program with the loader, and checks that features were hidden from it and that it
    /// ends well.
    pub fn run(&self, mut program: Command) -> Output {
        let hidden = self.0.folder.0.join("hidden");
        self.0.give(&mut program);
        let output = program.env("HIDDEN", &hidden).output().expect("it starts");
        assert!(output.status.success(), "{}", crate::stderr(&output));
        let count = fs::read_to_string(&hidden).expect("it was written");
        assert!(count.parse::<u32>().expect("a number") >= LEAST_HIDDEN, "{count} hidden");
        fs::remove_file(hidden).expect("it is there");
        output
    }
}
